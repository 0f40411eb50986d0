#pragma once
/// Where the elastic answer of a box begins: on coarser grids.

#include "elastic/box/box_multigrid.hpp"

#include <array>
#include <functional>
#include <vector>

namespace maille::deform {

/// Full multigrid: the question is solved on the coarsest grid of the multigrid; on every finer one the
/// answer is interpolated, what is prescribed there put in, and one cycle brings it nearer, with the step of
/// least energy along it. Interpolated to the box that is within some hundredths of its answer, for the price
/// of a quarter of an iteration.
///
/// Same bits for any number of threads.
class BoxStart {
public:
  /// @param multigrid its fields are used
  explicit BoxStart(BoxMultigrid& multigrid) : multigrid_(multigrid) {}

  /// Changes `u` where it may move.
  /// @param u      holds the prescribed values, and 0 elsewhere [unit]; [component][z][y][x], as the fields
  ///        of the finest level
  /// @param forces the same of what pulls; null: nothing does
  /// @param is_done called with every plane z when it and its neighbours are found, on any thread
  void solve(float* u, const float* forces, const std::function<void(int z)>& is_done);
  /// Held meanwhile.
  std::int64_t bytes() const { return bytes_; }

private:
  void coarsen_prescribed(std::size_t level, const float* fine, float* coarse);
  void coarsen_forces(std::size_t level, const float* fine, float* coarse);
  void improve(std::size_t level, float* u, const float* forces);
  void interpolate(std::size_t level, const float* coarse, float* fine,
                   const std::function<void(int)>& is_done);
  double prescribed_at(std::size_t level, const float* fine, int c, const Index3& coarse) const;

  BoxMultigrid& multigrid_;
  std::int64_t bytes_ = 0;
};

/// Loads as a field of a level; empty if there are none.
/// @param loads per component and node [N], empty: none along it; @param unit of the field [N]
PaddedArray forces_on(const BoxLevel& level, const Grid& grid,
                      const std::array<std::vector<double>, 3>& loads, double unit);

} // namespace maille::deform
