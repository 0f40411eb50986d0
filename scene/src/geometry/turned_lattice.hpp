#pragma once
/// Cells and nodes of a lattice turned against that of a scene.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

namespace maille::reader {

/// From the lattice of a scene to a turned one over the same matter.
class TurnedLattice {
public:
  /// What rounding makes of 0 in a turn, and of equal distances in spacings.
  static constexpr double rounding = 1e-9;

  /// @param scene outlives it; @param fibre  unit vector that the turned x axis follows
  TurnedLattice(const Scene& scene, const Vec3& fibre);

  /// The turned grid, large enough for the scene's. @param origin of its node 0, turned frame [m]
  Grid grid(Vec3& origin) const;
  /// The scene's body on the turned lattice: grid, origin, matter, fibres, placement.
  Specimen turned_body() const;
  /// A vector or place of the scene's frame, in the turned one.
  Vec3 to_turned(const Vec3& v) const;
  /// The scene's node that is nearest to a node of the turned body.
  std::int64_t nearest_node(const Specimen& body, std::int64_t node) const;
  /// The scene's cell at the middle of a cell of the turned body; -1 outside.
  std::int64_t cell_at_middle_of(const Specimen& body, std::int64_t cell) const;
  /// Part of the turned axis `j` that lies within the scene's axes of `mask` (a bit each), squared: 0 where
  /// it has none, 1 where all.
  double share(unsigned mask, int j) const;

private:
  Vec3 turned_fibre(const Vec3& fibre) const;

  const Scene& scene_;
  Vec3 spacing_;         ///< of the turned grid
  Eigen::Matrix3d axes_; ///< columns: the turned axes, in the scene's frame
};

} // namespace maille::reader
