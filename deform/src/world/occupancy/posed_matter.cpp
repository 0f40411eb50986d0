#include "world/occupancy/posed_matter.hpp"
#include "lattice/tolerances.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <Eigen/Geometry>

#include <algorithm>

namespace maille::deform {

namespace {

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

/// Extent of a voxel along each axis of the world [cells].
Eigen::Vector3d extent(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size) {
  return (rotation.cwiseAbs() * vector(spacing)).cwiseQuotient(vector(cell_size));
}

/// Number of steps in which no point moves further than the step length.
double steps_of(const RigidShape& shape, const Pose& pose, const RigidMotion& motion, const Vec3& cell_size,
                double end) {
  return std::clamp(std::ceil(largest_speed(shape, pose, motion, cell_size) * end / step_over_cell), 1.0,
                    furthest_cell);
}

bool is_taken(const OccupancyMap& map, const Index3& cell) {
  return map.has_cell(cell) && map.is_occupied(cell);
}

/// True if the bounding box of a block of voxels contains no blocked cell's middle.
bool is_clear(const OccupancyMap& map, const Vec3& cell_size, const RigidShape::Block& block,
              const Vec3& spacing, const Pose& pose) {
  Eigen::Vector3d size, low;
  for (std::size_t a = 0; a < 3; ++a) {
    low[static_cast<Eigen::Index>(a)] = block.low[a] * spacing[a];
    size[static_cast<Eigen::Index>(a)] = block.size[a] * spacing[a];
  }
  const Eigen::Vector3d at = pose.position + pose.rotation * (low + 0.5 * size),
                        reach = 0.5 * pose.rotation.cwiseAbs() * size;
  Index3 first, last;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    first[a] = first_middle(std::clamp((at[i] - reach[i]) / cell_size[a], -furthest_cell, furthest_cell));
    last[a] = last_middle(std::clamp((at[i] + reach[i]) / cell_size[a], -furthest_cell, furthest_cell));
  }
  return !is_any_blocked(map, first, last);
}

/// Open voxels that contain a blocked cell's middle, with one such cell each.
std::vector<std::pair<std::int32_t, Index3>> held_by_open_voxels(const OccupancyMap& map,
                                                                 const Vec3& cell_size,
                                                                 const RigidShape& shape, const Pose& pose) {
  std::vector<std::pair<std::int32_t, Index3>> held;
  const PosedMatter matter(shape, pose, cell_size);
  for (const RigidShape::Block& block : shape.blocks()) {
    if (is_clear(map, cell_size, block, shape.spacing(), pose))
      continue;
    for (std::int32_t voxel = block.first; voxel < block.end; ++voxel)
      if (shape.open_sides(voxel) != 0)
        matter.any_middle(voxel, &map, [&](const Index3& cell) {
          if (!map.is_blocked(cell))
            return false;
          held.emplace_back(voxel, cell);
          return true;
        });
  }
  return held;
}

/// Sets the face of the cell through which matter reached its middle: the axis of largest velocity against
/// the face of the voxel that the middle entered through.
void set_face(HeldCell& held, const PosedMatter& matter, const Pose& pose, const RigidMotion* motion) {
  const Index3 index = matter.shape().index_of(held.voxel);
  const Eigen::Vector3d in = matter.in_lattice(held.cell);
  double least = 2;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX(); // outward normal of the box
  const std::uint8_t open = matter.shape().open_sides(held.voxel);
  for (int a = 0; a < 3; ++a)
    for (const int side : {0, 1}) {
      const double depth = std::abs(in[a] - index[a] - side);
      if ((open >> (2 * a + side) & 1) == 0 || depth >= least)
        continue;
      least = depth;
      normal = (side == 0 ? -1 : 1) * pose.rotation.col(a);
    }
  Eigen::Vector3d weight = normal.cwiseAbs();
  if (motion != nullptr) {
    const Eigen::Vector3d at =
        pose.position + pose.rotation * in.cwiseProduct(vector(matter.shape().spacing()));
    const Eigen::Vector3d velocity = motion->by + motion->angle * motion->axis.cross(at - motion->about);
    const Eigen::Vector3d against = normal.cwiseProduct(velocity);
    if (against.maxCoeff() > 0)
      weight = against;
  }
  Eigen::Index axis = 0;
  weight.maxCoeff(&axis);
  held.axis = static_cast<int>(axis);
  held.direction = normal[axis] < 0 ? -1 : 1;
}

} // namespace

double largest_speed(const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                     const Vec3& cell_size) {
  return (motion.by.norm() + std::abs(motion.angle) * furthest_corner(shape, pose, motion.about)) /
         *std::ranges::min_element(cell_size);
}

bool has_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size) {
  return extent(spacing, rotation, cell_size).maxCoeff() > 1 + rounding;
}

bool may_have_cells_between_voxels(const Vec3& spacing, const Eigen::Matrix3d& rotation,
                                   const RigidMotion& motion, const Vec3& cell_size) {
  return has_cells_between_voxels(spacing, rotation, cell_size) ||
         (motion.angle != 0 && vector(spacing).norm() > *std::ranges::min_element(cell_size));
}

PosedMatter::PosedMatter(const RigidShape& shape, const Pose& pose, const Vec3& cell_size) : shape_(&shape) {
  const Eigen::Vector3d h = vector(cell_size), s = vector(shape.spacing());
  to_lattice_ = s.cwiseInverse().asDiagonal() * pose.rotation.transpose() * h.asDiagonal();
  from_lattice_ = h.cwiseInverse().asDiagonal() * pose.rotation * s.asDiagonal();
  origin_ = pose.position.cwiseQuotient(h).cwiseMax(-1e8).cwiseMin(1e8); // cell coordinates fit in int
  reach_ = 0.5 * from_lattice_.cwiseAbs().rowwise().sum();
}

