#include "maille/base/vectors.hpp"
#include "maille/scene/warp/warp.hpp"
#include "warp/deformed_cells.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace maille {

namespace {

using namespace warping;

/// Corners of a cell's face in the order of a right-handed outward normal.
constexpr std::array<std::array<int, 4>, 6> corners_of_faces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

class Surfaces {
public:
  Surfaces(const DeformedBody& body, const std::vector<Material>& materials)
      : specimen_(*body.specimen), u_(*body.displacement), materials_(materials),
        of_node_(static_cast<std::size_t>(specimen_.grid.n_nodes()), -1) {}

  std::vector<BodySurface> all() {
    std::map<std::int32_t, std::vector<std::int64_t>> cells;
    for (std::int64_t cell = 0; cell < specimen_.grid.n_cells(); ++cell)
      if (specimen_.is_matter(cell))
        cells[part_of(cell)].push_back(cell);
    std::vector<BodySurface> surfaces;
    for (const auto& [part, list] : cells)
      surfaces.push_back(surface(part, list));
    return surfaces;
  }

private:
  std::int32_t part_of(std::int64_t cell) const {
    return specimen_.label.empty() ? specimen_.material(cell) : specimen_.label[cell];
  }
  bool is_of(std::int32_t part, const Index3& at) const {
    return specimen_.grid.has_cell(at) && specimen_.is_matter(specimen_.grid.cell(at)) &&
           part_of(specimen_.grid.cell(at)) == part;
  }

  BodySurface surface(std::int32_t part, const std::vector<std::int64_t>& cells) {
    BodySurface made;
    const std::string& material = materials_.at(specimen_.material(cells.front())).name;
    made.name = specimen_.label.empty() ? material : fmt::format("{} {}", part, material);
    made.part = part;
    made.world = specimen_.placement.world;
    const double handedness = determinant(specimen_.placement.direction);
    std::vector<std::int64_t> used;
    for (const std::int64_t cell : cells) {
      const Index3 at = specimen_.grid.cell_at(cell);
      for (std::size_t face = 0; face < 6; ++face) {
        Index3 next = at;
        next[face / 2] += face % 2 == 0 ? -1 : 1;
        if (is_of(part, next))
          continue;
        std::array<std::int32_t, 4> quad{};
        for (std::size_t c = 0; c < 4; ++c)
          quad[c] = point(specimen_.grid.corner(at, corners_of_faces[face][c]), made, used);
        if (handedness < 0)
          std::swap(quad[1], quad[3]);
        made.quads.push_back(quad);
      }
    }
    for (const std::int64_t node : used)
      of_node_[node] = -1;
    return made;
  }

  std::int32_t point(std::int64_t node, BodySurface& surface, std::vector<std::int64_t>& used) {
    std::int32_t& number = of_node_[node];
    if (number < 0) {
      number = static_cast<std::int32_t>(surface.points.size());
      used.push_back(node);
      Vec3 x = specimen_.position(specimen_.grid.node_at(node));
      for (std::size_t a = 0; a < 3; ++a)
        x[a] += u_(a, node);
      surface.points.push_back(point_in_world(specimen_.placement, x));
    }
    return number;
  }

  const Specimen& specimen_;
  const Displacement& u_;
  const std::vector<Material>& materials_;
  std::vector<std::int32_t> of_node_; ///< point numbers in the current surface
};

} // namespace

std::vector<BodySurface> surfaces_of(const DeformedBody& body, const std::vector<Material>& materials) {
  check(body);
  return Surfaces(body, materials).all();
}

} // namespace maille
