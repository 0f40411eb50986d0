#pragma once
/// Cells and nodes of a lattice that is rotated relative to a scene's.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

namespace maille::reader {

/// Maps the lattice of a scene to a rotated one over the same matter.
class TurnedLattice {
public:
  /// Rounding error of 0 after a rotation, and of equal distances in spacings.
  static constexpr double rounding = 1e-9;

  /// @param scene must outlive this; @param fibre  unit vector of the rotated x axis
  TurnedLattice(const Scene& scene, const Vec3& fibre);

  /// The rotated grid, large enough for the scene's. @param origin of its node 0, rotated frame [m]
  Grid grid(Vec3& origin) const;
  /// The scene's body on the rotated lattice: grid, origin, matter, fibres, placement.
  Specimen turned_body() const;
  /// Transforms a vector or place from the scene's frame to the rotated one.
  Vec3 to_turned(const Vec3& v) const;
  /// The scene's node nearest to a node of the rotated body.
  std::int64_t nearest_node(const Specimen& body, std::int64_t node) const;
  /// The scene's cell at the centre of a cell of the rotated body; -1 outside.
  std::int64_t cell_at_middle_of(const Specimen& body, std::int64_t cell) const;
  /// Squared length of the projection of the rotated axis `j` onto the scene's axes in `mask` (one bit each),
  /// 0 to 1.
  double share(unsigned mask, int j) const;

private:
  Vec3 turned_fibre(const Vec3& fibre) const;

  const Scene& scene_;
  Vec3 spacing_;         ///< of the turned grid
  Eigen::Matrix3d axes_; ///< columns: the turned axes, in the scene's frame
};

} // namespace maille::reader
