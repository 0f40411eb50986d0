#pragma once
/// The outer faces of objects, where they are, and what lies near them.

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
  /// Node of the grid.
  std::int64_t node(std::int32_t number) const { return nodes_[number]; }
  std::span<const Face> faces() const { return faces_; }
  const Face& face(std::int32_t number) const { return faces_[number]; }
  /// Faces at a node.
  std::span<const std::int32_t> faces_at(std::int32_t node) const { return at_node_[node]; }
  /// A cell of matter that has the node.
  std::int32_t cell_at(std::int32_t node) const { return faces_[faces_at(node).front()].cell; }
  std::int32_t n_cells() const { return static_cast<std::int32_t>(beside_.size()); }
  /// Puts `mark` on the cells near a node: those of its faces, and what is within two steps of one of them
  /// through faces of cells. All cells that meet at a corner are near it, whatever is between them.
  /// @param marks of all cells of matter
  void mark_near(std::int32_t node, std::int32_t mark, std::vector<std::int32_t>& marks) const;

private:
  void add_faces(const Specimen& specimen, const std::vector<std::int32_t>& cell_number);
  int dimension_;
  std::vector<std::int64_t> nodes_;
  std::vector<Face> faces_;
  std::vector<std::vector<std::int32_t>> at_node_;
  std::vector<std::array<std::int32_t, 6>> beside_; ///< of a cell, through its faces; -1: nothing
};

/// A skin with its nodes at places in the world [m].
///
/// Normals go over from one face to the next where these are at less than 40 degrees to one another at rest:
/// a face's normal at a corner is the mean of those about it, and between corners it is interpolated. So a
/// point that slides over creases of a surface that is bent meets no edge, an edge of a box stays one, and
/// none comes or goes while rounds bend a body.
///
/// Source  Phong 1975 (Comm. ACM 18), for shading; Puso and Laursen 2004 (Comput. Methods Appl. Mech.
///         Eng. 193), for contact
class PlacedSkin {
public:
  /// @param rest  places in the shape at rest
  PlacedSkin(const Skin& skin, std::span<const Eigen::Vector3d> places, std::span<const Eigen::Vector3d> rest,
             double reach)
      : skin_(skin), places_(places), rest_(rest), reach_(reach) {}

  /// A place of the skin near a point.
  struct Near {
    std::array<std::int32_t, 4> node{-1, -1, -1, -1}; ///< of the face
    std::array<double, 4> weight{};                   ///< of the nodes at the place; they add up to 1
    std::int32_t face = 0;
    Eigen::Vector3d normal; ///< of length 1, from the matter to the point, or where that is inside, outwards
    double gap = 0;         ///< of the point before the place, along it [m]; less than 0 inside
  };
  /// Where the point is outside: every place within `reach` that no place beside it is nearer than. Where it
  /// is inside: the nearest place alone. On a sharp edge the nearest place has no normal of its own: there
  /// the face that the point's own skin faces is the one, if there is one alone.
  /// @param faces  that count, in their order: all that are within reach may be among them
  /// @param own, node  the skin that the point is of, if it is of one
  std::vector<Near> near(const Eigen::Vector3d& point, std::span<const std::int32_t> faces,
                         const PlacedSkin* own = nullptr, std::int32_t node = -1) const;
  /// Outwards, of length 1.
  Eigen::Vector3d normal_of(std::int32_t face) const;

private:
  struct Closest {
    std::int32_t face;
    std::array<double, 4> weight;
    Eigen::Vector3d place;
    double distance;
    bool is_within; ///< the face, not on its border
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

/// For nodes of one skin, the faces of another that are near them, or may soon be: found once, and again for
/// nodes and faces that have moved so far that one may be missing.
class NearFaces {
public:
  /// @param nodes, faces  where nodes of the two skins are [m]; of a skin and itself the same, and faces of
  ///                      cells near a node (Skin::mark_near) do not count
  /// @param reach         that the caller looks at
  /// @param margin        that both may move together until none may be missing any more: half of it before
  ///                      an update looks anew, and half of it after an update
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
  std::vector<Eigen::Vector3d> nodes_then_, faces_then_; ///< when they were looked at last
};

} // namespace maille::deform
