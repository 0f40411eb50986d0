#include "maille/scene/measure/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace maille {

namespace {

/// Values below this fraction of their summands are rounding error.
constexpr double negligible = 1e-6;

std::vector<std::string> columns_of(const std::string& name, bool is_vector, bool is_line) {
  if (is_line)
    return {};
  std::vector<std::string> names{name};
  for (const char* axis : {"_x", "_y", "_z"})
    if (is_vector)
      names.push_back(name + axis);
  return names;
}

/// Numbers of a value, or of all points of a line.
struct Figures {
  std::vector<std::optional<double>> list;

  void add(const std::optional<double>& value, const std::optional<Vec3>& vector, bool is_vector) {
    if (!is_vector)
      list.push_back(value);
    else
      for (std::size_t a = 0; a < 3; ++a)
        list.push_back(vector ? std::optional((*vector)[a]) : std::nullopt);
  }
};

Figures figures_of(const MeasuredValue& value) {
  Figures figures;
  if (!value.is_line)
    figures.add(value.value, value.vector, value.is_vector);
  for (const LinePoint& point : value.line)
    figures.add(point.value, point.vector, value.is_vector || point.vector.has_value());
  return figures;
}

} // namespace

std::string_view to_string(MeasureKind kind) {
  constexpr std::array<std::string_view, 8> names{"force",  "displacement", "strain", "stress",
                                                  "length", "angle",        "volume", "energy"};
  return names.at(static_cast<std::size_t>(kind));
}

std::vector<std::string> Measure::columns() const {
  return columns_of(name, is_vector(), is_line);
}

std::vector<std::pair<std::string, std::optional<double>>> MeasuredValue::columns() const {
  std::vector<std::pair<std::string, std::optional<double>>> all;
  for (const std::string& column : columns_of(name, is_vector, is_line)) {
    const std::size_t i = all.size();
    all.emplace_back(column, i == 0 ? value : vector ? std::optional((*vector)[i - 1]) : std::nullopt);
  }
  return all;
}

std::string_view unit_of(const Measure& measure, int dimension) {
  constexpr std::array<std::string_view, 3> volumes{"m", "m^2", "m^3"};
  switch (measure.kind) {
  case MeasureKind::force:
    return dimension == 2 ? "N/m" : "N";
  case MeasureKind::stress:
    return "Pa";
  case MeasureKind::energy:
    return dimension == 2 ? "J/m" : "J";
  case MeasureKind::angle:
    return "rad";
  case MeasureKind::displacement:
    return "m";
  case MeasureKind::length:
    return measure.figure == MeasureFigure::relative ? "" : "m";
  case MeasureKind::volume:
    return measure.figure == MeasureFigure::relative ? ""
                                                     : volumes.at(static_cast<std::size_t>(dimension) - 1);
  case MeasureKind::strain:
    break;
  }
  return "";
}

std::string in_words(const Measure& measure) {
  constexpr std::array<std::string_view, 21> figures{"",
                                                     "change of ",
                                                     "relative change of ",
                                                     "",
                                                     "size of ",
                                                     "",
                                                     "stretch of ",
                                                     "Green-Lagrange ",
                                                     "logarithmic ",
                                                     "fibre ",
                                                     "largest principal ",
                                                     "smallest principal ",
                                                     "xx of ",
                                                     "yy of ",
                                                     "zz of ",
                                                     "xy of ",
                                                     "yz of ",
                                                     "xz of ",
                                                     "von Mises ",
                                                     "pressure: ",
                                                     "nominal "};
  std::string text =
      fmt::format("{}{}{}{}", figures.at(static_cast<std::size_t>(measure.figure)), to_string(measure.kind),
                  measure.where.starts_with(',') ? "" : " ", measure.where);
  if (measure.figure == MeasureFigure::along)
    text += fmt::format(", along ({:.4g}, {:.4g}, {:.4g})", measure.direction[0], measure.direction[1],
                        measure.direction[2]);
  return text;
}

bool is_reserved_name(std::string_view name) {
  constexpr std::array<std::string_view, 69> reserved{
      // columns of every table
      "scene", "method", "status", "message", "setup_s", "solve_s", "total_s", "bytes", "iterations",
      "limit_violation", "relative_l2", "relative_max", "rms_m", "reference", "algorithm", "test_reaction",
      "test_stiffness", "test_apparent_modulus", "test_failure",
      // columns of compare and run
      "estimated_relative_l2", "estimated_force", "estimated_strain_energy", "estimated_strain",
      "estimated_stress", "move_force_x_n", "move_force_y_n", "move_force_z_n", "hold_force_x_n",
      "hold_force_y_n", "hold_force_z_n", "strain_energy_j", "force_error", "strain_energy_error",
      "strain_error", "stress_error", "recovered_stress_error", "step", "fraction", "measures",
      // columns of study
      "study", "case", "cases", "repetitions", "timing", "processor_share", "load_average", "force",
      "strain_energy", "reference_relative_l2", "reference_relative_max", "reference_rms_m", "dimension",
      "cells", "nodes", "threads", "maille", "hash", "vtk",
      // columns of trade
      "halvings", "tolerance", "wall_s", "predicted_error", "predicted_s", "front", "probe_halvings",
      "reference_l2",
      // quantities with error targets in choose
      "displacement", "energy", "stress"};
  return std::ranges::find(reserved, name) != reserved.end();
}

std::optional<double> relative_error(const MeasuredValue& value, const MeasuredValue& reference) {
  const Figures found = figures_of(value), wanted = figures_of(reference);
  if (found.list.size() != wanted.list.size())
    return std::nullopt;
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < wanted.list.size(); ++i)
    if (found.list[i] && wanted.list[i]) {
      difference = std::hypot(difference, *found.list[i] - *wanted.list[i]);
      size = std::hypot(size, *wanted.list[i]);
    }
  return size > negligible * reference.scale && size > 0 ? std::optional(difference / size) : std::nullopt;
}

std::vector<Measure> refined(const std::vector<Measure>& measures, const Scene& scene, const Scene& fine) {
  const Grid &grid = scene.specimen.grid, &fine_grid = fine.specimen.grid;
  const auto half = [](const Index3& at) { return Index3{at[0] / 2, at[1] / 2, at[2] / 2}; };
  /// True if all coarse nodes that a fine one lies between belong to the measure.
  const auto has_node = [&](const Measure& measure, const Index3& at) {
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      Index3 coarse = half(at);
      bool counts = true;
      for (std::size_t a = 0; a < 3; ++a)
        if (corner >> a & 1) {
          counts = counts && at[a] % 2 != 0;
          ++coarse[a];
        }
      if (counts && !std::ranges::binary_search(measure.nodes, grid.node(coarse)))
        return false;
    }
    return true;
  };
  std::vector<Measure> finer = measures;
  for (std::size_t i = 0; i < measures.size(); ++i) {
    for (MaterialPoint& point : finer[i].points)
      point = located(fine.specimen, point.place);
    finer[i].cells.clear();
    for (std::int64_t cell = 0; cell < fine_grid.n_cells() && !measures[i].cells.empty(); ++cell)
      if (std::ranges::binary_search(measures[i].cells, grid.cell(half(fine_grid.cell_at(cell)))))
        finer[i].cells.push_back(cell);
    finer[i].nodes.clear();
    for (std::int64_t node = 0; node < fine_grid.n_nodes() && !measures[i].nodes.empty(); ++node)
      if (const Index3 at = fine_grid.node_at(node); has_node(measures[i], at) && fine.specimen.is_node(at))
        finer[i].nodes.push_back(node);
  }
  return finer;
}

} // namespace maille
