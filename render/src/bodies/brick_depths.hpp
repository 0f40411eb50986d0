#pragma once
/// Between which depths rays may see something of a rigid object. Private to render.

#include "cast/cast_task.hpp"

#include <cstdint>
#include <vector>

namespace maille::render {

/// What may be seen within a brick, from voxel to voxel, both inclusive.
struct SeenBox {
  Index3 low, high;
};

/// Boxes, one a brick, in one of which every ray is where it first sees something and where it last does: of
/// bricks in which not everything is seen, and those beside them and at the volume's end.
/// @param distances of bricks
/// Cost  O(bricks), and 64 cells of each in which not everything is seen
std::vector<SeenBox> seen_boxes(const Volume& volume, const TransferTable& table, const Look& look,
                                const std::vector<std::uint8_t>& distances, int threads);

/// The nearest and farthest of such boxes in each small square of a picture. Rays begin and end there instead
/// of leaping through what is empty.
class BrickDepths {
public:
  static constexpr int edge = 4; ///< of a square [pixels]

  BrickDepths(const VoxelGrid& grid, const std::vector<SeenBox>& boxes, const Pose& pose, const View& view,
              int threads);

  /// Along the line of sight [m]; nearest above farthest: nothing is seen there. From 0 to far beyond
  /// everything where the eye is too near to tell.
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
