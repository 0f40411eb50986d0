#pragma once
/// Overlap tests for cells of matter, also without a corner of either inside the other.

#include "maille/deform/world/rigid_world.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace maille::deform {

/// The convex hull of a cell's corners; equal to the cell if it is a box.
///
/// Two hulls are disjoint if a direction separates them: a face normal of one, or the cross product of an
/// edge of each. The penetration depth is the smallest overlap along these directions.
///
/// Source  Gottschalk, Lin and Manocha 1996 (SIGGRAPH), the theorem of separating axes
class ConvexCell {
public:
  /// @param corners in the order of a grid, x fastest; 4 in two dimensions, 2 in one
  explicit ConvexCell(std::vector<Eigen::Vector3d> corners);
  const Eigen::AlignedBox3d& box() const { return box_; }
  bool is_deeper_in(const ConvexCell& other, double depth) const;

private:
  bool overlaps_along(const ConvexCell& other, const Eigen::Vector3d& axis, double depth) const;
  void find_directions() const;
  std::vector<Eigen::Vector3d> corners_;
  mutable std::vector<Eigen::Vector3d> normals_, edges_; ///< unit vectors, each once, made on first use
  Eigen::AlignedBox3d box_;
};

/// False if bounding boxes exclude an overlap deeper than `depth` [m]: such an overlap is at least as long
/// along every direction.
bool may_be_in_one_another(const Eigen::AlignedBox3d& one, const Eigen::AlignedBox3d& other, int dimension,
                           double depth);

/// True if a cell of one list overlaps one of the other by more than `depth` [m].
bool are_in_one_another(const std::vector<ConvexCell>& one, const std::vector<ConvexCell>& other,
                        double depth);

/// The same for objects at rest. @param pose of a grid's first corner
bool is_matter_in(const Specimen& one, const Pose& pose, const Specimen& other, const Pose& other_pose,
                  double depth);

} // namespace maille::deform
