#pragma once
/// Forces over the steps of a scene: points, columns and a plot.

#include "compare/comparison.hpp"
#include "results/result_table.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct CurvePoint {
  int step = 0;
  double fraction = 0; ///< fraction of the moves and loads
  double largest_displacement = 0;
  std::optional<Vec3> move_force, hold_force; ///< sums over all moves or holds, world's frame [N]
  std::optional<double> strain_energy;
};

/// The steps of one method, without the body at rest.
struct ForceCurve {
  std::string method;
  std::vector<CurvePoint> points;
};

/// @param steps  one comparison of a single method per step, with mechanics; steps without an answer are
/// skipped
/// @param n_steps  number of steps of the whole series
ForceCurve force_curve(const Scene& scene, const std::string& method, const std::vector<Comparison>& steps,
                       int n_steps);

const ResultTable<CurvePoint>& columns_of_curve();

/// Plots the magnitude of the force on moves (on holds without moves) and the strain energy over the largest
/// displacement: one line per method, starting at rest.
/// @param file *.svg, else PNG; replaced atomically
/// @return the reason of a failure, or nothing @throws std::filesystem::filesystem_error
std::optional<std::string> draw_curves(const Scene& scene, const std::vector<ForceCurve>& curves,
                                       const std::filesystem::path& file);

} // namespace maille::studies
