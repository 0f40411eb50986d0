/// What touches what in a balance.

#include "world/balance/balance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

namespace maille::deform {

namespace {

constexpr double reach_over_cell = 0.5; ///< what is nearer than this is looked at
/// That skins may move before it is looked anew what may come near.
constexpr double margin_over_cell = 0.5;
/// A node presses along the normal of one of its faces, give or take 60 degrees: all directions from a corner
/// of a cell are as near to one. Of a plane a node does not press aside, against an edge that slides over it.
constexpr double least_cosine = 0.5;

/// So often a node has come back to a face that it had left before it counts as one on an edge; and so far off
/// the plane of one of its faces it is not there any more.
constexpr int returns_to_edge = 2;
constexpr double off_edge_over_cell = 0.1;

Touch touch_of(const std::tuple<int, int, std::int32_t>& key, const PlacedSkin::Near& near) {
  Touch touch;
  std::tie(touch.object, touch.other, touch.node) = key;
  touch.nodes = near.node;
  touch.weights = near.weight;
  touch.face = near.face;
  touch.normal = near.normal;
  touch.gap = near.gap;
  return touch;
}

} // namespace

void Balance::find_touches() {
  std::vector<Touch> before;
  before.swap(touches_);
  const double reach = reach_over_cell * cell_;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const BalancedObject& one = objects_[i];
    Eigen::AlignedBox3d box = one.box;
    box.min().array() -= reach;
    box.max().array() += reach;
    for (std::size_t j = 0; j < objects_.size(); ++j) {
      const BalancedObject& other = objects_[j];
      if (i == j ? one.is_body() && parts_.body(static_cast<int>(i))
                                        .self_contact()
                                        .may_meet({one.displacement.data(),
                                                   static_cast<std::size_t>(one.displacement.size())},
                                                  reach)
                 : (one.kind != ObjectKind::fixed || other.kind != ObjectKind::fixed) &&
                       box.intersects(other.box))
        add_touches(static_cast<int>(i), static_cast<int>(j));
    }
    if (one.kind != ObjectKind::fixed)
      add_borders(static_cast<int>(i));
  }
  const auto key = [](const Touch& touch) { return std::tuple(touch.object, touch.other, touch.node); };
  std::ranges::stable_sort(touches_, {}, key);
  for (Touch& touch : touches_) { // both in the same order
    const auto known = std::ranges::lower_bound(before, key(touch), {}, key);
    if (known != before.end() && key(*known) == key(touch))
      touch.force = known->force;
  }
}

void Balance::add_touches(int object, int other) {
  const BalancedObject &one = objects_[static_cast<std::size_t>(object)],
                       &two = objects_[static_cast<std::size_t>(other)];
  const double reach = reach_over_cell * cell_;
  NearFaces& near_faces = near_faces_[{object, other}];
  near_faces.update(one.skin, one.at, two.skin, two.at, reach, margin_over_cell * cell_);
  const PlacedSkin skin(two.skin, two.at, reach), own(one.skin, one.at, reach);
  for (const NearFaces::OfNode& of_node : near_faces.nodes()) {
    if (add_edge_touches({object, other, of_node.node}, skin))
      continue;
    const auto faces_other = [&](const Eigen::Vector3d& direction) {
      return std::ranges::any_of(one.skin.faces_at(of_node.node), [&](std::int32_t face) {
        return own.normal_of(face).dot(direction) < -least_cosine;
      });
    };
    for (const PlacedSkin::Near& near :
         skin.near(one.at[static_cast<std::size_t>(of_node.node)], near_faces.faces(of_node), faces_other))
      touches_.push_back(touch_of({object, other, of_node.node}, near));
  }
}

/// @return whether the node lies on an edge: then there is nothing else near it that counts
bool Balance::add_edge_touches(const Key& key, const PlacedSkin& skin) {
  const auto edge = edges_.find(key);
  if (edge == edges_.end() || edge->second.returns < returns_to_edge)
    return false;
  const auto& [object, other, node] = key;
  const Eigen::Vector3d& point =
      objects_[static_cast<std::size_t>(object)].at[static_cast<std::size_t>(node)];
  std::vector<PlacedSkin::Near> planes;
  for (const std::int32_t face : edge->second.faces)
    planes.push_back(skin.at_plane(point, face));
  const auto is_off = [&](const PlacedSkin::Near& near) {
    return std::abs(near.gap) > off_edge_over_cell * cell_;
  };
  if (std::ranges::any_of(planes, is_off)) { // it has come away from there
    edges_.erase(edge);
    return false;
  }
  for (const PlacedSkin::Near& near : planes)
    touches_.push_back(touch_of(key, near));
  return true;
}

/// Which faces nodes press on, now that forces are known.
void Balance::find_edges() {
  for (const Touch& touch : touches_) {
    if (!(touch.force > 0) || touch.other < 0)
      continue;
    Edge& edge = edges_[key_of(touch)];
    if (edge.returns >= returns_to_edge || (!edge.faces.empty() && edge.faces.back() == touch.face))
      continue;
    const auto known = std::ranges::find(edge.faces, touch.face);
    if (known != edge.faces.end()) {
      ++edge.returns;
      edge.faces.erase(known);
    }
    edge.faces.push_back(touch.face);
  }
}

void Balance::add_borders(int object) {
  const BalancedObject& one = objects_[static_cast<std::size_t>(object)];
  const double reach = reach_over_cell * cell_;
  for (int axis = 0; axis < one.dimension; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double end = parts_.scene.cells[a] * parts_.scene.spacing[a];
    if (one.box.min()[axis] > reach && one.box.max()[axis] < end - reach)
      continue;
    for (std::int32_t node = 0; node < one.skin.n_nodes(); ++node)
      for (const int direction : {1, -1}) {
        const double x = one.at[static_cast<std::size_t>(node)][axis];
        Touch touch;
        touch.gap = direction > 0 ? x : end - x;
        if (touch.gap > reach)
          continue;
        touch.object = object;
        touch.node = node;
        touch.normal[axis] = direction;
        touches_.push_back(touch);
      }
  }
}

} // namespace maille::deform
