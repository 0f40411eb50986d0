#include "maille/scene/scene_builder.hpp"

#include "read/reader.hpp"
#include "voxels/label_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace maille {

namespace {

std::string words(const ArrayLayout& layout) {
  const auto& [size, stride, first] = layout;
  return fmt::format("{} x {} x {} voxels, strides {}, {}, {}, from element {} on", size[0], size[1], size[2],
                     stride[0], stride[1], stride[2], first);
}

/// True if every voxel is an element of the array.
bool check_layout(const ArrayLayout& layout, std::size_t n_elements, const char* key,
                  std::vector<Fault>& faults) {
  const bool is_small =
      std::ranges::all_of(layout.size, [](int size) { return size <= reader::most_cells_along_an_axis; });
  if (is_small && layout.fits(static_cast<std::int64_t>(n_elements)))
    return true;
  faults.push_back({"", 0, key,
                    fmt::format("sizes > 0, and every voxel among the {} elements of the array", n_elements),
                    words(layout)});
  return false;
}

/// Calls visit(element number) for every voxel, x fastest.
template<class Visit>
void for_each_voxel(const ArrayLayout& layout, Visit&& visit) {
  for (int k = 0; k < layout.size[2]; ++k)
    for (int j = 0; j < layout.size[1]; ++j)
      for (int i = 0; i < layout.size[0]; ++i)
        visit(static_cast<std::size_t>(layout.element({i, j, k})));
}

/// Sets spacing, position and orientation of voxels, by the rules for image files.
void set_geometry(const Affine& affine, ImageInfo& info, std::vector<Fault>& faults) {
  constexpr const char* key = "specimen.affine";
  if (affine[3] != std::array<double, 4>{0, 0, 0, 1})
    faults.push_back({"", 0, key, "a last row 0 0 0 1",
                      fmt::format("{} {} {} {}", affine[3][0], affine[3][1], affine[3][2], affine[3][3])});
  const std::vector<Fault> found = set_affine(info, affine, key);
  faults.insert(faults.end(), found.begin(), found.end());
}

} // namespace

SceneBuilder::SceneBuilder(std::string name) : name_(std::move(name)) {}

SceneBuilder& SceneBuilder::title(std::string text) {
  title_ = std::move(text);
  return *this;
}

SceneBuilder& SceneBuilder::box(int dimension, const Index3& cells, const Vec3& spacing) {
  body_ = BoxBody{dimension, cells, spacing};
  return *this;
}

template<class Label>
SceneBuilder& SceneBuilder::copy_labels(std::span<const Label> values, const ArrayLayout& layout,
                                        const Affine& affine) {
  LabelBody body;
  body.image.info.size = layout.size;
  set_geometry(affine, body.image.info, body.faults);
  if (check_layout(layout, values.size(), "specimen.layout", body.faults)) {
    std::optional<std::int64_t> too_large;
    body.image.values.reserve(layout.n_voxels());
    for_each_voxel(layout, [&](std::size_t element) {
      const std::int64_t label = values[element];
      if (!reader::is_label(label))
        too_large = label;
      body.image.values.push_back(static_cast<float>(label));
    });
    if (too_large)
      body.faults.push_back(
          {"", 0, "specimen.labels", reader::wanted_label(), fmt::format("{}", *too_large)});
  }
  body_ = std::move(body);
  return *this;
}

SceneBuilder& SceneBuilder::world(WorldAxes axes) {
  if (auto* const labels = std::get_if<LabelBody>(&body_))
    labels->image.info.world = axes;
  return *this;
}

SceneBuilder& SceneBuilder::labels(std::span<const std::uint8_t> values, const ArrayLayout& layout,
                                   const Affine& voxels_to_world) {
  return copy_labels(values, layout, voxels_to_world);
}

SceneBuilder& SceneBuilder::labels(std::span<const std::uint16_t> values, const ArrayLayout& layout,
                                   const Affine& voxels_to_world) {
  return copy_labels(values, layout, voxels_to_world);
}

SceneBuilder& SceneBuilder::labels(std::span<const std::int16_t> values, const ArrayLayout& layout,
                                   const Affine& voxels_to_world) {
  return copy_labels(values, layout, voxels_to_world);
}

SceneBuilder& SceneBuilder::labels(std::span<const std::int32_t> values, const ArrayLayout& layout,
                                   const Affine& voxels_to_world) {
  return copy_labels(values, layout, voxels_to_world);
}

SceneBuilder& SceneBuilder::labels(std::span<const std::int64_t> values, const ArrayLayout& layout,
                                   const Affine& voxels_to_world) {
  return copy_labels(values, layout, voxels_to_world);
}

