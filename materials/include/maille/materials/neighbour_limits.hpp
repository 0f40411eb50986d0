#pragma once
/// How far the neighbours of one material may part, close up and shear, along each axis.

#include "maille/materials/elasticity.hpp"

#include <array>

namespace maille {

/// Limits of links along the axes 1, 2, 3 of whatever frame the holder states, as ratios of the link's
/// rest length. Valid: 0 <= compress <= 1 <= stretch, shear >= 0.
struct NeighbourLimits {
  std::array<double, 3> stretch{1, 1, 1};  ///< largest distance / rest, per link axis
  std::array<double, 3> compress{1, 1, 1}; ///< smallest distance / rest, per link axis
  std::array<std::array<double, 3>, 3>
      shear{}; ///< largest shear / rest, [link axis][component]; diagonal unused

  friend bool operator==(const NeighbourLimits&, const NeighbourLimits&) = default;
};

/// Limits of a material along its own axes, seen along the axes of the object (R = `axes`, columns = material
/// axes). This is our convention, not a law: limits of a turned material are not boxes in the object's frame.
/// Along an axis the slacks are averaged, slack_a = sum_i R_ai^2 slack_i, for stretch and for compression. In
/// shear, shear_ab = sum_{i != j} R_ai^2 R_bj^2 shear_ij / sum_{i != j} R_ai^2 R_bj^2 for a != b. Exact for
/// quarter turns, which permute the limits; equal limits stay equal under any turn.
NeighbourLimits turned(const NeighbourLimits& limits, const Eigen::Matrix3d& axes);

/// How much a link gives way per pascal: 1 / E_a along its axis, 1 / G_ab in shear [1/Pa]. `taut` limits are
/// in proportion to it: a chain whose links are all taut is the elastic bar.
struct LinkCompliance {
  std::array<double, 3> axial{};
  std::array<std::array<double, 3>, 3> shear{}; ///< symmetric, diagonal unused
};

/// Uniaxial and shear compliances of a reduced stiffness (see reduced_stiffness) along the scene's axes;
/// entries of axes that the scene has not stay 0.
LinkCompliance link_compliance(const Eigen::MatrixXd& reduced_stiffness);

} // namespace maille
