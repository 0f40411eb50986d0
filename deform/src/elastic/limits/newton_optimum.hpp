#pragma once
/// The least elastic energy within the limits of the links, where a multigrid of the operator itself is at
/// hand.

#include "elastic/limits/coupled_optimum.hpp"

#include <memory>

namespace maille::deform {

/// The method of multipliers like the general way, with ten times its penalty, by truncated Newton steps. The
/// energy with penalties on the links that are outside now is quadratic; conjugate gradients go down on it
/// around one cycle of the multigrid of K, which is told of those penalties (see BoxMultigrid::stiffen,
/// MatterMultigrid::stiffen), then comes the exact minimum along the direction that they found. How many of
/// their iterations a direction is worth is learned: twice as many when the whole step was good, half as many
/// when other links stopped it. Multipliers are improved after a step shorter than what the state is from the
/// limits. After most_iterations the general way goes on: at the end single links come and go, steps get
/// short, and its lower penalty is surer.
///
/// On the finest box to 1e-2 or more, with multipliers from a coarser one, a direction of two iterations with
/// four times the penalty comes first: the links' own state depends less on what the multipliers lack then.
/// If it says that the state is near enough, by a fifth more than asked, that is all; else the search above
/// goes on from there. (Penalties 3000 to 6000 do as well. For all iterations, or on coarser bodies too: two
/// to five iterations where it works, and two to three times as long where the general way has to go on. For
/// bodies of any shape up to half as many iterations again.)
///
/// The error is that of displacements: the step's, or of short steps the longer of the last two, and what
/// links are outside.
///
/// Measured: told of links 10, 100 and 1000 times as stiff as their own in a cone about a poke, conjugate
/// gradients take 6, 10 and 18 iterations to 1e-4 on 33^3 nodes, 6, 11 and 26 on 65^3, and 5 without such
/// links. On 65^3 nodes limits exceeded 3.3, 5, 5 (nu = 0.45) and 20 times take 8, 9, 7 and 8 iterations on
/// the finest grid to energies 0.003 to 0.3 % and displacements 0.06 to 0.5 % from long runs (others 2 to 4 %
/// in energy where nu is 0.45 and 0.49: docs/relax.md), coarser bodies beside; the general way 25 in the last
/// case, half again as dear each. One more or less of the last bit makes a third more or fewer iterations.
/// Not as good: penalty 100, 300 (steps whole sooner, multipliers slower: up to 38); whole Newton steps from
/// the start (steps of 0.01 without end); multipliers improved sooner (half as many iterations in one case,
/// four times as many in another); multipliers of the coarser body left there (three to ten times as many).
///
/// Bodies that are no boxes: both legs of a calf within their own limits (48,414 nodes, 177 links bind) to
/// 1e-4 take 166 iterations and 3.2 s of processor time, where the general way takes 435 and 12.0; with 20
/// iterations before the general way 315 and 8.7. Boxes with thousands of links at their limits do not settle
/// in 200 either, so there it stays at 20.
///
/// Same bits for any number of threads.
///
/// Source  Bertsekas 1982 (see CoupledOptimum); Nocedal and Wright 2006, Numerical Optimization, section 7.1
///         (truncated Newton steps)
/// Checked by  tests/deform/elastic/coupled_limits_test.cpp, box_stiffening_test.cpp,
///             matter_stiffening_test.cpp
class NewtonOptimum : public CoupledOptimum {
public:
  /// All must outlive this. @pre task.limits and system.has_multigrid()
  NewtonOptimum(const CoupledTask& task, CoupledSystem& system);

  bool solve(Displacement& u, Answer& answer) override;
  void rely_on_multipliers() override;
  std::int64_t bytes() const override;

private:
  void stiffen();
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

  std::vector<StiffenedLink> stiffened_;
  std::vector<Products> products_; ///< per plane
  bool is_stiffened_ = false;
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
