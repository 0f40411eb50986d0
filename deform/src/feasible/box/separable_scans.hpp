#pragma once
/// Drags any number of handles in a homogeneous box at once: Theorem 4, at a cost independent of their
/// number; and bounds of other nodes.

#include "feasible/bounds/bound_source.hpp"
#include "feasible/box/closed_form.hpp"
#include "feasible/box/scan_kernel.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include "maille/base/arena.hpp"

#include <array>
#include <span>
#include <vector>

namespace maille::deform {

/// A node that is put somewhere, in the numbers of a field.
struct HandleValue {
  Index3 at{};
  double value = 0;
};

/// Path lengths along x between any two nodes of a row, T(offset * slope): the rows of all cones.
template<class T>
class RowPaths {
public:
  /// Allocates the first time. @pre the same `nodes` every time
  void fill(const Slopes& slopes, int nodes);
  const T* data() const { return offsets_.data(); }

private:
  AlignedArray<T> offsets_;
};

/// Collects drags of many handles, up to three components, and does them in one go on all threads.
///  x' = clamp(x, L, U) with L = max over the handles that go up of p_h - d(., h), U = min over those that go
/// down of p_h + d(h, .); a handle that goes up adds nothing to U, as a feasible x is below its part there.
/// On a box d is a sum of one term per axis, so L and U are built by scans: seeds are laid out along their
/// rows, scanned along y within their slab, and carried along z, forward and backward. A bound exists for one
/// slab at a time, in cache; the body passes through memory twice, once where all handles share a slab.
/// Clamping twice, with the bound from below and the bound from above each, is clamping with both at once,
/// since every least bound of clipped handles is at or below every greatest one.
///
/// Allocates on the first use after construction, and later only if there are more handles than before.
template<class T>
class SeparableScans {
public:
  SeparableScans(const Grid& grid, const std::array<LinkIntervals<double>, 3>& bounds, int threads);

  /// @param handles of one component, by node number; nodes that must stay and already are where they must be
  /// need not be among them. @pre clipped together, and with all nodes that must stay; the field is feasible
  void add(int component, const Field<T>& field, std::span<const HandleValue> handles, Rounding& rounding);
  /// Does the drags that were added. @return nodes visited, a node counting once per component and pass
  std::int64_t run(ThreadTeam& team);

private:
  struct Component {
    Field<T> field;
    std::array<RowPaths<T>, 2> row_paths; ///< least, greatest
    std::array<List<GridSeed>, 2> seeds;
    double margin = 0;
    double farthest = 0; ///< more than any two stored numbers differ by
    bool is_added = false;
  };
  struct Workspace {
    std::array<AlignedArray<T>, 2> slab;
    AlignedArray<T> row;
  };
  void prepare();
  Sweep<T> sweep(int component, int strip, int n_strips, Workspace& workspace) const;
  void place_handles(Component& component) const;

  Grid grid_;
  std::array<LinkIntervals<double>, 3> bounds_;
  int threads_;
  std::array<Component, 3> components_;
  std::vector<Workspace> workspaces_; ///< per thread
};

extern template class SeparableScans<float>;
extern template class SeparableScans<double>;

/// Bounds on a box: brute force over all pairs of ends and nodes while those are few, otherwise scans of the
/// slabs that hold ends. The choice depends on their number alone.
///
/// Allocates only for more ends or nodes than ever before, or for the first scan.
class BoxBounds : public BoundSource {
public:
  BoxBounds(const Grid& grid, const std::array<LinkIntervals<double>, 3>& bounds)
      : grid_(grid), bounds_(bounds) {}
  void bounds_at(Side side, int component, std::span<const PathEnd> ends, std::span<const std::int64_t> nodes,
                 std::span<double> values) override;

private:
  void by_pairs(Bound<double>& bound);
  void by_scans(Bound<double>& bound, const Slopes& slopes, std::span<double> values);
  std::int64_t work_of_scans() const;

  Grid grid_;
  std::array<LinkIntervals<double>, 3> bounds_;
  List<GridSeed> seeds_, queries_;
  List<std::int32_t> order_; ///< of the queries
  List<double> sorted_values_;
  std::array<List<double>, 4> arrays_; ///< x, y, z, value of the seeds
  AlignedArray<double> slab_, row_;
  RowPaths<double> row_paths_;
};

} // namespace maille::deform
