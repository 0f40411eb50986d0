#include "maille/deform/world/rigid_shape.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille::deform {

namespace {

constexpr Index3 block_size{16, 4, 4}; ///< as long as a brick of the map is along x

/// Matter at places that may lie outside the lattice.
class Matter {
public:
  Matter(const Index3& size, std::span<const std::uint8_t> values) : size_(size), values_(values) {}
  bool operator()(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size_[0] && y < size_[1] && z < size_[2] &&
           values_[x + size_[0] * (y + std::int64_t{1} * size_[1] * z)] != 0;
  }

private:
  Index3 size_;
  std::span<const std::uint8_t> values_;
};

std::uint8_t open_sides_of(const Matter& is_matter, int x, int y, int z) {
  const std::array<bool, 6> closed{is_matter(x - 1, y, z), is_matter(x + 1, y, z), is_matter(x, y - 1, z),
                                   is_matter(x, y + 1, z), is_matter(x, y, z - 1), is_matter(x, y, z + 1)};
  unsigned open = 0;
  for (std::size_t side = 0; side < 6; ++side)
    open |= closed[side] ? 0u : 1u << side;
  return static_cast<std::uint8_t>(open);
}

/// A ball about the centres of the voxels that touch the corners of a box of indices.
RigidShape::Block ball_about(const Index3& low, const Index3& high, const Vec3& spacing, std::int32_t first,
                             std::int32_t end) {
  RigidShape::Block block{first, end, {}, 0, low, {}, 0, 0};
  for (std::size_t a = 0; a < 3; ++a) {
    block.size[a] = high[a] - low[a] + 1;
    block.centre[a] = (0.5 * (low[a] + high[a]) + 0.5) * spacing[a];
    block.radius = std::hypot(block.radius, 0.5 * (high[a] - low[a]) * spacing[a]);
  }
  return block;
}

} // namespace

RigidShape::RigidShape(const Index3& size, const Vec3& spacing, std::span<const std::uint8_t> matter)
    : size_(size), spacing_(spacing) {
  for (std::size_t a = 0; a < 3; ++a)
    if (size[a] < 1 || size[a] > std::numeric_limits<std::int16_t>::max() || !(spacing[a] > 0))
      throw std::invalid_argument("RigidShape: 1 to 32767 voxels along every axis, and spacings above 0");
  if (matter.size() != static_cast<std::size_t>(std::int64_t{1} * size[0] * size[1] * size[2]))
    throw std::invalid_argument("RigidShape: a value for every place of the lattice");
  // Block by block, so that voxels that are close in space are close in every array.
  for (int z = 0; z < size[2]; z += block_size[2])
    for (int y = 0; y < size[1]; y += block_size[1])
      for (int x = 0; x < size[0]; x += block_size[0])
        add_block({x, y, z}, matter);
  if (n_voxels() == 0)
    throw std::invalid_argument("RigidShape: no voxel");
}

void RigidShape::add_block(const Index3& begin, std::span<const std::uint8_t> matter) {
  const Matter is_matter(size_, matter);
  const std::int32_t first = n_voxels(), first_row = static_cast<std::int32_t>(rows_.size());
  Index3 low = size_, high{-1, -1, -1};
  for (int z = begin[2]; z < std::min(begin[2] + block_size[2], size_[2]); ++z)
    for (int y = begin[1]; y < std::min(begin[1] + block_size[1], size_[1]); ++y)
      for (int x = begin[0]; x < std::min(begin[0] + block_size[0], size_[0]); ++x) {
        if (!is_matter(x, y, z))
          continue;
        const Index3 at{x, y, z};
        const bool follows =
            !rows_.empty() && rows_.back().voxel >= first && x > begin[0] && is_matter(x - 1, y, z);
        if (follows)
          ++rows_.back().n;
        else
          rows_.push_back(
              {{static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(z)},
               1,
               n_voxels()});
        open_.push_back(open_sides_of(is_matter, x, y, z));
        for (std::size_t a = 0; a < 3; ++a) {
          index_[a].push_back(static_cast<std::int16_t>(at[a]));
          low[a] = std::min(low[a], at[a]);
          high[a] = std::max(high[a], at[a]);
        }
      }
  if (n_voxels() == first)
    return;
  blocks_.push_back(ball_about(low, high, spacing_, first, n_voxels()));
  blocks_.back().first_row = first_row;
  blocks_.back().end_row = static_cast<std::int32_t>(rows_.size());
}

Index3 RigidShape::index_of(std::int32_t voxel) const {
  const auto v = static_cast<std::size_t>(voxel);
  return {index_[0][v], index_[1][v], index_[2][v]};
}

Eigen::Vector3d RigidShape::middle() const {
  return {0.5 * size_[0] * spacing_[0], 0.5 * size_[1] * spacing_[1], 0.5 * size_[2] * spacing_[2]};
}

double furthest_corner(const RigidShape& shape, const Pose& pose, const Eigen::Vector3d& from) {
  double furthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d rest;
    for (int a = 0; a < 3; ++a)
      rest[a] = (corner >> a & 1) * shape.size()[a] * shape.spacing()[a];
    furthest = std::max(furthest, (pose.position + pose.rotation * rest - from).norm());
  }
  return furthest;
}

Eigen::Vector3d RigidShape::centre_of(std::int32_t voxel) const {
  const Index3 i = index_of(voxel);
  return {(i[0] + 0.5) * spacing_[0], (i[1] + 0.5) * spacing_[1], (i[2] + 0.5) * spacing_[2]};
}

std::int64_t RigidShape::bytes() const {
  std::size_t sum = rows_.capacity() * sizeof(Row) + blocks_.capacity() * sizeof(Block) + open_.capacity();
  for (const auto& index : index_)
    sum += index.capacity() * sizeof(std::int16_t);
  return static_cast<std::int64_t>(sum);
}

Pose RigidMotion::moved(const Pose& from, double t) const {
  if (t == 0)
    return from;
  Pose to = from;
  if (angle != 0) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(t * angle, axis).toRotationMatrix();
    // Orthonormalised, so that the object keeps its shape after any number of motions.
    to.rotation = Eigen::Quaterniond(turn * from.rotation).normalized().toRotationMatrix();
    to.position = about + turn * (from.position - about);
  }
  to.position += t * by;
  return to;
}

} // namespace maille::deform
