#pragma once
/// Forces, strain, stress and energy of an answer, as text for people and as JSON; of a series as a curve.

#include "maille/studies/comparison.hpp"
#include "results/result_table.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>

namespace maille::studies {

/// A row a label, a material or the whole body.
const ResultTable<PartMechanics>& columns_of_parts();
/// A row a hold, a move or a load.
const ResultTable<Resultant>& columns_of_resultants();

/// conventions, energy, holds, moves, loads, labels, materials, body
nlohmann::ordered_json in_json(const Mechanics& mechanics);
/// A table of the labels and the body; without labels of the materials, of which one is the body.
std::string in_words(const Mechanics& mechanics);

/// The sum of their forces; nothing where there are none.
std::optional<Vec3> sum_of(const std::vector<Resultant>& resultants);
/// `(0.17, 0, 0)`: components that are rounding beside the largest are 0.
std::string force_in_words(std::span<const double> force);

/// A column of CSV an axis of the world. @param path to the force, perhaps optional
template<class Row, class... Path>
void add_force(ResultTable<Row>& columns, const std::string& name, Path... path) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns.add({fmt::format("{}_force_{}_n", name, "xyz"[axis]), "", "N", "on the body, N/m in 2D"}, path...,
                [axis](const Vec3& force) { return force[axis]; });
}

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
/// @return why there is no picture: no method has forces, or no gnuplot
/// @throws std::runtime_error where gnuplot fails; std::filesystem::filesystem_error
std::optional<std::string> draw_curves(const Scene& scene, const std::vector<ForceCurve>& curves,
                                       const std::filesystem::path& file);

} // namespace maille::studies
