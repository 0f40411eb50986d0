#pragma once
/// The skin of a deformable body, as a point feels it.

#include "maille/deform/world/rigid_shape.hpp"
#include "maille/scene/answer.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace maille::deform {

/// Every face of a cell of matter with no matter behind it, as two triangles between its four displaced corners, in the world. The
/// triangles of a body close it: what is outside comes in through a triangle only.
///
/// Never changes once it is made, so that any number of threads may ask it.
///
/// Cost        making 0.3 us a face; a path of a cell's length 0.2 us
/// Memory      120 bytes a face
/// Checked by  tests/deform/probe/body_surface_test.cpp
class BodySurface {
public:
  /// @param scene of three dimensions @param displacement of its nodes, in its frame [m] @param pose of its frame in the world
  /// @throws std::invalid_argument for a scene of another dimension, or a body that is not finite
  BodySurface(const Scene& scene, const Displacement& displacement, const Pose& pose);

  struct Face {
    std::int64_t cell;
    int axis; ///< of its normal at rest, in the body's frame
    bool upper;
    std::array<std::int32_t, 4> corners; ///< round about, the normal by the right-hand rule outwards
  };
  std::span<const Face> faces() const { return faces_; }
  /// A corner's node, a number of the scene's grid.
  std::int64_t node(std::int32_t corner) const { return nodes_[static_cast<std::size_t>(corner)]; }
  /// Where a corner is, in the world [m].
  const Eigen::Vector3d& position(std::int32_t corner) const {
    return positions_[static_cast<std::size_t>(corner)];
  }
  const Pose& pose() const { return pose_; }

  struct Hit {
    double time; ///< 0 to 1 along the path
    std::int32_t face;
    Eigen::Vector3d normal; ///< of the triangle, outwards
    double distance,
        towards; ///< from its plane at the path's begin, and gone towards it along the whole path [m]
  };
  /// Where a straight path first comes in from outside; of places at the same time, the face of the smallest number.
  std::optional<Hit> first_hit(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  /// The same by asking every triangle: the oracle.
  std::optional<Hit> first_hit_of_every_triangle(const Eigen::Vector3d& from,
                                                 const Eigen::Vector3d& to) const;
  /// Whether a point is in the body: by how often a straight way out crosses the skin. Ways that come near an edge are not believed; where four
  /// of them do, every triangle is asked.
  /// Cost  1 us, and with the body's size along one axis
  bool is_inside(const Eigen::Vector3d& point) const;
  /// The same by the solid angle that the skin fills: the oracle. Asks every triangle.
  bool is_inside_of_every_triangle(const Eigen::Vector3d& point) const;

  /// How far before a triangle a point stops [m]: a millionth of the least spacing.
  double skin() const { return skin_; }
  std::int64_t bytes() const;

private:
  using Triangle = std::array<const Eigen::Vector3d*, 3>;

  void add_faces(const Scene& scene);
  void place_corners(const Scene& scene, const Displacement& displacement);
  void sort_into_boxes();
  Triangle triangle(std::int32_t face, int half) const;
  /// Takes the earlier of `hit` and where the path comes through the face.
  void ask(std::int32_t face, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
           std::optional<Hit>& hit) const;
  /// How often a way crosses the skin; nothing where it comes near an edge.
  std::optional<int> n_crossings(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  Index3 box_of(const Eigen::Vector3d& point) const;
  std::size_t number_of(const Index3& box) const {
    return static_cast<std::size_t>(box[0] + n_boxes_[0] * (box[1] + std::int64_t{1} * n_boxes_[1] * box[2]));
  }
  std::span<const std::int32_t> faces_in(const Index3& box) const;

  Pose pose_;
  std::vector<Face> faces_;
  std::vector<std::int64_t> nodes_;
  std::vector<Eigen::Vector3d> positions_;
  double skin_ = 0;
  // Faces by the boxes of a grid that their own boxes touch.
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(), high_ = Eigen::Vector3d::Zero();
  double edge_ = 1; ///< of a box [m]
  Index3 n_boxes_{1, 1, 1};
  std::vector<std::int64_t> begins_;
  std::vector<std::int32_t> sorted_;
};

} // namespace maille::deform
