#pragma once
/// Traversal of the cells that a moving point passes through.

#include "maille/deform/world/rigid_shape.hpp"

#include <array>
#include <optional>

namespace maille::deform {

/// One coordinate of a point of a rigid motion [cells]: offset + slope t + cosine cos(angle t) + sine
/// sin(angle t), t from 0 to 1.
struct CoordinatePath {
  double offset = 0, slope = 0, cosine = 0, sine = 0;
  double at(double t, double angle) const;
  double rate(double t, double angle) const;
};

/// Walks from cell to cell through faces, in the order of time, without omissions at any speed of the point:
/// a motion passes through no obstacle that its points cannot pass. If several faces are reached at once (an
/// edge, a corner), the lowest axis is first, so that cells that touch only at edges also form a wall.
///
/// Crossings of a straight path are divisions (Amanatides and Woo 1987, but with times from the plane's
/// number instead of sums, so that errors do not accumulate). A coordinate under rotation is divided where
/// its rate changes sign; bisection finds the crossing in each monotone piece to the last bit.
class CellWalk {
public:
  /// @param start the cell of the point at t = 0; its coordinates may lie outside by rounding
  CellWalk(const std::array<CoordinatePath, 3>& paths, double angle, const Index3& start);
  /// Along a straight line. @param from, by  [cells]
  CellWalk(const Eigen::Vector3d& from, const Eigen::Vector3d& by, const Index3& start)
      : CellWalk({{{from[0], by[0], 0, 0}, {from[1], by[1], 0, 0}, {from[2], by[2], 0, 0}}}, 0, start) {}

  struct Step {
    double time;
    int axis;
    int direction; ///< -1 or 1
  };
  /// Advances to the next cell that is entered before `end`. @return nothing at the end
  std::optional<Step> next(double end);
  const Index3& cell() const { return cell_; }

private:
  struct Crossing {
    double time; ///< 2: no crossing
    int direction;
  };
  Crossing find_crossing(std::size_t axis) const;
  Crossing find_straight_crossing(std::size_t axis) const;
  Crossing crossing_in_piece(std::size_t axis, double begin, double end) const;

  std::array<CoordinatePath, 3> paths_;
  double angle_;
  double time_ = 0;
  Index3 cell_;
  std::array<Crossing, 3> next_;
};

} // namespace maille::deform
