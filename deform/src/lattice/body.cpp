#include "lattice/body.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace maille::deform {

namespace {

std::int64_t padded_row(const Grid& grid) {
  return (grid.nodes()[0] + line_of_floats - 1) / line_of_floats * line_of_floats;
}

std::size_t padded_size(const Grid& grid) {
  return static_cast<std::size_t>(padded_row(grid) * grid.nodes()[1] * grid.nodes()[2]);
}

std::size_t words_of_bits(const Grid& grid) {
  return static_cast<std::size_t>((grid.n_nodes() + 63) / 64);
}

bool is_held_somewhere(const Scene& scene, int component) {
  return std::ranges::any_of(scene.prescribed,
                             [&](const Prescribed& p) { return p.held && p.component == component; });
}

bool fills_grid(const Specimen& body) {
  return body.n_matter_cells() == body.grid.n_cells();
}

} // namespace

Body::Body(const Scene& scene) : scene_(&scene), row_stride_(padded_row(scene.specimen.grid)) {
  const Grid& grid = scene.specimen.grid;
  for (int component = 0; component < grid.dimension(); ++component) {
    const auto b = static_cast<std::size_t>(component);
    displacement_[b] = AlignedArray<float>(padded_size(grid));
    if (is_held_somewhere(scene, component))
      held_[b] = Bits(words_of_bits(grid));
  }
  for (const Prescribed& p : scene.prescribed)
    if (p.held)
      set_bit(held_[p.component], p.node);
  if (fills_grid(scene.specimen))
    return;
  matter_ = Bits(words_of_bits(grid));
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (scene.specimen.is_node(grid.node_at(node)))
      set_bit(matter_, node);
}

Field<float> Body::field(int component) {
  return {displacement_[component].data(), grid().nodes(), row_stride_, row_stride_ * grid().nodes()[1]};
}

Field<const float> Body::field(int component) const {
  return {displacement_[component].data(), grid().nodes(), row_stride_, row_stride_ * grid().nodes()[1]};
}

double Body::displacement(int component, const Index3& node) const {
  return offset(component) + double{field(component).at(node)};
}

Displacement Body::displacement() const {
  Displacement all(grid());
  copy_to(all);
  return all;
}

void Body::copy_to(Displacement& state) const {
  const Index3& n = grid().nodes();
  for (int component = 0; component < dimension(); ++component) {
    const Field<const float> stored = field(component);
    const double by = offset(component);
    double* to = state.component(component).data();
    std::int64_t node = 0;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y, to += n[0]) {
        const float* const row = stored.row(y, z);
        if (fills_its_grid()) {
          for (int x = 0; x < n[0]; ++x)
            to[x] = by + double{row[x]};
          continue;
        }
        for (int x = 0; x < n[0]; ++x, ++node)
          if (is_matter(node))
            to[x] = by + double{row[x]};
      }
  }
}

Footprint Body::footprint(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const auto floats = static_cast<std::int64_t>(padded_size(grid) * sizeof(float)),
             bits = static_cast<std::int64_t>(words_of_bits(grid) * sizeof(std::uint64_t));
  Footprint footprint;
  for (int component = 0; component < grid.dimension(); ++component)
    footprint.push_back({fmt::format("displacement {}", "xyz"[component]), floats,
                         "float32 a node, rows padded to cache lines"});
  if (!fills_grid(scene.specimen))
    footprint.push_back({"matter", bits, "one bit a grid point: the body does not fill its grid"});
  for (int component = 0; component < grid.dimension(); ++component)
    if (is_held_somewhere(scene, component))
      footprint.push_back(
          {fmt::format("held {}", "xyz"[component]), bits, "one bit a grid point: something is held"});
  return footprint;
}

} // namespace maille::deform
