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
  double fraction = 0; ///< of the moves and loads
  double largest_displacement = 0;
  std::optional<Vec3> move_force, hold_force; ///< sums over all of them, world's frame [N]
  std::optional<double> strain_energy;
};

/// The steps of one method, without the body at rest.
struct ForceCurve {
  std::string method;
  std::vector<CurvePoint> points;
};

/// @param steps  a comparison of one method a step, with mechanics; those without an answer are passed over
/// @param n_steps  of the whole series
ForceCurve force_curve(const Scene& scene, const std::string& method, const std::vector<Comparison>& steps,
                       int n_steps);

const ResultTable<CurvePoint>& columns_of_curve();

/// Draws the size of the force on moves, on holds where there are no moves, and the strain energy over the
/// largest displacement: a line a method, from the body at rest on.
/// @param file *.svg, else PNG; replaced at once
/// @return why there is no picture @throws std::filesystem::filesystem_error
std::optional<std::string> draw_curves(const Scene& scene, const std::vector<ForceCurve>& curves,
                                       const std::filesystem::path& file);

} // namespace maille::studies
