// Strain, stress, energy and volume of labels, materials and the whole body.
#include "maille/scene/mechanics/mechanics.hpp"

#include "maille/scene/cell_fields.hpp"
#include "maille/scene/sliding.hpp"
#include "mechanics/volume_ratio.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace maille {

namespace {

using Cells = std::vector<std::int64_t>;
using Tensor = std::array<double, 6>;

/// Figures of cells, by their numbers on the grid; empty where there is none.
struct CellFigures {
  std::vector<double> volume, fibre_strain, largest_strain, smallest_strain, fibre_stress, von_mises,
      pressure, energy;
};

double cell_volume(const Grid& grid) {
  double volume = 1;
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
    volume *= grid.spacing()[a];
  return volume;
}

/// Half of the elastic stress by the strain, both means of the cell.
double energy_of_means(const Tensor& strain, const Tensor& stress, double active, const Vec3& fibre) {
  double twice = -active * along(strain, fibre);
  for (std::size_t k = 0; k < 6; ++k)
    twice += (k < 3 ? 1 : 2) * strain[k] * stress[k];
  return twice / 2;
}

CellFigures figures_of(const Scene& scene, const Answer& answer, std::vector<double> cell_energy) {
  const Specimen& body = scene.specimen;
  CellFields fields = cell_fields(scene, answer);
  const auto n = static_cast<std::size_t>(body.grid.n_cells());
  const bool has_stress = maille::has_stress(answer.method), has_fibres = scene.has_fibres(),
             has_energy = has_stress && !cell_energy.empty();
  CellFigures of;
  for (auto* figure : {&of.volume, &of.largest_strain, &of.smallest_strain})
    figure->resize(n);
  for (auto* figure : {&of.fibre_strain, &of.fibre_stress})
    figure->resize(has_fibres && (has_stress || figure == &of.fibre_strain) ? n : 0);
  of.pressure.resize(has_stress ? n : 0);
  of.energy = std::move(cell_energy);
  of.energy.resize(has_stress ? n : 0);
  const VolumeRatio ratio(body.grid);
  const DisplacementOfCells u(body, answer);
  const double volume = cell_volume(body.grid);
  for (std::size_t c = 0; c < n; ++c) {
    const auto cell = static_cast<std::int64_t>(c);
    if (!body.is_matter(cell))
      continue;
    const Tensor &e = fields.strain[c], &s = fields.stress[c];
    of.volume[c] = body.tissue_of(cell) * volume * ratio(u, cell);
    const Vec3 principal = principal_values(e);
    of.largest_strain[c] = principal[0];
    of.smallest_strain[c] = principal[2];
    const Vec3 fibre = body.fibre_of(cell);
    if (has_fibres)
      of.fibre_strain[c] = along(e, fibre);
    if (!has_stress)
      continue;
    if (has_fibres)
      of.fibre_stress[c] = along(s, fibre);
    of.pressure[c] = -(s[0] + s[1] + s[2]) / 3;
    if (!has_energy)
      of.energy[c] = body.tissue_of(cell) * volume *
                     energy_of_means(e, s, scene.contracts() ? scene.active_stress[c] : 0, fibre);
  }
  if (has_stress)
    of.von_mises = std::move(fields.von_mises);
  return of;
}

std::optional<Spread> spread_of(const std::vector<double>& figure, const Cells& cells) {
  if (figure.empty() || cells.empty())
    return std::nullopt;
  std::vector<double> values;
  values.reserve(cells.size());
  double sum = 0;
  for (const std::int64_t cell : cells) {
    values.push_back(figure[static_cast<std::size_t>(cell)]);
    sum += values.back();
  }
  if (!std::isfinite(sum)) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return Spread{none, none, none, none, none, none};
  }
  Spread spread;
  spread.mean = sum / static_cast<double>(values.size());
  const auto [least, most] = std::ranges::minmax(values);
  spread.least = least;
  spread.most = most;
  const auto percentile = [&](std::size_t percent) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>((percent * values.size() + 99) / 100 - 1);
    std::ranges::nth_element(values, at);
    return *at;
  };
  spread.percentile_5 = percentile(5);
  spread.median = percentile(50);
  spread.percentile_95 = percentile(95);
  return spread;
}

double sum_over(const std::vector<double>& figure, const Cells& cells) {
  double sum = 0;
  for (const std::int64_t cell : cells)
    sum += figure[static_cast<std::size_t>(cell)];
  return sum;
}

PartMechanics part_of(const CellFigures& of, const Specimen& body, const Cells& cells) {
  PartMechanics part;
  part.cells = static_cast<std::int64_t>(cells.size());
  double whole_cells = static_cast<double>(cells.size());
  if (!body.tissue.empty())
    whole_cells = std::accumulate(cells.begin(), cells.end(), 0.0,
                                  [&](double sum, std::int64_t cell) { return sum + body.tissue_of(cell); });
  part.volume_at_rest = whole_cells * cell_volume(body.grid);
  part.volume = sum_over(of.volume, cells);
  part.fibre_strain = spread_of(of.fibre_strain, cells);
  part.largest_strain = spread_of(of.largest_strain, cells);
  part.smallest_strain = spread_of(of.smallest_strain, cells);
  part.fibre_stress = spread_of(of.fibre_stress, cells);
  part.von_mises = spread_of(of.von_mises, cells);
  part.pressure = spread_of(of.pressure, cells);
  if (!of.energy.empty())
    part.strain_energy = sum_over(of.energy, cells);
  return part;
}

} // namespace

Mechanics mechanics_of(const Scene& scene, const Answer& answer, std::vector<double> cell_energy) {
  const Specimen& body = scene.specimen;
  if (cell_energy.empty())
    cell_energy = answer.cell_energy;
  Mechanics mechanics = resultants_of(scene, answer);
  mechanics.energy_is_of_means = cell_energy.empty() && has_stress(answer.method);
  const CellFigures figures = figures_of(scene, answer, std::move(cell_energy));
  Cells all;
  std::map<std::int32_t, Cells> of_label;
  std::map<std::uint8_t, Cells> of_material;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    all.push_back(cell);
    of_material[body.material(cell)].push_back(cell);
    if (!body.label.empty())
      of_label[body.label[static_cast<std::size_t>(cell)]].push_back(cell);
  }
  mechanics.body = part_of(figures, body, all);
  const auto part = [&](const Cells& cells) {
    return cells.size() == all.size() ? mechanics.body : part_of(figures, body, cells);
  };
  for (const auto& [material, cells] : of_material) {
    mechanics.materials.push_back(part(cells));
    mechanics.materials.back().material = scene.materials[material].name;
  }
  for (const auto& [label, cells] : of_label) {
    mechanics.labels.push_back(part(cells));
    mechanics.labels.back().label = label;
    mechanics.labels.back().material = scene.materials[body.material(cells.front())].name;
  }
  return mechanics;
}

} // namespace maille
