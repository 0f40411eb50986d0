#pragma once
/// Cells of a world whose middles lie in an object's matter.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace maille::deform {

/// Upper bound of the speed of any point of a shape [cells in the time of the motion].
double largest_speed(const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                     const Vec3& cell_size);

/// True if matter at this rotation can contain a cell's middle without a voxel's middle in that cell: if a
/// rotated voxel is longer than a cell along any axis of the world. Otherwise the voxel's middle nearest to a
/// cell's middle lies in that cell.
bool has_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size);
/// The same for any rotation during a motion.
bool may_have_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation,
                                   const RigidMotion& motion, const Vec3& cell_size);

/// First and last cell along an axis whose middle lies in an interval from, or up to, this coordinate
/// [cells].
inline int first_middle(double from) {
  return static_cast<int>(std::ceil(from - 0.5 - 1e-9));
}
inline int last_middle(double to) {
  return static_cast<int>(std::floor(to - 0.5 + 1e-9));
}

/// True if any cell of a box is occupied or outside the world.
inline bool is_any_blocked(const OccupancyMap& map, const Index3& first, const Index3& last) {
  for (std::size_t a = 0; a < 3; ++a)
    if (first[a] > last[a])
      return false;
  return !map.has_cell(first) || !map.has_cell(last) || map.is_any_occupied(first, last);
}

/// A shape at a pose as a set of boxes: each voxel without its upper faces, so that a point is in at most one
/// of them.
class PosedMatter {
public:
  PosedMatter(const RigidShape& shape, const Pose& pose, const Vec3& cell_size);

  const RigidShape& shape() const { return *shape_; }
  /// Calls visit(cell) for the cells whose middles lie in a voxel's box, until it returns true.
  /// @return whether it did
  /// @param map null, or a map: boxes without blocked cells near them are skipped
  template<class Visit>
  bool any_middle(std::int32_t voxel, const OccupancyMap* map, Visit&& visit) const;
  /// True if a voxel contains the middle of a cell.
  bool holds(std::int32_t voxel, const Index3& cell) const;
  /// Middle of a cell in the lattice, in voxels.
  Eigen::Vector3d in_lattice(const Index3& cell) const;
  /// Middle of a voxel, in cells.
  Eigen::Vector3d middle(std::int32_t voxel) const;
  /// Half the extent of a voxel along each axis of the world [cells].
  const Eigen::Vector3d& reach() const { return reach_; }

private:
  const RigidShape* shape_;
  Eigen::Matrix3d to_lattice_, from_lattice_; ///< for differences: cells to voxels, and back
  Eigen::Vector3d origin_;                    ///< of the lattice [cells]
  Eigen::Vector3d reach_;
};

template<class Visit>
bool PosedMatter::any_middle(std::int32_t voxel, const OccupancyMap* map, Visit&& visit) const {
  const Eigen::Vector3d at = middle(voxel);
  Index3 first, last;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    first[a] = first_middle(at[i] - reach_[i]);
    last[a] = last_middle(at[i] + reach_[i]);
  }
  if (map != nullptr && !is_any_blocked(*map, first, last))
    return false;
  Index3 cell;
  for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2])
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1])
      for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0])
        if (holds(voxel, cell) && visit(cell))
          return true;
  return false;
}

/// True if any voxel contains the middle of a blocked cell.
bool holds_blocked_cell(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                        const Pose& pose);

/// First time, up to `end`, at which the matter of a moving shape contains the middle of a blocked cell.
///
/// The path is divided into steps of at most a quarter of a cell. Each step is tested at its end; bisection
/// finds the contact in the first blocked step. A voxel that may have cells between middles is longer than
/// half a cell, so no cell is missed.
/// @pre the map does not contain the shape; at the start no voxel contains such a middle
/// Cost  for each step, a test of every block, and of every open voxel of blocks near blocked cells
std::optional<Contact> first_held_cell(const OccupancyMap& map, const Vec3& cell_size,
                                       const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                                       double end);

/// A blocked cell, and a voxel that contains its middle, or nearly.
struct HeldCell {
  std::int32_t voxel = 0;
  Index3 cell{};
  int axis = 0, direction = 1; ///< of the world, from the voxel's nearest open face towards the cell
  double time = 0;             ///< of a motion, 0 to 1
};
/// All blocked cells whose middles open voxels reach on the way, without obstacles, tested every quarter of a
/// cell. Includes the shape's own cells if the map has them.
std::vector<HeldCell> held_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      const Pose& pose, const RigidMotion& motion);
/// All occupied cells with middles in the boxes of open voxels, enlarged by `reach` [cells], in the order of
/// the voxels.
std::vector<HeldCell> held_nearly(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                  const Pose& pose, double reach);

/// Calls visit(cell, voxel) for cells that belong to the matter without a voxel's middle in them: those whose
/// middles it contains, then those that seal matter thinner than a cell. Cells may be visited several times.
///
/// Matter at least a cell thick is not permeable through faces of cells (a digital plane of the largest
/// component of its normal has no 6-tunnel: Andres and others 1997). Thinner matter is sealed if every point
/// of it lies within half a cell, along each axis, of a point whose cell is occupied: a path from middle to
/// middle would cross the matter within one of these cells.
template<class Visit>
void for_each_cell_between(const PosedMatter& matter, const Pose& pose, const Vec3& cell_size, Visit&& visit);

/// Number of parts of a voxel along each axis for sealing; 1 if matter is as thick as a cell.
Index3 sealing_parts(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size);

template<class Visit>
void for_each_cell_between(const PosedMatter& matter, const Pose& pose, const Vec3& cell_size,
                           Visit&& visit) {
  const RigidShape& shape = matter.shape();
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
    matter.any_middle(voxel, nullptr, [&](const Index3& cell) {
      visit(cell, voxel);
      return false;
    });
  const Index3 parts = sealing_parts(shape.spacing(), pose.rotation, cell_size);
  if (parts == Index3{1, 1, 1})
    return;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel) {
    const Index3 at = shape.index_of(voxel);
    for (int k = 0; k < parts[2]; ++k)
      for (int j = 0; j < parts[1]; ++j)
        for (int i = 0; i < parts[0]; ++i) {
          const Index3 part{i, j, k};
          Eigen::Vector3d within;
          for (std::size_t a = 0; a < 3; ++a)
            within[static_cast<Eigen::Index>(a)] = (at[a] + (part[a] + 0.5) / parts[a]) * shape.spacing()[a];
          const Eigen::Vector3d x = pose.position + pose.rotation * within;
          Index3 cell;
          for (std::size_t a = 0; a < 3; ++a)
            cell[a] = static_cast<int>(std::floor(x[static_cast<Eigen::Index>(a)] / cell_size[a]));
          visit(cell, voxel);
        }
  }
}

} // namespace maille::deform
