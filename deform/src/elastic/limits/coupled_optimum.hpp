#pragma once
/// The least elastic energy within the limits of the links.

#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/limits/active_links.hpp"

#include <array>
#include <utility>
#include <vector>

namespace maille::deform {

/// From the elastic answer to the minimum of 1/2 u . K u - f . u subject to low <= D u <= high on every link,
/// by the method of multipliers on the links that ever were outside (see ActiveLinks).
///
/// For given multipliers the sum of energy and penalties is a smooth convex function, piecewise quadratic:
/// conjugate gradients around one multigrid cycle for K, with the exact minimum along every direction, go
/// down on it. When they are nearer to its minimum than that is to the limits, the multipliers become what
/// the penalties pull with, and it begins again. A link whose limits are one number is like any other, so
/// nothing jams.
/// The cycle is that of the componentwise model, whose link weights the penalties just raise: it is set up
/// anew whenever the links that are outside have changed. So iterations hardly depend on how high the
/// penalties are, and they can be high. (By the multigrid of K alone, not told of penalties, it took five
/// times as many; where it can be told see NewtonOptimum.)
///
/// Same bits for any number of threads.
///
/// Source  Bertsekas 1982, Constrained Optimization and Lagrange Multiplier Methods, chapter 3;
///         docs/theory.md, sections 2 and 7
class CoupledOptimum {
public:
  /// All must outlive this. @pre task.limits
  CoupledOptimum(const CoupledTask& task, CoupledSystem& system);
  virtual ~CoupledOptimum() = default;

  /// Changes `u`, which holds the prescribed values, and adds to the answer's iterations. @return false if
  /// stopped, or given up
  virtual bool solve(Displacement& u, Answer& answer);
  bool has_multigrid() const { return system_.has_multigrid(); }
  /// Begins with the multipliers of the same body on every second node.
  void take_over(const CoupledOptimum& coarse);
  /// Those that were taken over are near the answer's, whose body is the finest: they need to be improved
  /// little.
  virtual void rely_on_multipliers() {}
  /// The estimated error over the answer, both in the energy norm.
  double residual() const { return error_; }
  /// The memory of a field, once nothing is to be solved any more.
  Displacement give_away_field() { return std::move(residual_); }
  /// Adds what the limits pull with at every node [N].
  void add_forces_of_limits(Displacement& forces) const;
  std::size_t n_active() const;
  virtual std::int64_t bytes() const;

protected:
  /// Of the general way, over the links' own stiffness: its multigrid knows both, so much costs little and
  /// brings multipliers near.
  static constexpr double general_penalty = 100;

  /// @param penalty over the links' own stiffness
  CoupledOptimum(const CoupledTask& task, CoupledSystem& system, double penalty);
  void begin(const Displacement& u);
  /// direction_ and image_ have memory from now on.
  void make_room();
  void find_image();
  void set_direction_of_links();
  double best_step(double slope, double curvature);
  void update_forces(const Displacement& u);
  /// The same where the state has not moved, so no link can have come to its limits.
  void update_forces_of_known(const Displacement& u);
  double gap() const;
  double work_of_loads() const;
  double dot(const Displacement& a, const Displacement& b);
  /// Adds up visit(first node, end) over the planes of nodes across the last axis.
  template<class Visit>
  double sum_over_planes(const Visit& visit) {
    const Grid& grid = task_.scene.specimen.grid;
    const int planes = grid.nodes()[d() - 1];
    const auto in_plane = static_cast<std::size_t>(grid.n_nodes() / planes);
    task_.team.run(planes, [&](int plane, int) {
      const auto i = static_cast<std::size_t>(plane);
      sums_[i] = visit(i * in_plane, (i + 1) * in_plane);
    });
    double sum = 0;
    for (const double part : sums_)
      sum += part;
    return sum;
  }
  std::size_t d() const { return static_cast<std::size_t>(task_.scene.dimension()); }
  /// Adds a step along direction_, whose image is image_, to state, residual and energy.
  void move(Displacement& u, double step, double slope, double curvature);
  /// Of the energy along the direction that the links know, the limits' forces left out. @param descent
  /// residual_ . direction
  double slope_of_energy(double descent) const;

  const CoupledTask& task_;
  CoupledSystem& system_;
  std::vector<std::vector<bool>> is_fixed_; ///< [component][node], nodes without matter too
  bool has_voids_ = false;                  ///< nodes without matter
  std::vector<std::vector<double>> loads_;  ///< [N]; empty: none along that component
  CellModuli moduli_;
  std::vector<ActiveLinks> links_; ///< per component
  Displacement residual_;
  Displacement direction_, image_; ///< unless the system keeps them
  Displacement correction_;        ///< once the general way needs it
  std::vector<double> sums_;       ///< per plane
  double rounding_ = 0;            ///< links outside by less are within [m]
  double energy_ = 0;              ///< u . K u at the start [J]
  double error_ = 1;

private:
  bool take_step(Displacement& u);
  void set_penalties(std::size_t component);
  void precondition();
  void improve_multipliers(const Displacement& u);

  std::vector<std::unique_ptr<ComponentwiseSolver>> componentwise_;
  double last_ = 0; ///< r . z of the last step; 0: begin anew
};

} // namespace maille::deform
