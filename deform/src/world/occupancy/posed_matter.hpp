#pragma once
/// The cells of a world whose middles lie in an object's matter.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace maille::deform {

/// How fast any point of a shape goes at most [cells in the time of the motion].
double largest_speed(const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                     const Vec3& cell_size);

/// Whether matter at this turn has cells that no voxel's middle lies in: where a voxel, as it stands, is
/// longer than a cell along any axis of the world. Else the nearest voxel's middle to a cell's middle lies in
/// that cell.
bool has_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size);
/// The same for some turn of a motion.
bool may_have_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation,
                                   const RigidMotion& motion, const Vec3& cell_size);

/// The first and the last cell along an axis whose middle is in an interval from there, or to there [cells].
inline int first_middle(double from) {
  return static_cast<int>(std::ceil(from - 0.5 - 1e-9));
}
inline int last_middle(double to) {
  return static_cast<int>(std::floor(to - 0.5 + 1e-9));
}

/// Whether any cell of a box is taken, or outside the world.
inline bool is_any_blocked(const OccupancyMap& map, const Index3& first, const Index3& last) {
  for (std::size_t a = 0; a < 3; ++a)
    if (first[a] > last[a])
      return false;
  return !map.has_cell(first) || !map.has_cell(last) || map.is_any_occupied(first, last);
}

/// A shape at a pose as matter: its voxels are boxes, each without its upper faces, so that a point is in one
/// of them at most.
class PosedMatter {
public:
  PosedMatter(const RigidShape& shape, const Pose& pose, const Vec3& cell_size);

  const RigidShape& shape() const { return *shape_; }
  /// Calls visit(cell) for the cells whose middles a voxel's box holds, until it returns true.
  /// @return whether it did
  /// @param map null, or where to look first: boxes about which nothing is taken are passed over
  template<class Visit>
  bool any_middle(std::int32_t voxel, const OccupancyMap* map, Visit&& visit) const;
  /// Whether a voxel holds the middle of a cell.
  bool holds(std::int32_t voxel, const Index3& cell) const;
  /// Where the middle of a cell is in the lattice, in voxels.
  Eigen::Vector3d in_lattice(const Index3& cell) const;
  /// Middle of a voxel, in cells.
  Eigen::Vector3d middle(std::int32_t voxel) const;
  /// Half the extent of a voxel along each axis of the world [cells].
  const Eigen::Vector3d& reach() const { return reach_; }

private:
  const RigidShape* shape_;
  Eigen::Matrix3d to_lattice_, from_lattice_; ///< of differences: cells to voxels, and back
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

/// Whether any voxel holds the middle of a cell that is taken or outside the world.
bool holds_blocked_cell(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                        const Pose& pose);

/// When the matter of a moving shape first comes over the middle of a cell that is taken or outside the
/// world, up to time `end`.
///
/// The way is cut into steps of at most a quarter of a cell, each looked at where it ends, and the contact is
/// found by bisection in the first step that ends blocked. A voxel that may have cells between middles is
/// longer than half a cell, so none is stepped over.
/// @pre the map does not hold the shape; at the beginning no voxel holds such a middle
/// Cost  for each step, a look at every block, and at every open voxel of blocks near something
std::optional<Contact> first_held_cell(const OccupancyMap& map, const Vec3& cell_size,
                                       const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                                       double end);

/// A cell that is taken, or outside the world, and a voxel that holds its middle, or nearly.
struct HeldCell {
  std::int32_t voxel = 0;
  Index3 cell{};
  int axis = 0, direction = 1; ///< of the world, in which the voxel's nearest open face is against the cell
  double time = 0;             ///< of a motion, 0 to 1
};
/// All that open voxels come over on the way, as if nothing were in the way, looked at from quarter to
/// quarter of a cell. The shape's own cells, where the map has them, are among them.
std::vector<HeldCell> held_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      const Pose& pose, const RigidMotion& motion);
/// All taken cells that open voxels hold within their boxes with `reach` [cells] about them, in the order of
/// the voxels.
std::vector<HeldCell> held_nearly(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                  const Pose& pose, double reach);

/// Calls visit(cell, voxel) for cells that belong to the matter though no voxel's middle lies in them: those
/// whose middles it holds, then those that seal matter thinner than a cell. Cells may come several times.
///
/// Between matter of at least a cell's thickness no way leads from cell to cell through faces (a digital
/// plane of the largest component of its normal has no 6-tunnel: Andres and others 1997). Thinner matter is
/// sealed where every point of it lies within half a cell, along each axis, of a point whose cell is taken:
/// then a way from middle to middle would cross it within one of these cells.
template<class Visit>
void for_each_cell_between(const PosedMatter& matter, const Pose& pose, const Vec3& cell_size, Visit&& visit);

/// Into how many parts a voxel is cut along each axis for that; 1 where matter is as thick as a cell.
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
