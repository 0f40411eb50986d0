// Reads cell properties from images beside the labels: tissue fraction and stiffness.
#include "maille/materials/density_law.hpp"
#include "maille/scene/voxel_map.hpp"
#include "read/reader.hpp"
#include "voxels/partial_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille::reader {

std::optional<PartialVolume> read_partial_volume(TableReader& specimen, const Index3& coarsen) {
  const toml::node* node = specimen.find("partial_volume");
  if (!node)
    return std::nullopt;
  PartialVolume asked;
  asked.line = line_of(*node);
  if (node->is_boolean()) {
    if (!node->value_or(false))
      return std::nullopt;
    asked.from = PartialVolume::From::labels;
  } else if (const auto* values = node->as_table()) {
    TableReader table(*values, specimen.path_of("partial_volume"), specimen.faults(), "partial_volume");
    const bool has_grey = table.has("none") || table.has("full") || table.has("image");
    if (has_grey && table.has("smooth"))
      table.fault("smooth", "either `smooth`, or grey values `none` and `full`", "both");
    if (has_grey) {
      asked.from = PartialVolume::From::grey;
      table.require("none");
      table.require("full");
      table.read("none", asked.none);
      table.read("full", asked.full);
      if (asked.none == asked.full)
        table.fault("full", "another grey value than `none`");
      asked.image = table.text("image").value_or("");
    } else {
      asked.from = table.has("smooth") ? PartialVolume::From::smooth : PartialVolume::From::labels;
      table.read("smooth", asked.width);
    }
    table.read("least", asked.least);
    table.finish();
  } else {
    specimen.fault(
        "partial_volume",
        "true (with `coarsen`), { smooth = \"1 mm\" }, or { none = 0, full = 1000 } in grey values");
    return std::nullopt;
  }
  if (asked.from == PartialVolume::From::labels && coarsen == Index3{1, 1, 1}) {
    specimen.fault("partial_volume",
                   "`coarsen` with it: of voxels of labels it counts how many of a cell's are tissue; or "
                   "{ smooth = \"1 mm\" }, or { none, full } in grey values",
                   "cells of one voxel each");
    return std::nullopt;
  }
  return asked;
}

void fill_partial_volume(const PartialVolume& asked, const LayeredImage& image,
                         const std::vector<LabelRange>& ranges, const Index3& coarsen, TableReader& table,
                         Specimen& body) {
  const std::string path = table.path_of("partial_volume");
  const bool is_grey = asked.from == PartialVolume::From::grey, is_of_other = is_grey && !asked.image.empty();
  try {
    LayeredImage from = image;
    if (is_of_other) {
      const auto file = resolve_path(asked.image, path, asked.line, table.faults());
      if (!file)
        return;
      from = LayeredImage(*file);
      place_on(from, body);
      if (from.info().components != 1 || !have_same_voxels(from.info(), image.info())) {
        table.faults().add(asked.line, path,
                           "an image of one value a voxel on the voxels of the body's image", asked.image);
        return;
      }
    }
    if (asked.from == PartialVolume::From::smooth) {
      const double most = widest_smooth * *std::ranges::min_element(image.info().spacing);
      if (!(asked.width <= most)) {
        table.faults().add(asked.line, path + ".smooth",
                           fmt::format("about a voxel, at most {:g}: {:.4g} mm", widest_smooth, 1e3 * most),
                           fmt::format("{:.4g} mm", 1e3 * asked.width));
        return;
      }
    }
    const bool is_smooth = asked.from == PartialVolume::From::smooth;
    LayerWindow shares = is_grey     ? shares_of_grey(from.open(coarsen[2]), asked.none, asked.full)
                         : is_smooth ? shares_of_smoothed(from, ranges, asked.width)
                                     : shares_of_labels(from.open(coarsen[2]), ranges);
    const std::int64_t without = fill_partial_cells(image, ranges, coarsen, std::move(shares), asked.least,
                                                    is_of_other, is_smooth, body);
    // NaN is not allowed where the fraction is needed: in labelled voxels, or in the body's own image.
    if (without > 0)
      table.faults().add(asked.line, path, "a number in every voxel of the body",
                         fmt::format("none in {} of them", without));
  } catch (const InputError& error) {
    adopt(error, path, asked.line, table.faults());
  }
}

