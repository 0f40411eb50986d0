#pragma once
/// The outer faces of objects, where they are, and what lies near them.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

/// The outer faces of the cells of matter of one object, between the corners of the cells. Segments in two
/// dimensions, two triangles each in three; they close the matter.
class Skin {
public:
  explicit Skin(const Specimen& specimen);

  struct Face {
    std::array<std::int32_t, 4> node; ///< of the skin; round about, outwards to the right; two in 2D, else -1
    std::int32_t cell;                ///< of matter, counted in the order of the grid
  };
  int dimension() const { return dimension_; }
  std::int32_t n_nodes() const { return static_cast<std::int32_t>(nodes_.size()); }
  /// Of the grid.
  std::int64_t node(std::int32_t number) const { return nodes_[static_cast<std::size_t>(number)]; }
  std::span<const Face> faces() const { return faces_; }
  /// Faces at a node.
  std::span<const std::int32_t> faces_at(std::int32_t node) const {
    return at_node_[static_cast<std::size_t>(node)];
  }
  /// A cell of matter that has the node.
  std::int32_t cell_at(std::int32_t node) const {
    return faces_[static_cast<std::size_t>(faces_at(node).front())].cell;
  }
  /// Whether a face is one of those at a node, or its cell within two steps through faces of one of theirs:
  /// all cells that meet at a corner are near it, whatever is between them.
  bool is_near(std::int32_t node, std::int32_t face) const;

private:
  bool are_near(std::int32_t cell, std::int32_t other) const;
  void add_faces(const Specimen& specimen, const std::vector<std::int32_t>& cell_number);
  int dimension_;
  std::vector<std::int64_t> nodes_;
  std::vector<Face> faces_;
  std::vector<std::vector<std::int32_t>> at_node_;
  std::vector<std::array<std::int32_t, 6>> beside_; ///< of a cell, through its faces; -1: nothing
  mutable std::map<std::int32_t, std::vector<std::int32_t>> near_;
};

/// A skin with its nodes at places in the world [m], sorted so that what is near a point is found.
class PlacedSkin {
public:
  PlacedSkin(const Skin& skin, std::span<const Eigen::Vector3d> places, double reach);

  /// A place of the skin near a point.
  struct Near {
    std::array<std::int32_t, 4> node{-1, -1, -1, -1}; ///< of the face
    std::array<double, 4> weight{};                   ///< of the nodes at the place; they add up to 1
    std::int32_t face = 0;
    Eigen::Vector3d normal; ///< of length 1, from the matter to the point, or where that is inside, outwards
    double gap = 0;         ///< from the place to the point along it [m]; less than 0 inside
  };
  /// Where the point is outside: every place within `reach` that no place beside it is nearer than. Where it
  /// is inside: the nearest place alone.
  /// @param passes_over (face) says which faces do not count
  template<class PassesOver>
  std::vector<Near> near(const Eigen::Vector3d& point, PassesOver&& passes_over) const;
  const Eigen::AlignedBox3d& box() const { return box_; }

private:
  struct Closest {
    std::int32_t face;
    std::array<double, 4> weight;
    Eigen::Vector3d place;
    double distance;
    bool is_within; ///< the face, not on its border
  };
  using Key = std::array<int, 3>;
  Key key_of(const Eigen::Vector3d& x) const;
  const Eigen::Vector3d& at(std::int32_t node) const { return places_[static_cast<std::size_t>(node)]; }
  Closest closest(std::int32_t face, const Eigen::Vector3d& point) const;
  Eigen::Vector3d normal_of(std::int32_t face) const;
  std::vector<Near> nearest(const Eigen::Vector3d& point, std::vector<Closest>& found) const;

  const Skin& skin_;
  std::span<const Eigen::Vector3d> places_;
  double reach_, edge_;
  Eigen::AlignedBox3d box_;
  std::vector<std::pair<Key, std::int32_t>> bins_;
};

template<class PassesOver>
std::vector<PlacedSkin::Near> PlacedSkin::near(const Eigen::Vector3d& point, PassesOver&& passes_over) const {
  std::vector<Closest> found;
  if (box_.squaredExteriorDistance(point) > reach_ * reach_)
    return {};
  const Key key = key_of(point);
  const auto less = [](const std::pair<Key, std::int32_t>& entry, const Key& wanted) {
    return entry.first < wanted;
  };
  for (auto entry = std::lower_bound(bins_.begin(), bins_.end(), key, less);
       entry != bins_.end() && entry->first == key; ++entry) {
    if (passes_over(entry->second))
      continue;
    if (const Closest one = closest(entry->second, point); one.distance <= reach_)
      found.push_back(one);
  }
  return nearest(point, found);
}

} // namespace maille::deform
