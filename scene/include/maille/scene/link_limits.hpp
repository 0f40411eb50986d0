#pragma once
/// The limits of every link of a scene, as bounds on displacement differences, and the shortest paths between
/// nodes that result from them.
///
/// A link joins two nodes along an axis. Stretch and compression bound the component along the axis, shear
/// the others: low <= u_next - u_here <= high per component, an interval that contains 0. Components are
/// therefore independent, and feasible displacements solve a system of difference constraints
/// (docs/theory.md, 1).

#include "maille/base/arena.hpp"
#include "maille/scene/link_intervals.hpp"
#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace maille {

/// Resolves `limits = material | taut | given | failure` of a scene. A link between cells of several kinds
/// obeys the intersection of their limits, which always contains the rest state.
///
/// Cost: O(cells) once; `taut` also the cost of taut_scale() of scene/src/taut_scale.hpp, unless
/// scene.limits.taut_scale is set.
class LinkLimits {
public:
  /// @throws nothing: the reader reports faults of limits
  explicit LinkLimits(const Scene& scene);

  /// Intervals per component for the link from `node` to its next node along `axis`; none if that edge
  /// borders no matter.
  std::optional<LinkIntervals<double>> intervals(const Index3& node, int axis) const;
  /// Stress at which the scene's moves use up the slack exactly [Pa]; 0 unless the limits are taut.
  double taut_scale() const { return taut_scale_; }
  /// Memory held [bytes].
  std::int64_t bytes() const;
  /// Upper bound of the memory while limits are made [bytes].
  static std::int64_t bytes_at_most(const Scene& scene);
  /// True if all links along an axis have the same intervals.
  bool is_homogeneous() const { return cell_class_.empty(); }

  /// Limits of the links around one cell by its matter, by link axis, per component.
  using OfCell = std::array<LinkIntervals<double>, 3>;
  /// The kinds of cells, for methods with their own tables.
  const List<OfCell>& kinds() const { return classes_; }
  /// Interval that the limits of every link contain, by link axis, per component: the intersection of kinds.
  /// O(kinds)
  OfCell granted_everywhere() const;
  /// Index into kinds() of a cell of matter. @pre the cell is matter
  std::int32_t kind_of(std::int64_t cell) const { return cell_class_.empty() ? 0 : cell_class_[cell]; }

private:
  void classify(const Scene& scene);
  static OfCell given_intervals(const NeighbourLimits& limits, const Vec3& rest);
  /// Intervals at 1 Pa. Ratios to the rest length would lose digits: 1 + 1e-10 - 1 keeps six.
  static OfCell taut_intervals(const LinkCompliance& compliance, const Vec3& rest);

  const Specimen* specimen_; ///< the scene must outlive its limits
  List<OfCell> classes_;
  List<std::int32_t> cell_class_; ///< per cell; empty: class 0 everywhere
  double taut_scale_ = 0;
};

/// A node where paths start (or end), with an initial length.
struct PathEnd {
  std::int64_t node = 0;
  double potential = 0; ///< any finite value [m]
};

/// Whether the given nodes are the start or the end of paths. A step from a node to its next along an axis
/// costs the link's `high`, a step back `-low`; the two differ if stretch and compression differ.
enum class PathDirection { from_ends, to_ends };

/// For every node i of the grid: min over the ends e of potential_e + d(e, i) (or d(i, e) with to_ends),
/// where d is the shortest path for one displacement component [m]; +infinity without a path and at grid
/// points that are no nodes.
///
/// Dijkstra 1959 with a binary heap: O(links log nodes) time, 8 bytes per grid node. It is the reference for
/// all faster algorithms. The value at a node is summed along one path from its end, so it does not depend on
/// the order of the ends.
List<double> shortest_paths(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends, PathDirection direction);

} // namespace maille
