#pragma once
/// How far the estimated error (deform::estimate_error) can be trusted: part of `maille bench studies`.

#include "maille/studies/bench_report.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maille::studies {

/// A scene drawn by lot.
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

} // namespace maille::studies
