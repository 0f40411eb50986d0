/// Detection of overlaps in which no corner of either object is inside the other, and restoration of an
/// earlier state.

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"
#include "world/cell_overlap.hpp"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

/// Cells of an object with faces or corners near another object, at the present positions of their corners.
std::vector<ConvexCell> Balance::cells_near(int number, int other) {
  SurfaceObject& one = object(number);
  std::vector<std::int32_t> cells;
  const auto add = [&](std::int32_t face) { cells.push_back(one.skin.face(face).cell); };
  for (const NearFaces::OfNode& near : near_faces_[{number, other}].nodes())
    for (const std::int32_t face : one.skin.faces_at(near.node))
      add(face);
  for (const NearFaces::OfNode& near : near_faces_[{other, number}].nodes())
    for (const std::int32_t face : near_faces_[{other, number}].faces(near))
      add(face);
  sort_uniquely(cells);
  std::vector<ConvexCell> list;
  for (const std::int32_t cell : cells)
    list.emplace_back(one.corners(cell));
  return list;
}

std::optional<std::pair<int, int>> Balance::crossing() {
  if (!has_looked_) {
    look_around();
    has_looked_ = false; // the watched nodes are not updated
  }
  const double depth = step_over_cell * cell_;
  const auto may_cross = [&](const SurfaceObject& one, const SurfaceObject& other) { // bodies' boxes lag
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
  State now{{}, touches_, pressing_, grips_, distance_to_unloaded_};
  for (const SurfaceObject& one : objects_)
    now.objects.push_back(
        {one.pose, one.rigid.target, one.soft ? std::optional(one.soft->state()) : std::nullopt});
  return now;
}

void Balance::restore(const State& state) {
  touches_ = state.touches;
  pressing_ = state.pressing;
  grips_ = state.grips;
  distance_to_unloaded_ = state.behind;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    SurfaceObject& one = objects_[i];
    const State::Object& then = state.objects[i];
    one.pose = then.pose;
    one.rigid.target = then.target;
    if (one.soft)
      one.soft->restore(*then.soft);
    one.place();
  }
  has_looked_ = false;
}

} // namespace maille::deform
