#pragma once
/// Outer faces of objects, their positions, and neighbour search between them.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

/// Closed surface of one object: the outer faces of its cells, between the cells' corners. Faces are segments
/// in two dimensions and pairs of triangles in three.
class Skin {
public:
  explicit Skin(const Specimen& specimen);

  struct Face {
    std::array<std::int32_t, 4> node; ///< of the skin; cyclic, outside to the right; two in 2D, else -1
    std::int32_t cell;                ///< of matter, counted in the order of the grid
  };
  int dimension() const { return dimension_; }
  std::int32_t n_nodes() const { return static_cast<std::int32_t>(nodes_.size()); }
  /// Node of the grid.
  std::int64_t node(std::int32_t number) const { return nodes_[number]; }
  std::span<const Face> faces() const { return faces_; }
  const Face& face(std::int32_t number) const { return faces_[number]; }
  /// Faces at a node.
  std::span<const std::int32_t> faces_at(std::int32_t node) const { return at_node_[node]; }
  /// A cell of matter with this node.
  std::int32_t cell_at(std::int32_t node) const { return faces_[faces_at(node).front()].cell; }
  std::int32_t n_cells() const { return static_cast<std::int32_t>(beside_.size()); }
  /// Marks the cells near a node: those of its faces, and all within two steps of these through faces of
  /// cells. All cells around a corner are near it, whether or not they are connected.
  /// @param marks by cell of matter
  void mark_near(std::int32_t node, std::int32_t mark, std::vector<std::int32_t>& marks) const;

private:
  void add_faces(const Specimen& specimen, const std::vector<std::int32_t>& cell_number);
  int dimension_;
  std::vector<std::int64_t> nodes_;
  std::vector<Face> faces_;
  std::vector<std::vector<std::int32_t>> at_node_;
  std::vector<std::array<std::int32_t, 6>> beside_; ///< neighbours of a cell through its faces; -1: none
};

/// A skin with its nodes at places in the world [m].
///
/// Normals are continuous across faces that meet at less than 40 degrees at rest: the normal at a corner is
/// the mean of those of the faces around it, and is interpolated between corners. A point that slides over a
/// bent surface therefore meets no edge, and the edges of a box stay sharp. The set of edges does not change
/// while rounds bend a body.
///
/// Source  Phong 1975 (Comm. ACM 18), for shading; Puso and Laursen 2004 (Comput. Methods Appl. Mech.
///         Eng. 193), for contact
class PlacedSkin {
public:
  /// @param rest  positions of the nodes at rest
  PlacedSkin(const Skin& skin, std::span<const Eigen::Vector3d> places, std::span<const Eigen::Vector3d> rest,
             double reach)
      : skin_(skin), places_(places), rest_(rest), reach_(reach) {}

  /// A point of the skin near a given point.
  struct Near {
    std::array<std::int32_t, 4> node{-1, -1, -1, -1}; ///< of the face
    std::array<double, 4> weight{};                   ///< of the nodes; the sum is 1
    std::int32_t face = 0;
    Eigen::Vector3d normal; ///< unit vector from the skin to a point outside; outward for a point inside
    double gap = 0;         ///< distance along the normal [m]; negative inside
  };
  /// For a point outside: all local minima of the distance within `reach`. For a point inside: only the
  /// nearest point. On a sharp edge the normal is undefined; if the point's own skin faces exactly one of the
  /// faces there, that face is used.
  /// @param faces  candidate faces, sorted: must include all faces within reach
  /// @param own, node  skin and node of the point, if it is a node
  std::vector<Near> near(const Eigen::Vector3d& point, std::span<const std::int32_t> faces,
                         const PlacedSkin* own = nullptr, std::int32_t node = -1) const;
  /// Outward unit normal.
  Eigen::Vector3d normal_of(std::int32_t face) const;

private:
  struct Closest {
    std::int32_t face;
    std::array<double, 4> weight;
    Eigen::Vector3d place;
    double distance;
    bool is_within; ///< in the interior of the face, not on its border
  };
  const Eigen::Vector3d& at(std::int32_t node) const { return places_[node]; }
  bool is_edge(std::int32_t face, std::int32_t other) const;
  Closest closest(std::int32_t face, const Eigen::Vector3d& point) const;
  Eigen::Vector3d smooth_normal(const Closest& one) const;
  std::vector<Near> nearest(const Eigen::Vector3d& point, std::vector<Closest>& found) const;
  std::optional<Near> faced(const Eigen::Vector3d& point, std::span<const Closest> found,
                            const PlacedSkin& own, std::int32_t node) const;

  const Skin& skin_;
  std::span<const Eigen::Vector3d> places_, rest_;
  double reach_;
};

/// Cached neighbour search: for nodes of one skin, the faces of another that are near or may soon be near.
/// Updated for nodes and faces that have moved so far that a pair may be missing.
class NearFaces {
public:
  /// @param nodes, faces  positions of the nodes of the two skins [m]; equal for a skin and itself, where
  ///                      faces of cells near a node (Skin::mark_near) are ignored
  /// @param reach         search distance of the caller
  /// @param margin        extra distance against missing pairs: both may move by half of it before an
  ///                      update searches again, and by half of it after an update
  void update(const Skin& of_nodes, std::span<const Eigen::Vector3d> nodes, const Skin& of_faces,
              std::span<const Eigen::Vector3d> faces, double reach, double margin);

  struct OfNode {
    std::int32_t node = 0;
    std::size_t first = 0, end = 0; ///< into faces()
  };
  /// Data of each node.
  std::span<const OfNode> nodes() const { return nodes_; }
  /// Sorted for each node.
  std::span<const std::int32_t> faces(const OfNode& one) const {
    return std::span(faces_).subspan(one.first, one.end - one.first);
  }

private:
  using Pair = std::pair<std::int32_t, std::int32_t>; ///< of a node and a face
  void find(const Skin& of_nodes, std::span<const std::int32_t> nodes, const Skin& of_faces,
            std::span<const std::int32_t> faces, double reach, std::vector<Pair>& pairs) const;

  std::vector<OfNode> nodes_;
  std::vector<std::int32_t> faces_;
  std::vector<Eigen::Vector3d> nodes_then_, faces_then_; ///< positions at the last search
};

} // namespace maille::deform
