#pragma once
/// Between which depths rays may see something of a rigid object. Private to render.

#include "cast/cast_task.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille::render {

/// Numbers of a brick along the axes.
using Brick = std::array<std::uint16_t, 3>;

/// Bricks with something to see that have one beside them, or the volume's end, where there is nothing: whoever
/// enters or leaves what is seen passes one.
std::vector<Brick> border_bricks(const Volume& volume, const std::vector<std::uint8_t>& distances);

/// The nearest and farthest of such bricks in each small square of a picture. Rays begin and end there instead
/// of leaping through what is empty.
class BrickDepths {
public:
  static constexpr int edge = 4; ///< of a square [pixels]

  BrickDepths(const VoxelGrid& grid, const std::vector<Brick>& bricks, const Pose& pose, const View& view);

  /// Along the line of sight [m]; nearest above farthest: nothing is seen there. From 0 to far beyond
  /// everything where the eye is too near to tell.
  struct Range {
    float nearest, farthest;
  };
  const Range& at(int x, int y) const {
    return squares_[static_cast<std::size_t>(x / edge + squares_x_ * (y / edge))];
  }

private:
  void add(const Vec3& middle, const Vec3& half);

  int squares_x_, squares_y_;
  bool parallel_;
  double scale_, middle_x_, middle_y_;
  std::vector<Range> squares_;
};

} // namespace maille::render
