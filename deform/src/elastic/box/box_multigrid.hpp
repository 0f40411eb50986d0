#pragma once
/// Multigrid for elasticity on a box: as a preconditioner, and full, as where the answer begins.

#include "elastic/box/box_coarsest.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace maille::deform {

/// A symmetric V-cycle: Chebyshev's Jacobi steps on every level, the operator itself on coarser grids, linear
/// interpolation, a direct solve at the bottom. The planes of a level go through all steps of one leg while
/// they are in the cache.
///
/// Same bits for any number of threads.
///
/// Source  docs/theory.md, section 3 (Solving LAT)
class BoxMultigrid {
public:
  /// @param steps of relaxation before and after each coarser level, 2 or more
  BoxMultigrid(std::unique_ptr<BoxLevel> finest, int steps, ThreadTeam& team);

  BoxLevel& finest() { return *levels_[0]; }
  std::size_t n_levels() const { return levels_.size(); }
  BoxLevel& level(std::size_t i) { return *levels_[i]; }
  const BoxLevel& level(std::size_t i) const { return *levels_[i]; }
  /// level(i).u = one cycle for A u = level(i).f from nothing.
  void cycle(std::size_t level) { cycle(level, 0); }
  /// Stiffens links of the body, and of its coarser levels as they follow from it: see BoxLevel. Those of
  /// before are so no longer.
  void set_penalties(std::vector<PenaltyLink> links);
  /// finest().f -= step finest().r, and then finest().u = one cycle for A u = finest().f from nothing.
  /// Changes finest().r. @return u . f
  double precondition(float step = 0);
  /// Calls work(z) for all planes of the finest level. @return the sum of what it returns
  template<class Work>
  double sum_over_planes(Work&& work) {
    team_for(finest()).run(finest().A().nodes[2],
                           [&](int z, int) { sums_[static_cast<std::size_t>(z)] = work(z); });
    return total();
  }
  /// The sum over planes of what was put into sums(), in their order.
  double total() const;
  std::span<double> sums() { return sums_; }
  ThreadTeam& team_for(const BoxLevel& level);
  /// Memory for the loops of the calling thread, on any level.
  void* scratch() const;
  /// K u on plane z of the body in the unit of its stiffness, [component][node], until the thread's next
  /// plane.
  const double* forces_of_plane(const Displacement& u, int z) const;
  /// Nodes in a plane of the body.
  std::size_t in_plane() const;
  std::int64_t bytes() const;

private:
  /// A Jacobi step on one plane.
  void relax(const BoxLevel& level, int z, float weight, const float* u, float* next) const;
  void cycle(std::size_t level, float step);
  void go_down(std::size_t level, float step);
  void come_up(std::size_t level);
  bool is_thin_end();

  std::vector<std::unique_ptr<BoxLevel>> levels_;
  std::vector<std::vector<float>> weights_; ///< per level, of its relaxation steps
  std::vector<std::vector<std::vector<int>>>
      triggered_; ///< per level and fine plane: the coarse planes to sum up
  std::unique_ptr<BoxCoarsest> coarsest_;
  std::vector<double> sums_;
  ThreadTeam& team_;
  ThreadTeam alone_{1};
};

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
