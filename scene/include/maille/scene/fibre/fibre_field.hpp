#pragma once
/// Fields of directions without sign: one per cell, their means, filling of gaps and smoothing of noise; and
/// directions along lines that are drawn by hand or traced in a picture.
/// same question on a lattice that is turned to their mean, for methods whose links know only its axes.

#include "maille/base/grid.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace maille {

/// Eigenvector of the largest eigenvalue of a symmetric matrix; nothing if that is not positive, or within
/// 1e-9 (relative) of the next. For a diffusion tensor it is the fibre direction; for a sum of dyads v v^T
/// the mean of directions without sign.
/// Source  Basser, Mattiello, LeBihan 1994 (tensor); Bingham 1974, Annals of Statistics 2 (dyads)
std::optional<std::array<float, 3>> first_eigenvector(const Eigen::Matrix3d& matrix);

/// Directions of a body's cells in Specimen::fibres, some of them unknown, and the regions (muscles) that are
/// averaged separately. Results do not depend on the signs of directions, except for their own sign, nor on
/// the order of cells.
class FibreField {
public:
  /// @param region    a number per cell of the grid; ignored without matter
  /// @param is_known  per cell: true if its direction is known
  /// @pre body.fibres has an entry per cell; at least one cell of matter is known
  FibreField(Specimen& body, std::vector<std::int32_t> region, std::vector<bool> is_known);

  /// Replaces every known direction by the first eigenvector of the mean dyad of the known directions of its
  /// region within `radius` of cell centres, equally weighted; unchanged if that mean has no dominant
  /// direction.
  /// Cost  O(cells times cells within the radius)
  /// @return mean angle between old and new directions [rad], 0 to pi/2
  double smooth(double radius);

  /// Gives every cell of matter a direction. Layer by layer, unknown cells take the first eigenvector of the
  /// mean dyad of the known neighbours in their region (26 in 3D); without a dominant direction, that of the
  /// region; without one there, that of the body. Counts are added to `report`.
  void fill(FibreReport& report);

private:
  Eigen::Matrix3d dyad(std::size_t cell) const;
  bool is_known_in(std::int64_t cell, std::int32_t region) const;
  /// Sum of the dyads of known cells of the same region at `offsets` from a cell.
  Eigen::Matrix3d sum_around(std::int64_t cell, std::span<const Index3> offsets) const;
  /// Fills one layer and removes the filled cells from `unknown`. @return their number
  std::int64_t fill_layer(std::vector<std::int64_t>& unknown, std::span<const Index3> offsets);

  Specimen& body_;
  std::vector<std::int32_t> region_;
  std::vector<bool> is_known_;
};

class BoxTree;

/// A polyline with a smoothed direction. At its points the direction bisects the angle between the two
/// adjacent pieces (at free ends it is that of the end piece); along a piece it is the normalised linear
/// blend of those at its ends, so it is continuous along the line. A regular polygon on a circle has exactly
/// the circle's directions on the line; beside the line the error is at most half of the angle between two
/// pieces. Two points define a constant direction. A line with equal first and last point is closed.
class FibreCurve {
public:
  /// @param points [m]; at least two, no two successive ones equal, no piece that reverses its predecessor
  explicit FibreCurve(std::span<const Vec3> points);

  /// Direction at the point of the line nearest to `position`; the first along the line if several are
  /// equally near. Unit length. Usually O(log(points))
  Vec3 direction_at(const Vec3& position) const;

  /// True if the pieces that meet at the point between `before` and `after` point in opposite directions.
  static bool doubles_back(const Vec3& before, const Vec3& at, const Vec3& after);

private:
  std::vector<Vec3> points_, directions_; ///< directions at the points
  std::shared_ptr<const BoxTree> pieces_;
};

/// Why a scene cannot be put on a turned lattice.
struct LatticeRefusal {
  std::string expected, found;
};

/// The direction that the fibres of the body's matter have in common, signs aside: the first principal axis
/// of the mean of f f^T, turned to the side of +x. @param agreement how much of the fibres it holds: 1 where
/// all are alike, 1 / dimension where none stands out
Vec3 mean_fibre(const Specimen& specimen, double& agreement);

/// A copy of `scene` on a lattice whose x axis is mean_fibre(): the smallest turn of the axis that is nearest
/// to it, which then is called x. A scene whose fibres run along x already comes back as it is.
///
/// Shape    same spacings, centred on the body's box; a cell holds what the scene has at its middle, so an
///          oblique face is a stair, off by up to 0.87 spacings, and right in the mean
/// Holds    and moves: a node takes what is prescribed for the scene's nearest node, turned; moves that turn
///          are placed anew
/// Frame    everything in the result is in the turned lattice's frame; given limits are along the axes of
///          either. specimen.placement takes it to the world
/// Refused  in 1D; where fibres leave the plane of a 2D scene or have no common direction (agreement below
///          0.6); tractions; conditions on some axes of a node that the turn mixes with others, or too small
///          for any node
/// Cost     O(cells of both lattices)
std::variant<Scene, LatticeRefusal> on_fibre_lattice(const Scene& scene);

} // namespace maille
