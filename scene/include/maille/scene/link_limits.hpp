#pragma once
/// The limits of every link of a scene, as bounds on differences of displacement, and the shortest paths
/// that they add up to between two nodes.
///
/// A link joins two nodes along an axis. Stretch and compression bound the component along the axis, shear
/// the others: low <= u_next - u_here <= high per component, an interval that holds 0. Components are
/// therefore independent, and feasible displacements are those of a system of difference constraints
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

/// Resolves `limits = material | taut | given | failure` of a scene. A link that borders cells of several
/// kinds obeys the limits of all of them (the intersection, which always holds the rest state).
///
/// Cost: O(cells) once; `taut` also what taut_scale() of scene/src/taut_scale.hpp says, unless
/// scene.limits.taut_scale is set.
class LinkLimits {
public:
  /// @throws nothing: faults of limits are found by the reader
  explicit LinkLimits(const Scene& scene);

  /// Per component, of the link from `node` to its next node along `axis`; none where that edge borders no
  /// matter.
  std::optional<LinkIntervals<double>> intervals(const Index3& node, int axis) const;
  /// The stress at which the scene's moves just use the slack up [Pa]; 0 unless the limits are taut.
  double taut_scale() const { return taut_scale_; }
  /// Memory held [bytes].
  std::int64_t bytes() const;
  /// What the limits of a scene hold while they are made, at most [bytes].
  static std::int64_t bytes_at_most(const Scene& scene);
  /// True if all links along an axis have the same intervals.
  bool is_homogeneous() const { return cell_class_.empty(); }

  /// What the matter of one cell grants the links around it, by link axis, per component.
  using OfCell = std::array<LinkIntervals<double>, 3>;
  /// The kinds of cells, for methods that keep tables of their own.
  const List<OfCell>& kinds() const { return classes_; }
  /// What every link of the body grants, by link axis, per component: of none less is known. O(kinds)
  OfCell granted_everywhere() const;
  /// Which of kinds() a cell of matter is. @pre the cell is matter
  std::int32_t kind_of(std::int64_t cell) const { return cell_class_.empty() ? 0 : cell_class_[cell]; }

private:
  void classify(const Scene& scene);
  static OfCell given_intervals(const NeighbourLimits& limits, const Vec3& rest);
  /// At 1 Pa. Not by way of ratios to the rest length: 1 + 1e-10 - 1 keeps six digits.
  static OfCell taut_intervals(const LinkCompliance& compliance, const Vec3& rest);

  const Specimen* specimen_; ///< the scene must outlive its limits
  List<OfCell> classes_;
  List<std::int32_t> cell_class_; ///< per cell; empty: class 0 everywhere
  double taut_scale_ = 0;
};

/// A node from which (or to which) paths are measured, with a length to start from.
struct PathEnd {
  std::int64_t node = 0;
  double potential = 0; ///< any finite value [m]
};

/// Which end of a path the given nodes are. The step from a node to its next along an axis costs the link's
/// `high`, the step back costs `-low`, so the two differ where stretch and compression do.
enum class PathDirection { from_ends, to_ends };

/// For every node i of the grid, min over the ends e of potential_e + d(e, i) (or d(i, e) with to_ends), d
/// being the shortest path for one displacement component [m]; +infinity where no path leads and at grid
/// points that are no nodes.
///
/// Dijkstra 1959 with a binary heap: O(links log nodes) time, 8 bytes a grid node. It is the oracle of every
/// faster way. The value at a node is the sum along one path, added up from its end, so it is the same for
/// any order of the ends.
List<double> shortest_paths(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends, PathDirection direction);

} // namespace maille
