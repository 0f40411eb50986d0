#pragma once
/// How long studies take, and how well what is learnt from them serves: `studies/lab/run studies`.

#include "bench/bench_report.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maille::lab {

/// One run, each part below adding its rows and checks. An hour and more; interrupted, it reports what it
/// has.
BenchReport bench_studies(const BenchOptions& options, const Control& control);

/// Its parts on estimated errors, and on promises, alone.
BenchReport bench_estimates(const BenchOptions& options, const Control& control);
BenchReport bench_choices(const BenchOptions& options, const Control& control);

/// Draws unseen scenes with a fixed seed, asks choose() with the built-in table for a random wish each, does
/// what it chose, and measures that against the best reference: error as it comes, time as the median of
/// three. Goes on until 56 scenes have got a promise (6 with options.quick), or 300 seconds of the processor
/// are over. Promises of less error than the reference's own cannot be judged and are passed over. Adds a row
/// a promise, and the checks choose_error_kept, choose_time_kept (parts of the promises) and choose_scenes
/// (promises).
void add_choose_checks(const BenchOptions& options, const Control& control, BenchReport& report);

/// Asks for 5, 10, 20 and 40 % by turns on the scenes of unlike_scenes (quick: two of them), does what was
/// chosen, and holds it against the best reference that a minute affords; promises whose reference is
/// not known to be within the wish are not counted.
///
/// A row a promise, and the checks `choose_unlike_kept`, the fraction of promises whose error is within the
/// wish, and `choose_unlike_refused`, the fraction of scenes on which nothing was promised.
void add_choose_unlike_checks(const BenchOptions& options, const Control& control, BenchReport& report);

/// A random scene.
struct DrawnScene {
  std::string name; ///< e.g. `12: ellipsoid 12 x 10 x 9, bend, muscle/soleus`
  std::string text; ///< TOML
};

/// Scenes of boxes, ellipsoids and bellies, pulled, bent and poked, of isotropic matter with Poisson's
/// ratio 0 to 0.49, of muscles and of other tissue, 8 to 14 cells an axis, in this order of shapes by turns.
/// Repeatable: the same scenes for the same arguments on any machine
std::vector<DrawnScene> draw_scenes(int n, std::uint32_t seed);

/// Asks `limits`, `relaxed`, `sweep` and `coupled` about 42 drawn scenes (quick: 6), estimates the errors of
/// their answers, and holds them against the true ones: against quadratic elements, on boxes on cells of half
/// the side.
///
/// Adds a row a scene and method, one row of what was found for every method, and the check
/// `estimate_reliability`: the fraction of all answers, those without an estimate included, whose estimated
/// relative L2 error is within a factor of 2 of the true one.
void check_estimates(const BenchOptions& options, const Control& control, BenchReport& report);

/// Asks `coupled` about the scenes of kind_scenes (quick: two of them), estimates the errors of its answers,
/// and holds them against quadratic elements: on boxes on cells of half the side, elsewhere the best that ten
/// seconds afford.
///
/// A row a scene, and over the scenes that have an estimate the checks `estimate_kinds_below`, the fraction
/// whose true error is at most the estimated one, and `estimate_kinds_within_2`, whose estimate is within a
/// factor of 2; `estimate_kinds_estimated` is the fraction of scenes that have one.
void check_estimate_kinds(const BenchOptions& options, const Control& control, BenchReport& report);

/// The study of studies/anisotropy/cube_200.toml, on 33^3 nodes: check study_200_seconds. Two cases at a
/// time, one thread each; the reference is solved once a case. Quick: its first two cases.
/// @pre  this process has started no threads: cases run in processes forked from it
void bench_study_200(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
