/// What touches what in a balance.

#include "world/balance/balance.hpp"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace maille::deform {

namespace {

constexpr double reach_over_cell = 0.5; ///< what is nearer than this is looked at
/// That skins may move before it is looked anew what may come near.
constexpr double margin_over_cell = 0.5;

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
  const PlacedSkin skin(two.skin, two.at, reach);
  for (const NearFaces::OfNode& of_node : near_faces.nodes())
    for (const PlacedSkin::Near& near :
         skin.near(one.at[static_cast<std::size_t>(of_node.node)], near_faces.faces(of_node))) {
      Touch touch;
      touch.object = object;
      touch.other = other;
      touch.node = of_node.node;
      touch.nodes = near.node;
      touch.weights = near.weight;
      touch.normal = near.normal;
      touch.gap = near.gap;
      touches_.push_back(touch);
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
