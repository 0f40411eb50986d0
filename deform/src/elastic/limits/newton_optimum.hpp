#pragma once
/// The least elastic energy within the limits of the links, where a multigrid of the operator itself is at
/// hand.

#include "elastic/limits/coupled_optimum.hpp"

#include <memory>

namespace maille::deform {

/// An augmented Lagrangian as CoupledOptimum's, with ten times its penalty, by truncated Newton steps:
/// conjugate gradients around one cycle of the multigrid of K, which is told of the penalties of violated
/// links (BoxMultigrid::set_penalties, MaskedMultigrid::set_penalties), then the exact minimum along their
/// direction. Multipliers are improved after a step shorter than the violation. A box asked to 1e-2 or more,
/// with multipliers from a coarser one, first tries one direction of two iterations with four times the
/// penalty. After most_iterations CoupledOptimum's conjugate gradients go on.
///
/// The error is that of displacements: the step's, or of short steps the longer of the last two, and the
/// violation. Same bits for any number of threads. Figures: docs/developers/relaxation.md.
///
/// Source  Bertsekas 1982 (see CoupledOptimum); Nocedal and Wright 2006, Numerical Optimization, section 7.1
/// Checked by  coupled_limits_test.cpp, box_penalties_test.cpp, masked_penalties_test.cpp
class NewtonOptimum : public CoupledOptimum {
public:
  /// All must outlive this. @pre task.limits and system.has_multigrid()
  NewtonOptimum(const CoupledTask& task, CoupledSystem& system);

  bool solve(Displacement& u, Answer& answer) override;
  void rely_on_multipliers() override;
  std::int64_t bytes() const override;

private:
  void set_penalties();
  using Products = CoupledSystem::Products;
  bool may_keep_directions() const;
  Products find_direction(Answer& answer);
  Products keep_direction(Answer& answer);
  Products find_products();
  void move(Displacement& u, double slope, double curvature);
  bool take_step(Displacement& u, const Products& products);
  enum class End { found, stopped, used_up };
  bool attempt(Displacement& u, Answer& answer);
  /// @param most iterations
  End iterate(Displacement& u, Answer& answer, int most);
  void set_penalty(double rho);

  std::vector<PenaltyLink> penalties_;
  std::vector<Products> products_; ///< per plane
  bool has_penalties_ = false;
  bool relies_on_multipliers_ = false;
  bool keeps_directions_ = false; ///< the system does
  int depth_ = 1;                 ///< iterations per direction
  double size_ = 0;               ///< u . u at the start [m^2]
  double length_ = 0;             ///< of the last step, 1 for a whole one
  double way_ = 0;                ///< u . K u of that, or of the whole one if that is more [J]
};

/// For systems with a multigrid NewtonOptimum, for others the general way.
std::unique_ptr<CoupledOptimum> make_optimum(const CoupledTask& task, CoupledSystem& system);

} // namespace maille::deform
