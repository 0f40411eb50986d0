#pragma once
/// How far estimates of errors of force and stress, and promises of them, can be trusted on unseen scenes.

#include "bench/bench_report.hpp"
#include "maille/scene/answer.hpp"

#include <optional>
#include <vector>

namespace maille::lab {

/// By quadratic elements, on cells of half the side where four seconds afford that; at the nodes of `scene`,
/// with reactions and energy. Nothing where they have no answer.
std::optional<Answer> true_mechanics(const Scene& scene, const Control& control);

/// Asks `relaxed` and `coupled`, which know forces, about 50 scenes drawn by a fixed seed (quick: 5): boxes,
/// ellipsoids, bellies with tendons and strips; pulled, bent and poked; isotropic with Poisson's ratio 0 to
/// 0.49, muscles and other tissue with fibres. Estimates the errors of force, energy, strain and stress of
/// their answers, and holds them against true_mechanics().
///
/// Adds a row an answer, and one a method. @return `estimate_reliability_force` and `..._stress`: of all
/// answers that have such a true error the fraction whose estimate is within a factor of 2 of it. Of energy
/// and strain it is in rows alone.
/// Cost  minutes on one thread
std::vector<BenchCheck> mechanics_estimate_checks(const BenchOptions& options, const Control& control,
                                                  BenchReport& report);

/// Asks choose() for errors of force of 5, 10, 20 and 40 % by turns on 40 scenes of UnseenScenes (quick: 4),
/// does what was chosen, and holds its force against true_mechanics(). Adds a row a promise.
/// @return `choose_force_kept`, the fraction of promises that were kept, and `choose_force_refused`, that of
///         scenes on which nothing was promised
std::vector<BenchCheck> choose_force_checks(const BenchOptions& options, const Control& control,
                                            BenchReport& report);

} // namespace maille::lab