namespace {

/// A requested map of stiffness.
struct StiffnessMap {
  std::string image;
  double pascal = 1; ///< modulus at grey value 1, without a law
  bool is_shear = false;
  const DensityLaw* law = nullptr;
  double density_at_zero = 0, density_per_grey = 0; ///< [kg/m^3]
  std::vector<LabelRange> labels;                   ///< empty: all matter
  int line = 0;

  /// Young's or shear modulus [Pa]; not finite if the law is undefined there.
  double modulus(double grey) const {
    if (!law)
      return grey * pascal;
    const double density = density_at_zero + density_per_grey * grey;
    return density > 0 ? law->youngs_modulus(density) : NAN;
  }
};

std::string law_names() {
  std::string names;
  for (const DensityLaw& law : density_laws())
    names += (names.empty() ? "" : ", ") + law.name;
  return names;
}

/// `density = ["0.02 g/cm^3", "0.0008 g/cm^3"]`: density at grey value 0, and its increase per grey value.
void read_calibration(TableReader& table, StiffnessMap& map) {
  const toml::node* node = table.require("density");
  const auto* list = node ? node->as_array() : nullptr;
  if (!node)
    return;
  if (!list || list->size() != 2) {
    table.fault("density", table.missing("density"));
    return;
  }
  map.density_at_zero =
      read_quantity(*list->get(0), table.path_of("density"), Dimension::density, table.faults()).value_or(0);
  map.density_per_grey =
      read_quantity(*list->get(1), table.path_of("density"), Dimension::density, table.faults()).value_or(1);
}

std::optional<StiffnessMap> read_map(TableReader& specimen) {
  auto section = specimen.has("stiffness") ? specimen.open("stiffness") : std::nullopt;
  if (!section)
    return std::nullopt;
  const std::size_t before = specimen.faults().size();
  StiffnessMap map;
  map.line = specimen.line_of_key("stiffness");
  TableReader& table = *section;
  table.read("image", map.image);
  if (table.has("law")) {
    const auto name = table.text("law");
    map.law = name ? find_density_law(*name) : nullptr;
    if (name && !map.law)
      table.fault("law", "one of " + law_names());
    read_calibration(table, map);
    for (const char* key : {"unit", "quantity"})
      table.refuse(key, "no such key with a `law`, which gives Young's modulus in Pa");
  } else {
    table.require("unit");
    const auto unit = table.text("unit");
    const auto pascal = unit ? parse_quantity("1 " + *unit, Dimension::pressure) : std::nullopt;
    if (unit && (!pascal || unit->empty()))
      table.fault("unit", "a unit of pressure, such as \"kPa\"");
    map.pascal = pascal.value_or(1);
    map.is_shear = table.choice("quantity") == "shear_modulus";
  }
  map.labels = read_label_ranges(table);
  table.finish();
  return specimen.faults().size() == before ? std::optional(map) : std::nullopt;
}

/// Reason why cells have no stiffness from the map.
struct Unusable {
  std::int64_t not_finite = 0, not_positive = 0;
  std::optional<Vec3> first; ///< place [m]
};

/// The mean over the positive voxels of a cell; NaN if one is not finite, 0 if there are none.
double mean_modulus(const StiffnessMap& map, const LayerWindow& image, const VoxelBlocks& blocks,
                    const Index3& cell) {
  double sum = 0;
  int n = 0;
  for (int k = 0; k < blocks.per_cell[2]; ++k)
    for (int j = 0; j < blocks.per_cell[1]; ++j)
      for (int i = 0; i < blocks.per_cell[0]; ++i) {
        const Index3 at{blocks.first[0] + cell[0] * blocks.per_cell[0] + i,
                        blocks.first[1] + cell[1] * blocks.per_cell[1] + j,
                        blocks.first[2] + cell[2] * blocks.per_cell[2] + k};
        bool is_inside = true;
        for (std::size_t a = 0; a < 3; ++a)
          is_inside = is_inside && at[a] >= 0 && at[a] < image.info().size[a];
        if (!is_inside)
          continue;
        const double grey = double{image.at(at)};
        if (!std::isfinite(grey))
          return NAN;
        if (const double modulus = map.modulus(grey); modulus > 0) {
          sum += modulus;
          ++n;
        }
      }
  return n > 0 ? sum / n : 0;
}

void apply_map(const StiffnessMap& map, const LayeredImage& image, const VoxelBlocks& blocks,
               const std::vector<Material>& materials, const std::string& path, FaultList& faults,
               Scene& scene) {
  Specimen& body = scene.specimen;
  std::int64_t out_of_range = 0;
  double least = INFINITY, most = 0; // densities of cells
  LayerWindow layers = image.open(blocks.per_cell[2]);
  std::vector<float> ratio(body.grid.n_cells(), 1);
  Unusable none;
  std::int64_t n = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const auto c = static_cast<std::size_t>(cell);
    if (!body.is_matter(cell) ||
        (!map.labels.empty() && material_of(static_cast<float>(body.label[c]), map.labels) == no_material))
      continue;
    ++n;
    const Index3 at = body.grid.cell_at(cell);
    layers.move_to(blocks.first[2] + at[2] * blocks.per_cell[2],
                   blocks.first[2] + (at[2] + 1) * blocks.per_cell[2]);
    const double modulus = mean_modulus(map, layers, blocks, at);
    if (!(modulus > 0)) {
      ++(std::isfinite(modulus) ? none.not_positive : none.not_finite);
      if (!none.first)
        none.first = body.position(at);
      continue;
    }
    if (map.law) {
      constexpr double rounding = 1e-9;
      const double density = 1000 * std::pow(modulus / map.law->modulus, 1 / map.law->exponent);
      least = std::min(least, density);
      most = std::max(most, density);
      if (density < map.law->least * (1 - rounding) || density > map.law->most * (1 + rounding))
        ++out_of_range;
    }
    const ElasticConstants& c0 = materials[body.material(cell)].elasticity;
    ratio[c] = static_cast<float>(modulus / (map.is_shear ? c0.G12 : c0.youngs_modulus[0]));
  }
  layers.move_to(image.info().size[2], image.info().size[2]); // damage after the body is a fault, too
  body.stiffness_ratio = std::move(ratio);
  check_labels_exist(
      map.labels, body, [&](std::int64_t cell) { return static_cast<float>(body.label[cell]); }, map.line,
      path + ".labels", faults);
  if (out_of_range > 0)
    scene.left_out.push_back(
        {0,
         fmt::format("{}: the density of {} of {} cells is outside of {:.3g} to {:.3g} g/cm^3, which {} was "
                     "measured on: {:.3g} to {:.3g} g/cm^3",
                     path, out_of_range, n, map.law->least / 1000, map.law->most / 1000, map.law->name,
                     least / 1000, most / 1000)});
  if (none.first)
    faults.add(
        map.line, path, "a modulus > 0 in every cell of matter that the map is for",
        fmt::format("{} cells that are not a number, {} of 0, less, or without a density > 0, the first "
                    "at ({:.4g}, {:.4g}, {:.4g}) mm",
                    none.not_finite, none.not_positive, 1e3 * (*none.first)[0], 1e3 * (*none.first)[1],
                    1e3 * (*none.first)[2]));
}

} // namespace

