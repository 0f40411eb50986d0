/// Neighbour search and contact detection of a balance.

#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Search distance for surfaces [cells]: two surfaces may approach each other by a step each.
constexpr double reach_over_cell = step_over_cell + step_over_cell;
/// Extra search distance: skins may move by half of it between two searches, and by half in the rounds after
/// a search.
constexpr double margin_over_cell = reach_over_cell + reach_over_cell;

} // namespace

void Balance::find_touches() {
  has_looked_ = false;
  measure_touches();
}

/// Finds pairs of objects, and borders of the world, that are near each other or may soon be.
void Balance::look_around() {
  const double within = (reach_over_cell + margin_over_cell) * cell_;
  near_pairs_.clear();
  near_borders_.clear();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const SurfaceObject& one = objects_[i];
    Eigen::AlignedBox3d box = one.box;
    box.min().array() -= within;
    box.max().array() += within;
    for (std::size_t j = 0; j < objects_.size(); ++j) {
      const SurfaceObject& other = objects_[j];
      if (i == j ? one.is_body() && world_.body(static_cast<int>(i))
                                        .self_contact()
                                        .may_meet({one.soft->displacement().data(),
                                                   static_cast<std::size_t>(one.soft->displacement().size())},
                                                  within)
                 : (one.kind != ObjectKind::fixed || other.kind != ObjectKind::fixed) &&
                       box.intersects(other.box))
        near_pairs_.push_back({static_cast<int>(i), static_cast<int>(j), {}});
    }
    for (int axis = 0; axis < one.dimension && one.kind != ObjectKind::fixed; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double end = world_.scene.cells[a] * world_.scene.spacing[a];
      NearBorder border{static_cast<int>(i), axis, {}};
      if (one.box.min()[axis] <= within || one.box.max()[axis] >= end - within)
        for (std::int32_t node = 0; node < one.skin.n_nodes(); ++node)
          if (const double x = one.at[node][axis]; x <= within || x >= end - within)
            border.nodes.push_back(node);
      if (!border.nodes.empty())
        near_borders_.push_back(std::move(border));
    }
  }
  for (auto& [i, j, nodes] : near_pairs_) {
    const SurfaceObject &one = object(i), &two = object(j);
    NearFaces& near = near_faces_[{i, j}];
    near.update(one.skin, one.at, two.skin, two.at, reach_over_cell * cell_, margin_over_cell * cell_);
    std::ranges::copy_if(near.nodes(), std::back_inserter(nodes), [&](const NearFaces::OfNode& of_node) {
      return !one.is_held(of_node.node) || std::ranges::any_of(near.faces(of_node), [&](std::int32_t face) {
        return std::ranges::any_of(two.skin.face(face).node,
                                   [&](std::int32_t node) { return node >= 0 && !two.is_held(node); });
      });
    });
  }
  has_looked_ = true;
  motion_since_search_ = 0;
}

/// Selects the nodes that rounds move: those near other surfaces, and those that their normals depend on.
void Balance::watch() {
  std::vector<std::vector<char>> is_watched;
  for (const SurfaceObject& one : objects_)
    is_watched.emplace_back(one.is_body() ? one.rest.size() : 0, 0);
  const auto mark = [&](int object, std::int32_t node) {
    if (std::vector<char>& of = is_watched[object]; !of.empty())
      of[node] = 1;
  };
  const auto mark_about = [&](int object, std::int32_t face) {
    const Skin& skin = this->object(object).skin;
    for (const std::int32_t node : skin.face(face).node)
      if (node >= 0)
        for (const std::int32_t beside : skin.faces_at(node))
          for (const std::int32_t corner : skin.face(beside).node)
            if (corner >= 0)
              mark(object, corner);
  };
  for (const auto& [i, j, nodes] : near_pairs_) {
    const NearFaces& near = near_faces_[{i, j}];
    for (const NearFaces::OfNode& of_node : nodes) {
      mark(i, of_node.node);
      if (object(j).is_body())
        for (const std::int32_t face : near.faces(of_node))
          mark_about(j, face);
    }
  }
  for (const NearBorder& border : near_borders_)
    for (const std::int32_t node : border.nodes)
      mark(border.object, node);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    SurfaceObject& one = objects_[i];
    if (!one.is_body())
      continue;
    std::vector<std::int32_t> watched;
    for (std::int32_t node = 0; node < one.skin.n_nodes(); ++node)
      if (is_watched[i][node] != 0)
        watched.push_back(node);
    if (one.soft->watch(std::move(watched)))
      past_.clear(); // their displacements are of other nodes
  }
}

void Balance::measure_touches() {
  if (!has_looked_) {
    look_around();
    if (is_local())
      watch();
  }
  std::vector<Touch> before;
  before.swap(touches_);
  for (const auto& [i, j, nodes] : near_pairs_)
    add_touches(i, j, nodes);
  for (const NearBorder& border : near_borders_)
    add_border(border);
  const auto key = [](const Touch& touch) { return std::tuple(touch.object, touch.other, touch.node); };
  std::ranges::stable_sort(touches_, {}, key);
  for (Touch& touch : touches_) { // `before` has the same order
    const auto known = std::ranges::lower_bound(before, key(touch), {}, key);
    if (known != before.end() && key(*known) == key(touch))
      touch.force = known->force;
  }
}

void Balance::add_touches(int object, int other, std::span<const NearFaces::OfNode> nodes) {
  const SurfaceObject &one = this->object(object), &two = this->object(other);
  const double reach = reach_over_cell * cell_;
  const NearFaces& near_faces = near_faces_[{object, other}];
  const PlacedSkin own(one.skin, one.at, one.rest, reach), skin(two.skin, two.at, two.rest, reach);
  for (const NearFaces::OfNode& of_node : nodes) {
    if (one.is_flat(of_node.node))
      continue;
    for (const PlacedSkin::Near& near : skin.near(one.at[of_node.node], near_faces.faces(of_node),
                                                  two.is_body() ? nullptr : &own, of_node.node)) {
      Touch touch;
      touch.object = object;
      touch.other = other;
      touch.node = of_node.node;
      touch.nodes = near.node;
      touch.weights = near.weight;
      touch.normal = near.normal;
      touch.gap = near.gap;
      const bool can_move = !one.is_held_along(touch.node, touch.normal) ||
                            std::ranges::any_of(touch.nodes, [&](std::int32_t node) {
                              return node >= 0 && !two.is_held_along(node, touch.normal);
                            });
      if (can_move)
        touches_.push_back(touch);
    }
  }
}

void Balance::add_border(const NearBorder& border) {
  const SurfaceObject& one = object(border.object);
  const auto a = static_cast<std::size_t>(border.axis);
  const double reach = reach_over_cell * cell_, end = world_.scene.cells[a] * world_.scene.spacing[a];
  for (const std::int32_t node : border.nodes)
    for (const int direction : {1, -1}) {
      const double x = one.at[node][border.axis];
      Touch touch;
      touch.gap = direction > 0 ? x : end - x;
      if (touch.gap > reach)
        continue;
      touch.object = border.object;
      touch.node = node;
      touch.normal[border.axis] = direction;
      if (!one.is_held_along(node, touch.normal))
        touches_.push_back(touch);
    }
}

} // namespace maille::deform
