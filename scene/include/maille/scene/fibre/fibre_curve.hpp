#pragma once
/// Fibres that follow a line drawn by hand or traced in a picture.

#include "maille/scene/grid.hpp"

#include <span>
#include <vector>

namespace maille {

/// A polyline whose direction turns evenly: at its points the direction halves the angle between the two
/// pieces that meet there (at free ends it is the end piece's own), and along a piece it is the normalised
/// linear blend of those at its ends, so it is continuous along the line. A regular polygon on a circle has
/// the circle's directions, exactly, on the line itself; beside it they are off by no more than half of the
/// angle between two pieces. Two points make a constant direction. A line whose first and last point are the
/// same is closed.
class FibreCurve {
public:
  /// @param points [m]; at least two, no two successive ones the same, no piece that doubles back on the one
  ///        before
  explicit FibreCurve(std::span<const Vec3> points);

  /// Direction at the point of the line nearest to `position`; of equally near ones the first along the line.
  /// Unit length. O(points)
  Vec3 direction_at(const Vec3& position) const;

  /// True if the pieces that meet at the point between `before` and `after` point in opposite directions.
  static bool doubles_back(const Vec3& before, const Vec3& at, const Vec3& after);

private:
  std::vector<Vec3> points_, directions_; ///< directions at the points
};

} // namespace maille
