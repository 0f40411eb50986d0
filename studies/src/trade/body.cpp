#include "trade/body.hpp"
#include "maille/base/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::studies {

namespace {

/// A little less than two: staircases have rows of one cell, too.
constexpr double fewest_cells = 1.75;
constexpr double most_change_of_volume = 0.25;
/// A little beyond the values in the table: 0.48, 25 and, from `studies/lab/run studies`, 4.
constexpr double largest_poisson_ratio = 0.49, largest_anisotropy = 30, largest_aspect = 4,
                 largest_flatness = 1.5;

/// Number of cells of the same material in a row through `cell` along an axis.
int row_through(const Specimen& body, const Index3& cell, std::size_t axis) {
  const std::uint8_t material = body.material(body.grid.cell(cell));
  int n = 1;
  for (const int step : {-1, 1}) {
    Index3 at = cell;
    for (at[axis] += step; body.grid.has_cell(at) && body.material(body.grid.cell(at)) == material;
         at[axis] += step)
      ++n;
  }
  return n;
}

/// Number of cells of each material.
std::vector<std::int64_t> cells_of(const Scene& scene) {
  std::vector<std::int64_t> cells(scene.materials.size());
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      ++cells[scene.specimen.material(cell)];
  return cells;
}

bool is_image(const Scene& scene) {
  return scene.specimen.shape == "image";
}

double largest_contraction(const ElasticConstants& constants) {
  return std::max({constants.nu12, constants.nu13, constants.nu23});
}

} // namespace

double thickness_in_cells(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const std::size_t dimension = scene.dimension();
  if (!is_image(scene))
    return *std::min_element(body.grid.cells().begin(),
                             body.grid.cells().begin() + static_cast<std::ptrdiff_t>(dimension));
  std::vector<std::vector<int>> shortest(scene.materials.size());
  for (std::int64_t number = 0; number < body.grid.n_cells(); ++number) {
    if (!body.is_matter(number))
      continue;
    const Index3 cell = body.grid.cell_at(number);
    int least = std::numeric_limits<int>::max();
    for (std::size_t a = 0; a < dimension; ++a)
      least = std::min(least, row_through(body, cell, a));
    shortest[body.material(number)].push_back(least);
  }
  int thinnest = std::numeric_limits<int>::max();
  for (std::vector<int>& rows : shortest)
    if (!rows.empty()) {
      const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2);
      std::ranges::nth_element(rows, middle);
      thinnest = std::min(thinnest, *middle);
    }
  return thinnest;
}

std::string what_is_lost(const Scene& scene, double thickness, const Scene& on_lattice, int halvings) {
  if (const double cells = thickness * std::exp2(halvings); cells < fewest_cells)
    return fmt::format("the body, or a layer of it, is {:.2g} cells thick there", cells);
  if (!is_image(scene))
    return {};
  const std::vector<std::int64_t> here = cells_of(scene), there = cells_of(on_lattice);
  for (std::size_t m = 0; m < here.size(); ++m) {
    const double before = static_cast<double>(here[m]) * cell_volume(scene.specimen.grid),
                 after = m < there.size()
                             ? static_cast<double>(there[m]) * cell_volume(on_lattice.specimen.grid)
                             : 0;
    if (std::abs(after - before) > most_change_of_volume * before)
      return fmt::format("{} has {:.0f} % of its volume there", scene.materials[m].name,
                         100 * after / before);
  }
  return {};
}

std::vector<std::string> how_unlike_the_table(const Scene& scene) {
  std::vector<std::string> words;
  const Grid& grid = scene.specimen.grid;
  const std::size_t dimension = scene.dimension();
  if (is_image(scene))
    words.emplace_back("a body from an image");
  if (scene.strain == Strain::finite)
    words.emplace_back("finite strain");
  if (scene.has_loads())
    words.emplace_back("loads");
  double nu = 0, anisotropy = 1, longest = 0, shortest = std::numeric_limits<double>::infinity();
  for (const Material& material : scene.materials) {
    const auto [least, most] = std::ranges::minmax(material.elasticity.youngs_modulus);
    anisotropy = std::max(anisotropy, most / least);
    nu = std::max(nu, largest_contraction(material.elasticity));
  }
  double widest = 0, narrowest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < dimension; ++a) {
    const double spacing = grid.spacing()[a], length = grid.cells()[a] * spacing;
    longest = std::max(longest, length);
    shortest = std::min(shortest, length);
    widest = std::max(widest, spacing);
    narrowest = std::min(narrowest, spacing);
  }
  if (nu > largest_poisson_ratio)
    words.push_back(fmt::format("a Poisson's ratio of {:.4g}", nu));
  if (anisotropy > largest_anisotropy)
    words.push_back(fmt::format("matter {:.3g} times as stiff along as across", anisotropy));
  if (longest > largest_aspect * shortest * (1 + 1e-9))
    words.push_back(fmt::format("{:.3g} times as long as thick", longest / shortest));
  if (widest > largest_flatness * narrowest)
    words.push_back(fmt::format("cells {:.3g} times as long as thick", widest / narrowest));
  return words;
}

} // namespace maille::studies
