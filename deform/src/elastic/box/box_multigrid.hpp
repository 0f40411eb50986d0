#pragma once
/// Multigrid for elasticity on a box: a preconditioner, and full multigrid for the start.

#include "elastic/box/box_level.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <functional>
#include <memory>

namespace maille::deform {

/// Rediscretised operators on coarser grids, linear interpolation. See PlaneMultigrid.
class BoxMultigrid : public PlaneMultigrid<BoxLevel> {
public:
  /// @param steps of relaxation before and after each coarser level, 2 or more
  BoxMultigrid(std::unique_ptr<BoxLevel> finest, int steps, ThreadTeam& team)
      : PlaneMultigrid(with_relaxation(std::move(finest), steps), team) {}

  /// K u on plane z in the unit of stiffness, [component][node]; valid until the next call on this thread.
  const double* forces_of_plane(const Displacement& u, int z) const;
  /// Nodes in a plane of the body.
  std::size_t in_plane() const {
    return static_cast<std::size_t>(finest().nodes()[0]) * static_cast<std::size_t>(finest().nodes()[1]);
  }

private:
  static std::unique_ptr<BoxLevel> with_relaxation(std::unique_ptr<BoxLevel> finest, int steps) {
    finest->set_relaxation(steps);
    return finest;
  }
};

/// Full multigrid: solves on the coarsest grid; on every finer grid it interpolates, sets prescribed values,
/// and improves by one cycle with the step of least energy. The result is within some hundredths of the
/// answer, for a quarter of the time of an iteration.
///
/// Same bits for any number of threads.
class BoxStart {
public:
  /// @param multigrid its fields are used
  explicit BoxStart(BoxMultigrid& multigrid) : multigrid_(multigrid) {}

  /// Changes free components of `u`.
  /// @param u      holds the prescribed values, and 0 elsewhere [unit]; [component][z][y][x], as the fields
  ///        of the finest level
  /// @param forces loads in the same layout; null: none
  /// @param is_done called for every plane z when it and its neighbours are complete, on any thread
  void solve(float* u, const float* forces, const std::function<void(int z)>& is_done);

private:
  void coarsen_prescribed(std::size_t level, const float* fine, float* coarse);
  void coarsen_forces(std::size_t level, const float* fine, float* coarse);
  void improve(std::size_t level, float* u, const float* forces);
  void interpolate(std::size_t level, const float* coarse, float* fine,
                   const std::function<void(int)>& is_done);
  double prescribed_at(std::size_t level, const float* fine, int c, const Index3& coarse) const;

  BoxMultigrid& multigrid_;
};

} // namespace maille::deform
