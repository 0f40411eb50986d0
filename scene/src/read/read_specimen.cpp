#include "maille/base/arena.hpp"
#include "read/read_look.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace maille::reader {

namespace {

void read_plane(TableReader& table, int dimension, Scene& scene) {
  if (table.read("plane", scene.plane))
    check_plane(dimension, table.path_of("plane"), table.line_of_key("plane"), table.faults());
}

/// Sets the scene's fibres in the belly, and x in tendons. @pre tendons have material 1
void muscle_fibres(const FibreRequest& belly, Specimen& body, FaultList& faults) {
  if (!place_fibres(belly, body, faults))
    return;
  const std::array<float, 3> along{1, 0, 0};
  const std::array<float, 3> pennate{static_cast<float>(body.fibre[0]), static_cast<float>(body.fibre[1]),
                                     static_cast<float>(body.fibre[2])};
  const bool is_constant = body.fibres.empty();
  body.fibres.resize(body.material_id.size(), pennate);
  for (std::size_t cell = 0; cell < body.material_id.size(); ++cell)
    if (body.material_id[cell] != 0)
      body.fibres[cell] = along;
  if (!is_constant)
    body.fibre_report.cells = std::ranges::count(body.material_id, std::uint8_t{0});
}

/// Default pennation, in the plane of x and the last axis; see docs/scene.md.
Vec3 usual_pennation(int dimension) {
  const double angle = 20 * std::numbers::pi / 180;
  Vec3 pennate{std::cos(angle), 0, 0};
  if (dimension > 1)
    pennate[dimension == 2 ? 1 : 2] = std::sin(angle);
  return pennate;
}

struct Tendon {
  double fraction = 0.15;
  std::uint8_t material = 1; ///< 0, the belly's, if both are equal
};

/// `tendon = { material = "tendon/...", fraction = 0.15 }` of a muscle; its material becomes number 1, if it
/// differs from the belly's.
Tendon read_tendon(TableReader& table, bool has_material, MaterialTable& materials) {
  Tendon tendon;
  if (!has_material && !table.has("tendon"))
    return tendon;
  if (!table.require("tendon"))
    return tendon;
  if (auto reader = table.open("tendon")) {
    if (const toml::node* node = reader->require("material"))
      tendon.material = materials.add(*node, reader->path_of("material"), table.faults()).value_or(1);
    reader->read("fraction", tendon.fraction);
    reader->finish();
  }
  return tendon;
}

bool read_generated(TableReader& table, const std::string& shape, const BodyDefaults& defaults,
                    MaterialTable& materials, Scene& scene) {
  Specimen& body = scene.specimen;
  const std::size_t faults_before = table.faults().size();
  read_material(table, defaults.has_material, materials);
  const bool muscle = shape == "muscle";
  const Tendon tendon = muscle ? read_tendon(table, defaults.has_material, materials) : Tendon{};
  const bool fibre_is_given = table.has("fibre");
  auto fibre = read_fibre(table);
  const auto grid = read_grid(table, defaults.spacing);
  read_plane(table, grid ? grid->dimension() : 0, scene);
  if (fibre && !fibre->tensor_image.empty())
    table.fault("fibre", "a direction: tensor images go with shape = \"image\"", "tensor_image");
  if (!grid || table.faults().size() > faults_before)
    return false;

  body.grid = *grid;
  if (shape == "ellipsoid")
    body.material_id = ellipsoid_cells(*grid);
  if (muscle)
    body.material_id = muscle_cells(*grid, tendon.fraction);
  if (!body.material_id.empty())
    crop_to_matter(body);
  if (muscle) {
    if (!fibre_is_given)
      fibre->direction = usual_pennation(grid->dimension());
    muscle_fibres(*fibre, body, table.faults());
    std::ranges::replace(body.material_id, std::uint8_t{1}, tendon.material);
  } else {
    place_fibres(*fibre, body, table.faults());
  }
  return table.faults().size() == faults_before;
}

void require_fibre(TableReader& table, const std::vector<Material>& materials) {
  const auto needs =
      std::ranges::find_if(materials, [](const Material& material) { return !is_isotropic(material); });
  if (needs != materials.end() && !table.has("fibre"))
    add_lack_of_fibre(table.line(), needs->name + ", which is not the same along all axes", table.faults());
}

/// Centre of a cell along an axis, from -1 at the lower end of the grid to 1 at the upper.
double relative_centre(const Grid& grid, const Index3& cell, std::size_t axis) {
  return 2 * (cell[axis] + 0.5) / grid.cells()[axis] - 1;
}

} // namespace

void check_plane(int dimension, const std::string& path, int line, FaultList& faults) {
  if (dimension != 0 && dimension != 2)
    faults.add(line, path, "no such key unless the scene is two-dimensional",
               fmt::format("a scene of dimension {}", dimension));
}

std::vector<int> whole_numbers(const toml::node& node, int least, int most) {
  const auto* list = node.as_array();
  std::vector<int> numbers;
  for (std::size_t i = 0; i < (list ? list->size() : 1); ++i) {
    const auto number = (list ? *list->get(i) : node).value_exact<std::int64_t>();
    if (!number || *number < least || *number > most)
      return {};
    numbers.push_back(static_cast<int>(*number));
  }
  return numbers;
}

std::optional<std::vector<int>> read_cells(TableReader& table) {
  const toml::node* node = table.require("cells");
  if (!node)
    return std::nullopt;
  if (auto cells = whole_numbers(*node, 1, most_cells_along_an_axis); !cells.empty() && cells.size() <= 3)
    return cells;
  table.fault("cells", table.missing("cells"));
  return std::nullopt;
}

