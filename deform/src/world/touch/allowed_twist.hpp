#pragma once
/// Which way a rigid tool may shift and turn at once without going into what it touches.

#include <Eigen/Core>

#include <array>
#include <cstddef>

namespace maille::deform {

/// Shortest step, and arc of a turn, of a tool on its way to the hand [cells]: shorter ones are rounding, and
/// longer ones leave the tool short of the hand.
inline constexpr double least_step_over_cell = 1e-7;
/// A shorter motion of a turning tool counts as none, and a middle this near to a face is at it [cells].
inline constexpr double unnoticed_over_cell = 1e-5;
/// Obstacles that a tool goes along in a tick; the rest of the way is gone in the next.
inline constexpr int most_obstacles = 8;

/// A shift, then a turn about the tool's middle as a vector times an arm, so that all six are lengths [m].
using Twist = Eigen::Matrix<double, 6, 1>;

/// Places of a tool that may not go against a normal further than a gap.
///
/// Source  the constrained god-object of Ortega, Redon and Coquillart 2007 (IEEE TVCG 13): Gauss' principle
///         of least constraint, here for steps in place of accelerations
class TwistConstraints {
public:
  static constexpr int most = 256;

  /// @param arm that turns are measured by [m]
  explicit TwistConstraints(double arm) : arm_(arm) {}

  /// @param point of the tool, from its middle [m] @param gap that may be gone against the normal [m]
  /// Without effect where there are `most` already.
  void add(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double gap);
  void clear() { n_ = 0; }

  /// The twist nearest to a wanted one that keeps all places off by a margin. That arcs bend towards their
  /// axes is counted in, to second order.
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
