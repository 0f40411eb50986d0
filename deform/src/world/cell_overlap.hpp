#pragma once
/// Whether cells of matter are in one another, where no corner of either need be in the other.

#include "maille/deform/world/rigid_world.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace maille::deform {

/// The convex hull of a cell's corners, which is the cell where it is a box.
///
/// Two hulls are apart where a direction keeps them apart: a normal of a face of one, or what is across an
/// edge of each. The least overlap along these is how deep they are in one another.
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
  mutable std::vector<Eigen::Vector3d> normals_, edges_; ///< of length 1, each once, from when they count
  Eigen::AlignedBox3d box_;
};

/// False where boxes about matter say that none is in the other by more than `depth` [m]: along any direction
/// it overlaps by that at least.
bool may_be_in_one_another(const Eigen::AlignedBox3d& one, const Eigen::AlignedBox3d& other, int dimension,
                           double depth);

/// Whether a cell of one list is in one of the other by more than `depth` [m].
bool are_in_one_another(const std::vector<ConvexCell>& one, const std::vector<ConvexCell>& other,
                        double depth);

/// The same of matter as it stands at the beginning. @param pose of a grid's first corner
bool is_matter_in(const Specimen& one, const Pose& pose, const Specimen& other, const Pose& other_pose,
                  double depth);

} // namespace maille::deform
