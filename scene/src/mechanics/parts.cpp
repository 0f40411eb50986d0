// Strain, stress, energy and volume of labels, materials and the whole body.
#include "maille/scene/mechanics/mechanics.hpp"

#include "maille/base/vectors.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/sliding.hpp"
#include "mechanics/volume_ratio.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <future>
#include <limits>
#include <map>
#include <optional>
#include <vector>

namespace maille {

namespace {

/// Indices into the body's cells of matter, in grid order.
using Places = std::vector<std::int32_t>;
using Tensor = std::array<double, 6>;

/// Results by index of the cell of matter; empty if the answer has none.
struct CellFigures {
  std::vector<double> volume, fibre_strain, largest_strain, smallest_strain, fibre_stress, von_mises,
      pressure, energy;
};

/// Half of elastic stress times strain, from the means of the cell.
double energy_of_means(const Tensor& strain, const Tensor& stress, double active, const Vec3& fibre) {
  double twice = -active * along(strain, fibre);
  for (std::size_t k = 0; k < 6; ++k)
    twice += (k < 3 ? 1 : 2) * strain[k] * stress[k];
  return twice / 2;
}

/// Calls work(first cell, end, index of its first cell of matter) for parts of the grid, one per thread.
template<class Work>
void for_parts_of_grid(const Specimen& body, int threads, const Work& work) {
  const std::int64_t n = body.grid.n_cells();
  std::vector<std::future<void>> parts;
  std::size_t place = 0;
  for (std::int64_t part = 0; part < threads; ++part) {
    const std::int64_t first = n * part / threads, end = n * (part + 1) / threads;
    parts.push_back(std::async(part + 1 < threads ? std::launch::async : std::launch::deferred,
                               [&work, first, end, place] { work(first, end, place); }));
    for (std::int64_t cell = first; cell < end; ++cell)
      place += body.is_matter(cell) ? 1 : 0;
  }
  for (std::future<void>& part : parts)
    part.get();
}

CellFigures figures_of(const Scene& scene, const Answer& answer, const std::vector<double>& cell_energy,
                       int threads) {
  const Specimen& body = scene.specimen;
  const auto n = static_cast<std::size_t>(body.n_matter_cells());
  const bool has_stress = maille::has_stress(answer.method), has_fibres = scene.has_fibres(),
             has_energy = has_stress && !cell_energy.empty();
  CellFigures of;
  for (auto* figure : {&of.volume, &of.largest_strain, &of.smallest_strain})
    figure->resize(n);
  for (auto* figure : {&of.fibre_strain, &of.fibre_stress})
    figure->resize(has_fibres && (has_stress || figure == &of.fibre_strain) ? n : 0);
  for (auto* figure : {&of.pressure, &of.von_mises, &of.energy})
    figure->resize(has_stress ? n : 0);
  const VolumeRatio ratio(body.grid);
  const DisplacementOfCells u(body, answer);
  const double volume = cell_volume(body.grid);
  for_parts_of_grid(body, threads, [&](std::int64_t first, std::int64_t end, std::size_t place) {
    FieldsOfCells fields(scene, answer);
    for (std::int64_t cell = first; cell < end; ++cell) {
      if (!body.is_matter(cell))
        continue;
      const std::size_t c = place++;
      const FieldsOfCells::Values of_cell = fields(cell);
      const Tensor &e = of_cell.strain, &s = of_cell.stress;
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
      of.von_mises[c] = of_cell.von_mises;
      const auto on_grid = static_cast<std::size_t>(cell);
      const double active = scene.contracts() ? scene.active_stress[on_grid] : 0;
      of.energy[c] = has_energy ? cell_energy[on_grid]
                                : body.tissue_of(cell) * volume * energy_of_means(e, s, active, fibre);
    }
  });
  return of;
}

std::optional<Spread> spread_of(const std::vector<double>& figure, const Places& places) {
  if (figure.empty() || places.empty())
    return std::nullopt;
  std::vector<double> values;
  values.reserve(places.size());
  double sum = 0;
  for (const std::int32_t place : places) {
    values.push_back(figure[place]);
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

double sum_over(const std::vector<double>& figure, const Places& places) {
  double sum = 0;
  for (const std::int32_t place : places)
    sum += figure[place];
  return sum;
}

/// @param tissue sum of the tissue fractions of the cells
PartMechanics part_of(const CellFigures& of, const Specimen& body, const Places& places, double tissue) {
  PartMechanics part;
  part.cells = static_cast<std::int64_t>(places.size());
  part.volume_at_rest = tissue * cell_volume(body.grid);
  part.volume = sum_over(of.volume, places);
  part.fibre_strain = spread_of(of.fibre_strain, places);
  part.largest_strain = spread_of(of.largest_strain, places);
  part.smallest_strain = spread_of(of.smallest_strain, places);
  part.fibre_stress = spread_of(of.fibre_stress, places);
  part.von_mises = spread_of(of.von_mises, places);
  part.pressure = spread_of(of.pressure, places);
  if (!of.energy.empty())
    part.strain_energy = sum_over(of.energy, places);
  return part;
}

/// The cells of a part, and the material of the first one.
struct CellsOfPart {
  Places places;
  double tissue = 0; ///< cells of it
  std::uint8_t material = no_material;
  void add(const Specimen& body, std::int64_t cell, std::int32_t place) {
    material = places.empty() ? body.material(cell) : material;
    places.push_back(place);
    tissue += body.tissue_of(cell);
  }
};

} // namespace

Mechanics mechanics_of(const Scene& scene, const Answer& answer, std::vector<double> cell_energy,
                       int threads) {
  const Specimen& body = scene.specimen;
  if (cell_energy.empty())
    cell_energy = answer.cell_energy;
  Mechanics mechanics = resultants_of(scene, answer);
  mechanics.energy_is_of_means = cell_energy.empty() && has_stress(answer.method);
  const CellFigures figures = figures_of(scene, answer, cell_energy, threads);
  cell_energy = {};
  CellsOfPart all;
  std::map<std::int32_t, CellsOfPart> of_label;
  std::map<std::uint8_t, CellsOfPart> of_material;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const auto place = static_cast<std::int32_t>(all.places.size());
    all.add(body, cell, place);
    of_material[body.material(cell)].add(body, cell, place);
    if (!body.label.empty())
      of_label[body.label[cell]].add(body, cell, place);
  }
  mechanics.body = part_of(figures, body, all.places, all.tissue);
  const auto part = [&](const CellsOfPart& of) {
    PartMechanics found =
        of.places.size() == all.places.size() ? mechanics.body : part_of(figures, body, of.places, of.tissue);
    found.material = scene.materials[of.material].name;
    return found;
  };
  for (const auto& [material, cells] : of_material)
    mechanics.materials.push_back(part(cells));
  for (const auto& [label, cells] : of_label) {
    mechanics.labels.push_back(part(cells));
    mechanics.labels.back().label = label;
  }
  return mechanics;
}

} // namespace maille
