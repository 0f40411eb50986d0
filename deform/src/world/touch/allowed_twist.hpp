#pragma once
/// Admissible shift and rotation of a rigid tool in contact.

#include <Eigen/Core>

#include <array>
#include <cstddef>

namespace maille::deform {

/// Shortest step, and arc of a rotation, of a tool on its way to the goal [cells]: shorter ones are rounding;
/// a larger bound leaves the tool short of the goal.
inline constexpr double least_step_over_cell = 1e-7;
/// Motions of a rotating tool below this count as none, and a middle this near to a face is on it [cells].
inline constexpr double unnoticed_over_cell = 1e-5;
/// Largest number of obstacles that a tool slides along in a tick; the rest of the way follows in the next.
inline constexpr int most_obstacles = 8;

/// A shift, then a rotation vector about the tool's middle times an arm: all six are lengths [m].
using Twist = Eigen::Matrix<double, 6, 1>;

/// Contact constraints of a tool: points that may move against a normal by at most a gap.
///
/// Source  constrained god-object of Ortega, Redon and Coquillart 2007 (IEEE TVCG 13): Gauss' principle of
///         least constraint, here for steps instead of accelerations
class TwistConstraints {
public:
  static constexpr int most = 256;

  /// @param arm unit of length for rotations [m]
  explicit TwistConstraints(double arm) : arm_(arm) {}

  /// @param point of the tool, from its middle [m] @param gap admissible motion against the normal [m]
  /// No effect if there are already `most`.
  void add(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double gap);
  void clear() { n_ = 0; }

  /// The twist nearest to a requested one that keeps all points off by a margin. The curvature of arcs is
  /// included to second order.
  Twist allowed(const Twist& wanted, double margin) const;

private:
  using Least = std::array<double, most>;

  Twist nearest(const Twist& wanted, const Least& least) const;

  double arm_;
  std::array<Twist, most> rows_;
  std::array<Eigen::Vector3d, most> normals_, points_;
  std::array<double, most> gaps_;
  std::size_t n_ = 0;
};

} // namespace maille::deform