SceneBuilder& SceneBuilder::material(MaterialChoice choice) {
  materials_.push_back({std::nullopt, std::move(choice)});
  return *this;
}

SceneBuilder& SceneBuilder::material(std::int64_t label, MaterialChoice choice) {
  materials_.push_back({label, std::move(choice)});
  return *this;
}

SceneBuilder& SceneBuilder::plane(PlaneAssumption assumption) {
  plane_ = assumption;
  return *this;
}

SceneBuilder& SceneBuilder::fibre(const Vec3& direction) {
  fibre_ = direction;
  fibres_.reset();
  return *this;
}

SceneBuilder& SceneBuilder::fibres(std::span<const std::array<float, 3>> directions,
                                   const ArrayLayout& layout) {
  FibreArray array;
  array.size = layout.size;
  if (check_layout(layout, directions.size(), "specimen.fibre", array.faults))
    for_each_voxel(layout, [&](std::size_t element) { array.values.push_back(directions[element]); });
  fibres_ = std::move(array);
  return *this;
}

SceneBuilder& SceneBuilder::hold(Where where, std::optional<std::string> axes) {
  holds_.push_back({std::move(where), {}, std::move(axes)});
  return *this;
}

SceneBuilder& SceneBuilder::move(Where where, const Vec3& by, std::optional<std::string> axes) {
  moves_.push_back({std::move(where), by, std::move(axes)});
  return *this;
}

SceneBuilder& SceneBuilder::traction(Where where, const Vec3& pascal) {
  loads_.push_back({LoadKind::traction, std::move(where), pascal});
  return *this;
}

SceneBuilder& SceneBuilder::force(Where where, const Vec3& newton) {
  loads_.push_back({LoadKind::force, std::move(where), newton});
  return *this;
}

SceneBuilder& SceneBuilder::gravity(const Vec3& acceleration) {
  loads_.push_back({LoadKind::gravity, std::nullopt, acceleration});
  return *this;
}

SceneBuilder& SceneBuilder::contraction(double pascal, std::optional<Where> where) {
  loads_.push_back({LoadKind::contraction, std::move(where), {pascal, 0, 0}});
  return *this;
}

SceneBuilder& SceneBuilder::limits(const LimitSettings& settings) {
  limits_ = settings;
  return *this;
}

SceneBuilder& SceneBuilder::strain(Strain strain) {
  strain_ = strain;
  return *this;
}

SceneBuilder& SceneBuilder::relaxation(const RelaxationSettings& settings) {
  relaxation_ = settings;
  return *this;
}

SceneBuilder& SceneBuilder::measure(std::string name, std::string keys) {
  measures_.emplace_back(std::move(name), std::move(keys));
  return *this;
}

SceneBuilder& SceneBuilder::keys(std::string toml, std::filesystem::path folder) {
  keys_ = std::move(toml);
  folder_ = std::move(folder);
  return *this;
}

SceneBuilder& SceneBuilder::keys(std::shared_ptr<const KeyTable> table, std::filesystem::path folder) {
  table_ = std::move(table);
  folder_ = std::move(folder);
  return *this;
}

std::variant<Scene, std::vector<Fault>> SceneBuilder::try_build() const {
  try {
    return build();
  } catch (const InputError& error) {
    return error.faults();
  }
}

Index3 first_cell(const Specimen& specimen) {
  Index3 first{};
  for (int a = 0; a < specimen.grid.dimension(); ++a)
    first[a] = static_cast<int>(std::lround(specimen.origin[a] / specimen.grid.spacing()[a]));
  return first;
}

ArrayLayout ArrayLayout::x_fastest(const Index3& size) {
  return {size, {1, size[0], std::int64_t{1} * size[0] * size[1]}, 0};
}

ArrayLayout ArrayLayout::z_fastest(const Index3& size) {
  return {size, {std::int64_t{1} * size[1] * size[2], size[2], 1}, 0};
}

bool ArrayLayout::fits(std::int64_t n_elements) const {
  // Strides are arbitrary: sums in 128 bits do not overflow.
  __extension__ typedef __int128 Wide;
  Wide low = first, high = first, voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (size[a] < 1)
      return false;
    const Wide reach = Wide{size[a] - 1} * stride[a];
    low += std::min(reach, Wide{0});
    high += std::max(reach, Wide{0});
    voxels *= size[a];
  }
  return low >= 0 && high < n_elements && voxels <= n_elements;
}

Affine affine_of(const Vec3& spacing, const Vec3& origin, const std::array<Vec3, 3>& direction) {
  Affine affine{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      affine[row][column] = direction[row][column] * spacing[column];
    affine[row][3] = origin[row];
  }
  affine[3][3] = 1;
  return affine;
}

} // namespace maille
