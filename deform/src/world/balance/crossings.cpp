/// Matter in other matter where no corner of either is in the other, and the way back out of it.

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"
#include "world/cell_overlap.hpp"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

/// Cells of an object whose faces or corners are near another, where their corners are now.
std::vector<ConvexCell> Balance::cells_near(int number, int other) {
  BalancedObject& one = object(number);
  const Specimen& body = world_.scene.objects[static_cast<std::size_t>(number)].scene.specimen;
  const Grid& grid = body.grid;
  if (one.matter.empty()) {
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
      if (body.is_matter(cell))
        one.matter.push_back(cell);
    one.skin_node.assign(static_cast<std::size_t>(grid.n_nodes()), -1);
    for (std::int32_t node = 0; node < one.skin.n_nodes(); ++node)
      one.skin_node[static_cast<std::size_t>(one.skin.node(node))] = node;
  }
  std::vector<std::int32_t> cells;
  const auto add = [&](std::int32_t face) { cells.push_back(one.skin.face(face).cell); };
  for (const NearFaces::OfNode& near : near_faces_[{number, other}].nodes())
    for (const std::int32_t face : one.skin.faces_at(near.node))
      add(face);
  for (const NearFaces::OfNode& near : near_faces_[{other, number}].nodes())
    for (const std::int32_t face : near_faces_[{other, number}].faces(near))
      add(face);
  sort_uniquely(cells);
  const auto place = [&](const Index3& node) {
    if (const std::int32_t known = one.skin_node[static_cast<std::size_t>(grid.node(node))]; known >= 0)
      return one.at[static_cast<std::size_t>(known)];
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int a = 0; a < one.dimension; ++a) {
      const auto i = static_cast<std::size_t>(a);
      x[a] = one.is_body() ? body.position(node)[i] : node[i] * grid.spacing()[i];
    }
    if (one.is_body())
      x.head(one.dimension) += one.displacement.segment(
          std::int64_t{one.dimension} * world_.body(number).lattice().voxel(grid.node(node)), one.dimension);
    return Eigen::Vector3d(one.pose.position + one.pose.rotation * x);
  };
  std::vector<ConvexCell> list;
  for (const std::int32_t cell : cells) {
    const Index3 at = grid.cell_at(one.matter[static_cast<std::size_t>(cell)]);
    std::vector<Eigen::Vector3d> corners;
    for (int corner = 0; corner < 1 << one.dimension; ++corner)
      corners.push_back(place({at[0] + (corner & 1), at[1] + (corner >> 1 & 1), at[2] + (corner >> 2)}));
    list.emplace_back(std::move(corners));
  }
  return list;
}

std::optional<std::pair<int, int>> Balance::crossing() {
  if (!has_looked_) {
    look_around();
    has_looked_ = false; // rounds have watched nothing of it
  }
  const double depth = step_over_cell * cell_;
  const auto may_cross = [&](const BalancedObject& one, const BalancedObject& other) { // boxes of bodies lag
    return one.is_body() || other.is_body() ||
           may_be_in_one_another(one.box, other.box, one.dimension, depth);
  };
  for (const auto& [i, j, nodes] : near_pairs_)
    if (i < j && may_cross(object(i), object(j)) &&
        are_in_one_another(cells_near(i, j), cells_near(j, i), depth))
      return std::pair(i, j);
  return std::nullopt;
}

Balance::State Balance::state() const {
  State now{{}, touches_, pressing_, grips_, behind_};
  for (const BalancedObject& one : objects_)
    now.objects.push_back(
        {one.pose, one.target, one.displacement, one.unloaded, one.contact_forces, one.pull, one.forced});
  return now;
}

void Balance::restore(const State& state) {
  touches_ = state.touches;
  pressing_ = state.pressing;
  grips_ = state.grips;
  behind_ = state.behind;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    BalancedObject& one = objects_[i];
    const State::Object& then = state.objects[i];
    one.pose = then.pose;
    one.target = then.target;
    one.displacement = then.displacement;
    one.unloaded = then.unloaded;
    one.contact_forces = then.contact_forces;
    one.pull = then.pull;
    one.forced = then.forced;
    one.place();
  }
  has_looked_ = false;
}

} // namespace maille::deform
