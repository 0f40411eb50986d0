#pragma once
/// Fields of directions without a sign: a cell each, their means, and how gaps are closed and noise is evened
/// out; and along lines drawn by hand or traced in a picture. The
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

/// Eigenvector of the largest eigenvalue of a symmetric matrix; nothing if that is not positive, or within a
/// billionth of the next. For a diffusion tensor it is the fibre direction; for a sum of dyads v v^T the mean
/// of directions without sign.
/// Source  Basser, Mattiello, LeBihan 1994 (tensor); Bingham 1974, Annals of Statistics 2 (dyads)
std::optional<std::array<float, 3>> first_eigenvector(const Eigen::Matrix3d& matrix);

/// Directions of a body's cells in Specimen::fibres, of which some are unknown, and the regions (muscles)
/// that they are not mixed across. Results do not depend on the signs of directions, but for their own, nor
/// on the order of cells.
class FibreField {
public:
  /// @param region    a number for each cell of the grid; of no account where there is no matter
  /// @param is_known  for each cell: its direction is known
  /// @pre body.fibres has an entry for each cell; at least one cell of matter is known
  FibreField(Specimen& body, std::vector<std::int32_t> region, std::vector<bool> is_known);

  /// Replaces every known direction by the first eigenvector of the mean dyad of the known ones of its region
  /// whose cells' middles are within `radius` of its own, each counting the same; kept where no direction
  /// stands out of that mean.
  /// Cost  O(cells times cells within the radius)
  /// @return mean angle between a direction and what it was [rad], 0 to pi/2
  double smooth(double radius);

  /// Gives every cell of matter a direction. Layer by layer, unknown cells take the first eigenvector of the
  /// mean dyad of the known ones of their region among the cells around them (26 in 3D); where that says
  /// nothing, that of their region, and where that has none, that of the body. Counts are added to `report`.
  void fill(FibreReport& report);

private:
  Eigen::Matrix3d dyad(std::size_t cell) const;
  bool is_known_in(std::int64_t cell, std::int32_t region) const;
  /// Sum of the dyads of known cells of the same region at `offsets` from a cell.
  Eigen::Matrix3d sum_around(std::int64_t cell, std::span<const Index3> offsets) const;
  /// One layer; takes the cells that got a direction out of `unknown`. @return how many
  std::int64_t fill_layer(std::vector<std::int64_t>& unknown, std::span<const Index3> offsets);

  Specimen& body_;
  std::vector<std::int32_t> region_;
  std::vector<bool> is_known_;
};

class BoxTree;

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
  /// Unit length. O(log(points)) as a rule
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