void read_stiffness_map(TableReader& specimen, const std::vector<Material>& materials, Scene* scene) {
  const auto map = read_map(specimen);
  if (!map || !scene)
    return;
  const Specimen* body = &scene->specimen;
  const std::string path = specimen.path_of("stiffness");
  if (body->image.empty()) {
    specimen.fault("stiffness", "a body that is read from an image", "a generated shape");
    return;
  }
  if (!map->labels.empty() && body->label.empty()) {
    specimen.fault("stiffness", "`labels` of a body that has labels", "one that has none");
    return;
  }
  const auto file = resolve_path(map->image, path, map->line, specimen.faults());
  if (!file)
    return;
  try {
    LayeredImage image(*file);
    place_on(image, *body);
    const ImageInfo& info = image.info();
    const auto blocks = voxel_blocks(info, *body);
    if (info.components != 1 || !blocks)
      specimen.faults().add(map->line, path,
                            "an image of one value a voxel, on the body's voxels or those that its cells are "
                            "merged of",
                            info.components != 1 ? fmt::format("{} values a voxel", info.components)
                                                 : "voxels that lie otherwise");
    else
      apply_map(*map, image, *blocks, materials, path, specimen.faults(), *scene);
  } catch (const InputError& error) {
    adopt(error, path, map->line, specimen.faults());
  }
}

} // namespace maille::reader
