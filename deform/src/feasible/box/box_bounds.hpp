#pragma once
/// Bounds in homogeneous bodies that paths cross monotonely: sums of one term per axis.

#include "feasible/bounds/bound_source.hpp"
#include "feasible/box/separable_scans.hpp"
#include "lattice/field_memory.hpp"

#include <array>

namespace maille::deform {

/// By brute force over all pairs of ends and nodes where those are few, by scans of the slabs that hold ends
/// where they are many; which, depends on their number alone.
///
/// Allocates only where there are more ends or nodes than ever before, or the first scan.
class BoxBounds : public BoundSource {
public:
  BoxBounds(const Grid& grid, const std::array<StepBounds, 3>& bounds) : grid_(grid), bounds_(bounds) {}
  void bounds_at(Side side, int component, std::span<const PathEnd> ends, std::span<const std::int64_t> nodes,
                 std::span<double> values) override;
  std::int64_t bytes() const;
  /// The same before anything is asked, for `n` ends and nodes in no more slabs than they need be.
  static std::int64_t bytes_for(const Grid& grid, std::int64_t n);

private:
  void by_pairs(Bound<double>& bound);
  void by_scans(Bound<double>& bound, const Slopes& slopes, std::span<double> values);
  std::int64_t work_of_scans() const;

  Grid grid_;
  std::array<StepBounds, 3> bounds_;
  std::vector<GridSeed> seeds_, queries_;
  std::vector<std::int32_t> order_; ///< of the queries
  std::vector<double> sorted_values_;
  std::array<std::vector<double>, 4> arrays_; ///< x, y, z, value of the seeds
  AlignedArray<double> slab_, row_;
  RowPaths<double> row_paths_;
};

} // namespace maille::deform