std::optional<Vec3> read_spacing(TableReader& table, int dimension, const std::optional<Vec3>& otherwise) {
  if (otherwise && !table.has("spacing"))
    return otherwise;
  const toml::node* node = table.require("spacing");
  if (!node)
    return std::nullopt;
  Vec3 spacing{};
  const auto* list = node->as_array();
  const std::size_t n = dimension;
  if (list && list->size() != n && list->size() != 3) {
    table.fault("spacing", fmt::format("one length or {} of them", dimension));
    return std::nullopt;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const toml::node& entry = list ? *list->get(std::min(a, list->size() - 1)) : *node;
    const auto value = read_quantity(entry, table.path_of("spacing"), Dimension::length, table.faults());
    if (!value)
      return std::nullopt;
    if (*value <= 0) {
      table.faults().add(line_of(entry), table.path_of("spacing"), "a length > 0", describe(entry));
      return std::nullopt;
    }
    spacing[a] = *value;
  }
  return spacing;
}

std::optional<Grid> read_grid(TableReader& table, const std::optional<Vec3>& default_spacing) {
  const auto cells = read_cells(table);
  const auto spacing = read_spacing(table, cells ? static_cast<int>(cells->size()) : 3, default_spacing);
  if (!cells || !spacing)
    return std::nullopt;
  const int dimension = static_cast<int>(cells->size());
  Index3 size{1, 1, 1};
  std::copy(cells->begin(), cells->end(), size.begin());
  if (!fits_into_memory(size, dimension, table.path_of("cells"), line_of(*table.find("cells")),
                        table.faults()))
    return std::nullopt;
  return Grid(dimension, size, *spacing);
}

bool fits_into_memory(const Index3& cells, int dimension, const std::string& path, int line,
                      FaultList& faults) {
  // In floating point, because the product of three sizes may overflow integers.
  double nodes = 1;
  for (int a = 0; a < dimension; ++a)
    nodes *= static_cast<double>(cells[a]) + 1;
  const double needed = nodes * dimension * sizeof(double);
  const auto available = static_cast<double>(available_memory());
  if (needed <= available)
    return true;
  faults.add(line, path,
             fmt::format("a grid that fits into the {:.0f} MiB of free memory", available / 1048576),
             fmt::format("{:.0f} nodes, {:.0f} MiB for one displacement alone", nodes, needed / 1048576));
  return false;
}

void read_material(TableReader& table, bool is_needed, MaterialTable& materials) {
  const toml::node* node = is_needed || table.has("material") ? table.require("material") : nullptr;
  if (node)
    materials.add(*node, table.path_of("material"), table.faults());
}

bool read_body(TableReader& table, const std::string& shape, const BodyDefaults& defaults, Scene& scene,
               std::vector<float>* labels) {
  MaterialTable materials;
  scene.specimen.shape = shape;
  bool body = false;
  if (shape == "image") {
    body = read_image_specimen(table, defaults.has_material, materials, scene, labels);
    read_plane(table, body ? scene.specimen.grid.dimension() : 0, scene);
  } else if (shape == "surface") {
    body = read_surface_specimen(table, defaults.has_material, defaults.spacing, materials, scene, labels);
    read_plane(table, body ? scene.specimen.grid.dimension() : 0, scene);
  } else {
    body = read_generated(table, shape, defaults, materials, scene);
    table.refuse("partial_volume", "no such key unless shape = \"image\"");
  }
  // With a faulty map the body's shape is still valid for the checks that follow.
  read_stiffness_map(table, materials.materials(), body ? &scene : nullptr);
  if (defaults.has_material && (shape == "image" || shape == "surface"))
    require_fibre(table, materials.materials());
  scene.materials = materials.take();
  return body;
}

bool read_specimen(TableReader& table, Scene& scene, std::vector<float>* labels, const Image* given) {
  if (given) {
    MaterialTable materials;
    scene.specimen.shape = "image";
    const bool body = read_image_specimen(table, true, materials, scene, labels, given);
    read_plane(table, body ? scene.specimen.grid.dimension() : 0, scene);
    require_fibre(table, materials.materials());
    scene.materials = materials.take();
    table.finish();
    return body;
  }
  const auto shape = table.choice("shape");
  if (!shape)
    return false;
  const bool body = read_body(table, *shape, {}, scene, labels);
  read_look(table); // only for its faults
  table.finish();
  return body;
}

std::vector<std::uint8_t> ellipsoid_cells(const Grid& grid) {
  std::vector<std::uint8_t> cells(grid.n_cells(), no_material);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    double radius_sq = 0;
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const double c = relative_centre(grid, grid.cell_at(cell), static_cast<std::size_t>(axis));
      radius_sq += c * c;
    }
    if (radius_sq <= 1)
      cells[cell] = 0;
  }
  return cells;
}

std::vector<std::uint8_t> muscle_cells(const Grid& grid, double tendon_fraction) {
  constexpr double end_radius = 0.35; // relative to the largest, at the end of the grid
  std::vector<std::uint8_t> cells(grid.n_cells(), no_material);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    const double along = (at[0] + 0.5) / grid.cells()[0];
    const double swell = std::sin(std::numbers::pi * along);
    const double radius = end_radius + (1 - end_radius) * swell * swell;
    double distance_sq = 0;
    for (std::size_t axis = 1; axis < static_cast<std::size_t>(grid.dimension()); ++axis)
      distance_sq += std::pow(relative_centre(grid, at, axis), 2);
    if (distance_sq <= radius * radius)
      cells[cell] = along < tendon_fraction || along > 1 - tendon_fraction ? 1 : 0;
  }
  return cells;
}

} // namespace maille::reader
