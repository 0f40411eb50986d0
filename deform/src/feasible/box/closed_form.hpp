#pragma once
/// One handle dragged in a homogeneous body whose nodes it all reaches monotonely: Theorems 1 to 3 at the
/// speed of memory.

#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/box/scan_kernel.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include <array>

namespace maille::deform {

/// Data of a field that let drags stop early.
struct Rounding {
  double largest = 0; ///< no stored number is larger than this
};

/// Collects up to three drags, one per component, and does them in one go on all threads.
/// With x feasible and p above x_c, x' = max(x, p - d(i, c)) is the feasible state with x'_c = p that moves
/// every node least (Theorem 1; below, min(x, p + d(c, i))); d is a sum of one term per axis (Theorem 2).
/// What changes is closed toward the handle (Theorem 3): the loops start at the handle and leave a slab, a
/// row or a block of a row as soon as a node there is inside its bound by more than rounding can be, since
/// then no node behind it changes. So leaving early changes no bit, whatever the vectors' width.
///
/// The same holds in a body that does not fill its grid, as long as every node that was ever a handle reaches
/// all others monotonely: grid points without matter are carried along as if they had some.
///
/// Allocates in the constructor only: one row per component.
template<class T>
class ClosedForm {
public:
  explicit ClosedForm(const Grid& grid);

  /// A drag of `handle` to `value`, both and `rounding` in the field's own numbers. @pre component not added
  /// since run(); the field is feasible within rounding; |bounds| finite
  /// @param stops false: visit every node (where grid points without matter are not feasible)
  void add(int component, const Field<T>& field, const LinkIntervals<double>& bounds, const Index3& handle,
           double value, Rounding& rounding, bool stops = true);
  /// Does the drags that were added. @return nodes visited, a node counting once per component
  std::int64_t run(ThreadTeam& team);

private:
  std::array<AlignedArray<T>, 3> row_;
  std::array<Cone<T>, 3> cones_;
  int n_cones_ = 0;
};

/// Margin by which a node of a feasible field must be inside its bound for the nodes behind it to be
/// unaffected: well above rounding of any sum here, far below any visible drag.
template<class T>
double safe_margin(const Index3& nodes, double largest);

extern template class ClosedForm<float>;
extern template class ClosedForm<double>;

} // namespace maille::deform
