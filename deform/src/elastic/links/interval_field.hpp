#pragma once
/// The limits of one component's links in the order of a dense field, and the loops over them.
///
/// Elastic solvers work on dense fields (one number per grid node), LinkLimits by cell kinds. An
/// IntervalField is the table between: low and high per axis and node, or one pair per axis where all links
/// are alike.

#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"
#include "parallel/thread_team.hpp"

#include <array>
#include <span>

namespace maille::deform {

/// The links from n nodes of a row to the next along an axis, `here` and `next` their displacements.
struct LinkRow {
  int n = 0;
  bool is_same = true; ///< one range for all
  const double *here = nullptr, *next = nullptr, *low = nullptr, *high = nullptr;
};

/// True if a link is outside its range by more than `tolerance`.
bool is_any_outside(const LinkRow& links, double tolerance);
/// Largest violation of a range; 0 if none.
double largest_excess(const LinkRow& links);

/// Interval of the displacement difference along each link: one number per axis if all links agree, else one
/// per node and axis, for the link to the next node; (-infinity, infinity) without a link.
class IntervalField {
public:
  IntervalField(const Scene& scene, const LinkLimits& limits, int component);

  /// @param axis of the grid; @param node dense number of the link's first node
  double low(int axis, std::size_t node) const { return at(intervals_.low, axis, node); }
  double high(int axis, std::size_t node) const { return at(intervals_.high, axis, node); }

  /// Largest violation of a link of plane `z` of the grid (row y in 2D).
  double excess_in_plane(int z, const double* u) const;
  /// True if a link along `axis` from the row of nodes at `at` is outside its range by more than `tolerance`.
  bool is_any_outside_in_row(int axis, const Index3& at, const double* u, double tolerance) const;
  int n_planes() const { return nodes_[2] > 1 ? nodes_[2] : nodes_[1]; }

private:
  bool is_same_everywhere() const { return intervals_.low[0].size() == 1; }
  static double at(const std::array<List<double>, 3>& values, int axis, std::size_t node) {
    const auto& list = values[axis];
    return list.size() == 1 ? list[0] : list[node];
  }

  /// The links along an axis from one row of nodes; none if there are none.
  LinkRow row(int axis, const Index3& at, const double* u) const;

  int dimension_;
  Index3 nodes_;
  LinkIntervals<List<double>> intervals_; ///< [axis][node]
};

/// The least and the largest of all values and 0.
std::array<double, 2> range_of(std::span<const double> values);

/// True if no link of a component can reach its limits while all displacements are between `least` and
/// `most`, so that clipping and checks can be skipped. Cost: O(kinds of matter)
bool cannot_be_reached(const LinkLimits& limits, int component, int dimension, double least, double most);
/// The same for the prescribed values of a scene; clipping then changes nothing.
bool permit_all_that_is_prescribed(const LinkLimits& limits, const Scene& scene);

/// True if a link of one component violates the limits by more than `rounding` [m]. Skips a component whose
/// displacements cannot reach its limits. @param u of the component, per node
bool breaks_limits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team, int component,
                   std::span<const double> u, double rounding);
/// The same for all components: by more than `part` of the largest displacement, and more than rounding.
bool breaks_limits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team, const Displacement& u,
                   double part);

} // namespace maille::deform
