#pragma once
/// Range of depths in which rays may meet something visible of a rigid object. Private to render.

#include "cast/cast_task.hpp"

#include <cstdint>
#include <vector>

namespace maille::render {

/// Visible part of a brick, from voxel to voxel, both inclusive.
struct SeenBox {
  Index3 low, high;
};

/// Boxes, at most one per brick, that contain the first and the last visible point of every ray: those of
/// partly visible bricks, and of full ones beside them or at the end of the volume.
/// @param distances of bricks, see brick_distances
/// Cost  O(bricks), and 64 cells of each partly visible one
std::vector<SeenBox> seen_boxes(const Volume& volume, const TransferTable& table, const Look& look,
                                const std::vector<std::uint8_t>& distances, int threads);

/// Depth range of such boxes in each small square of a picture. Rays start and end there and need not skip
/// empty space.
class BrickDepths {
public:
  static constexpr int edge = 4; ///< of a square [pixels]

  BrickDepths(const VoxelGrid& grid, const std::vector<SeenBox>& boxes, const Pose& pose, const View& view,
              int threads);

  /// Along the line of sight [m]; empty if nearest > farthest. 0 to a very large depth if the eye is too
  /// near.
  struct Range {
    float nearest, farthest;
  };
  const Range& at(int x, int y) const { return squares_[x / edge + squares_x_ * (y / edge)]; }

private:
  void add(const Vec3& middle, const Vec3& half, std::vector<Range>& squares) const;

  int squares_x_, squares_y_;
  bool parallel_;
  double scale_, middle_x_, middle_y_;
  std::vector<Range> squares_;
};

} // namespace maille::render
