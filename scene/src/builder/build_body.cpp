#include "builder/build_scene.hpp"
#include "conditions/region.hpp"
#include "maille/materials/material.hpp"

#include <algorithm>
#include <cmath>

namespace maille {

namespace {

using reader::most_cells_along_an_axis;

/// True if the grid is in the range of the arithmetic; otherwise `grid` stays empty.
bool is_grid(int dimension, const Index3& cells, const Vec3& spacing, FaultList& faults) {
  const std::size_t before = faults.size();
  if (dimension < 1 || dimension > 3) {
    faults.add(0, "specimen.dimension", "1, 2 or 3", fmt::format("{}", dimension));
    return false;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const bool is_beyond = static_cast<int>(a) >= dimension;
    if (is_beyond ? cells[a] != 1 : cells[a] < 1 || cells[a] > most_cells_along_an_axis)
      faults.add(
          0, "specimen.cells",
          is_beyond ? fmt::format("1 along {}: the scene has {} dimension{}", "xyz"[a], dimension,
                                  dimension == 1 ? "" : "s")
                    : fmt::format("a whole number from 1 to {} along {}", most_cells_along_an_axis, "xyz"[a]),
          fmt::format("{}", cells[a]));
    if (!(std::isfinite(spacing[a]) && spacing[a] > 0))
      faults.add(0, "specimen.spacing", fmt::format("a length > 0 along {}", "xyz"[a]),
                 fmt::format("{}", spacing[a]));
  }
  return faults.size() == before;
}

} // namespace

bool SceneBuilder::Assembly::make_body() {
  const std::size_t before = faults_.size();
  bool is_made = false;
  if (const auto* box = std::get_if<BoxBody>(&asked_.body_))
    is_made = make_box(*box);
  else if (const auto* labels = std::get_if<LabelBody>(&asked_.body_))
    is_made = make_labelled(*labels);
  else
    add_fault("specimen", "a box, or an array of labels", "neither");
  if (asked_.plane_) {
    scene_.plane = *asked_.plane_;
    reader::check_plane(is_made ? scene_.dimension() : 0, "specimen.plane", 0, faults_);
  }
  return is_made && faults_.size() == before;
}

bool SceneBuilder::Assembly::make_box(const BoxBody& box) {
  scene_.specimen.shape = "box";
  read_material_of_box();
  if (!is_grid(box.dimension, box.cells, box.spacing, faults_) ||
      !reader::fits_into_memory(box.cells, box.dimension, "specimen.cells", 0, faults_))
    return false;
  whole_ = scene_.specimen.grid = Grid(box.dimension, box.cells, box.spacing);
  place_fibres();
  return true;
}

bool SceneBuilder::Assembly::make_labelled(const LabelBody& labels) {
  Specimen& body = scene_.specimen;
  const std::size_t before = faults_.size();
  body.shape = "image";
  take(labels.faults);
  const auto ranges = read_labels(labels.image);
  if (faults_.size() > before ||
      !reader::fits_into_memory(labels.image.info.size, 3, "specimen.layout", 0, faults_))
    return false;
  const LayeredImage image(labels.image);
  reader::LabelCensus census(ranges);
  reader::fill_cells(image, {1, 1, 1}, ranges, census, body);
  if (!reader::has_matter(body, "specimen.labels", 0, faults_))
    return false;
  whole_ = body.grid;
  place_fibres();
  first_ = reader::crop_to_matter(body);
  if (asked_.materials_.front().label)
    body.label = reader::LabelCells(image, ranges, first_, {1, 1, 1}, body).whole_labels();
  return true;
}

std::vector<reader::LabelRange> SceneBuilder::Assembly::read_labels(const Image& image) {
  const auto by_label = std::ranges::count_if(
      asked_.materials_, [](const LabelMaterial& material) { return material.label.has_value(); });
  const auto n = static_cast<std::ptrdiff_t>(asked_.materials_.size());
  if (n == 0 || (by_label < n && n > 1))
    add_fault("specimen.labels", "materials by label, or one for every voxel that is not 0",
              n == 0          ? "neither"
              : by_label == 0 ? "more than one for every voxel that is not 0"
                              : "both");
  std::vector<reader::LabelRange> ranges;
  std::vector<reader::NamedLabel> names;
  for (const LabelMaterial& material : asked_.materials_) {
    const std::string name = material.label ? fmt::format("{}", *material.label) : "";
    const auto number = material_number(material.choice, material.label ? "specimen.labels." + name
                                                                        : std::string("specimen.material"));
    if (!number)
      continue;
    if (!material.label)
      return reader::all_but_zero();
    if (!reader::is_label(*material.label)) {
      add_fault("specimen.labels", reader::wanted_label(), name);
      continue;
    }
    const auto value = static_cast<float>(*material.label);
    reader::add_label({value, value, *number}, name, 0, "specimen.labels", ranges, faults_);
    names.push_back({name, 0});
  }
  if (!image.values.empty()) {
    reader::LabelCensus census(ranges);
    reader::for_each_run(image.values, [&](float value, std::size_t) { census.add(value); });
    reader::check_labels_occur(census, names, "specimen.labels", faults_);
  }
  return ranges;
}

void SceneBuilder::Assembly::read_material_of_box() {
  for (const LabelMaterial& material : asked_.materials_)
    if (material.label)
      add_fault(fmt::format("specimen.labels.{}", *material.label), "no label: a box has none", "a material");
    else
      material_number(material.choice, "specimen.material");
  const auto n = std::ranges::count_if(asked_.materials_, [](const LabelMaterial& m) { return !m.label; });
  if (n != 1)
    add_fault("specimen.material", "one material", n == 0 ? "nothing" : fmt::format("{} of them", n));
}

std::optional<std::uint8_t> SceneBuilder::Assembly::material_number(const MaterialChoice& choice,
                                                                    const std::string& path) {
  if (const auto* name = std::get_if<std::string>(&choice)) {
    const auto found = reader::library_material(*name, path, 0, faults_);
    return found ? materials_.add(*found, path, faults_) : std::nullopt;
  }
  Material material = std::get<Material>(choice);
  const auto broken = broken_rules(material);
  for (const BrokenRule& rule : broken)
    add_fault(path + "." + rule.key, rule.expected, rule.found);
  if (!broken.empty())
    return std::nullopt;
  if (material.name.empty())
    material.name = path;
  return materials_.add(std::move(material), path, faults_);
}

void SceneBuilder::Assembly::place_fibres() {
  Specimen& body = scene_.specimen;
  if (!asked_.fibres_) {
    if (const auto direction = reader::unit_vector(asked_.fibre_))
      body.fibre = *direction;
    else
      add_fault("specimen.fibre", "a direction: finite, and not zero", in_words(asked_.fibre_));
    return;
  }
  const FibreArray& array = *asked_.fibres_;
  take(array.faults);
  if (!array.faults.empty())
    return;
  if (array.size != body.grid.cells()) {
    const Index3& n = body.grid.cells();
    add_fault("specimen.fibre", fmt::format("{} x {} x {} directions, one a cell", n[0], n[1], n[2]),
              fmt::format("{} x {} x {}", array.size[0], array.size[1], array.size[2]));
    return;
  }
  std::int64_t without = 0, first = -1;
  body.fibres.assign(array.values.size(), {0, 0, 0});
  for (std::size_t cell = 0; cell < array.values.size(); ++cell) {
    if (!body.is_matter(static_cast<std::int64_t>(cell)))
      continue;
    const auto& [x, y, z] = array.values[cell];
    if (const auto direction = reader::unit_vector({x, y, z}))
      std::ranges::transform(*direction, body.fibres[cell].begin(),
                             [](double c) { return static_cast<float>(c); });
    else if (without++ == 0)
      first = static_cast<std::int64_t>(cell);
  }
  body.fibre_report.source = "array";
  body.fibre_report.cells = body.n_matter_cells();
  if (without > 0) {
    const Index3 at = body.grid.cell_at(first);
    add_fault("specimen.fibre", "a direction in every cell of matter: finite, and not zero",
              fmt::format("none in {} cell{}, the first ({}, {}, {})", without, without == 1 ? "" : "s",
                          at[0], at[1], at[2]));
  }
}

Grid SceneBuilder::grid() const {
  FaultList ignored("");
  if (const auto* box = std::get_if<BoxBody>(&body_))
    return is_grid(box->dimension, box->cells, box->spacing, ignored)
               ? Grid(box->dimension, box->cells, box->spacing)
               : Grid();
  const auto* labels = std::get_if<LabelBody>(&body_);
  if (!labels || !labels->faults.empty())
    return {};
  const ImageInfo& info = labels->image.info;
  return {info.size[2] == 1 ? 2 : 3, info.size, info.spacing};
}

} // namespace maille