Eigen::Vector3d PosedMatter::in_lattice(const Index3& cell) const {
  return to_lattice_ * (Eigen::Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5) - origin_);
}

Eigen::Vector3d PosedMatter::middle(std::int32_t voxel) const {
  const Index3 i = shape_->index_of(voxel);
  return origin_ + from_lattice_ * Eigen::Vector3d(i[0] + 0.5, i[1] + 0.5, i[2] + 0.5);
}

bool PosedMatter::holds(std::int32_t voxel, const Index3& cell) const {
  const Index3 i = shape_->index_of(voxel);
  const Eigen::Vector3d in = in_lattice(cell);
  return std::floor(in[0]) == i[0] && std::floor(in[1]) == i[1] && std::floor(in[2]) == i[2];
}

bool holds_blocked_cell(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                        const Pose& pose) {
  const PosedMatter matter(shape, pose, cell_size);
  for (const RigidShape::Block& block : shape.blocks()) {
    if (is_clear(map, cell_size, block, shape.spacing(), pose))
      continue;
    for (std::int32_t voxel = block.first; voxel < block.end; ++voxel)
      if (matter.any_middle(voxel, &map, [&](const Index3& cell) { return map.is_blocked(cell); }))
        return true;
  }
  return false;
}

std::optional<Contact> first_held_cell(const OccupancyMap& map, const Vec3& cell_size,
                                       const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                                       double end) {
  const double steps = steps_of(shape, pose, motion, cell_size, end);
  for (double step = 1; step <= steps; ++step) {
    double blocked = end * (step / steps), free = end * ((step - 1) / steps);
    auto held = held_by_open_voxels(map, cell_size, shape, motion.moved(pose, blocked));
    if (held.empty())
      continue;
    Contact contact;
    for (;;) {
      HeldCell first{.voxel = held.front().first, .cell = held.front().second};
      const Pose there = motion.moved(pose, blocked);
      set_face(first, PosedMatter(shape, there, cell_size), there, &motion);
      contact = {blocked,    first.voxel,     first.cell,
                 first.axis, first.direction, map.has_cell(first.cell) ? map.occupant(first.cell) : no_voxel};
      const double middle = 0.5 * (free + blocked);
      if (middle <= free || middle >= blocked)
        return contact;
      // Voxels that pass a middle within the step and have left it at its end only grazed it.
      const PosedMatter matter(shape, motion.moved(pose, middle), cell_size);
      decltype(held) still;
      for (const auto& [voxel, known] : held)
        matter.any_middle(voxel, &map, [&](const Index3& cell) {
          if (!map.is_blocked(cell))
            return false;
          still.emplace_back(voxel, cell);
          return true;
        });
      if (still.empty()) {
        free = middle;
      } else {
        blocked = middle;
        held = std::move(still);
      }
    }
  }
  return std::nullopt;
}

std::vector<HeldCell> held_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      const Pose& pose, const RigidMotion& motion) {
  std::vector<HeldCell> list;
  const double steps = steps_of(shape, pose, motion, cell_size, 1);
  for (double step = 1; step <= steps; ++step) {
    const Pose there = motion.moved(pose, step / steps);
    const PosedMatter matter(shape, there, cell_size);
    for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
      if (shape.open_sides(voxel) != 0)
        matter.any_middle(voxel, &map, [&](const Index3& cell) {
          if (map.is_blocked(cell)) {
            HeldCell& held = list.emplace_back(HeldCell{.voxel = voxel, .cell = cell, .time = step / steps});
            set_face(held, matter, there, &motion);
          }
          return false;
        });
  }
  return list;
}

std::vector<HeldCell> held_nearly(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                  const Pose& pose, double reach) {
  std::vector<HeldCell> list;
  const PosedMatter matter(shape, pose, cell_size);
  const Eigen::Vector3d within =
      (reach * vector(cell_size).minCoeff() * vector(shape.spacing()).cwiseInverse()).array() + 0.5;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel) {
    if (shape.open_sides(voxel) == 0)
      continue;
    const Index3 index = shape.index_of(voxel);
    const Eigen::Vector3d at = matter.middle(voxel);
    Index3 first, last, cell;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      first[a] = static_cast<int>(std::ceil(at[i] - matter.reach()[i] - 0.5 - 2 * reach));
      last[a] = static_cast<int>(std::floor(at[i] + matter.reach()[i] - 0.5 + 2 * reach));
    }
    if (!map.is_any_occupied(first, last))
      continue;
    for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2])
      for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1])
        for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0]) {
          if (!is_taken(map, cell))
            continue;
          Eigen::Vector3d off = matter.in_lattice(cell);
          for (int a = 0; a < 3; ++a)
            off[a] -= index[a] + 0.5;
          if ((off.cwiseAbs().array() > within.array()).any())
            continue;
          set_face(list.emplace_back(HeldCell{.voxel = voxel, .cell = cell}), matter, pose, nullptr);
        }
  }
  return list;
}

Index3 sealing_parts(const Vec3& spacing, const Eigen::Matrix3d& rotation, const Vec3& cell_size) {
  Index3 parts{1, 1, 1};
  if (*std::ranges::min_element(spacing) >= *std::ranges::max_element(cell_size) * (1 - rounding))
    return parts;
  // The boxes of parts extend at most half a cell from their middles along every axis of the world.
  parts.fill(
      std::max(1, static_cast<int>(std::ceil(extent(spacing, rotation, cell_size).maxCoeff() - rounding))));
  return parts;
}

} // namespace maille::deform
