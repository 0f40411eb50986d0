#pragma once
/// The least elastic energy within the limits of the links, where a multigrid of the operator itself is at hand.

#include "relax/coupled_optimum.hpp"

#include <memory>

namespace maille::deform {

/// The method of multipliers like the general way, with three times its penalty, by truncated Newton steps: the energy with penalties on
/// the links that are outside now is quadratic; conjugate gradients go down on it around one cycle of the multigrid of K, which is told
/// of those penalties (see BoxMultigrid::stiffen), then comes the exact minimum along the direction that they found. How
/// many of their iterations a direction is worth is learned: twice as many when the whole step was good, half as many when other links
/// stopped it. Multipliers are improved after a step that brings the state less than it is from the limits.
///
/// With the penalties in it the multigrid needs as many iterations for a linear problem as for K alone, up to ten times the links'
/// stiffness, twice as many at a hundred times (33^3, links in a cone around a poke: 5, 6, 10 to 1e-4 with 0, 10, 100; without them
/// CG needs about the square root). So few steps lead near the optimum; but at the end, where single links come and go, steps get
/// short, and from there the general way is surer: it goes on after most_iterations.
///
/// Measured before it was chosen (65^3, exceeded 5 times and the benchmark's poke; iterations to 1e-2 of the optimum in the energy norm):
/// the general way 11 to 25 that cost three times as much; one conjugate gradient iteration per step with penalty 100, 300 and 1000:
/// 24, 12, 8; whole Newton steps from the start: steps of 0.01 and no end in sight; multipliers not carried over from the coarser body: twice
/// to four times as many.
///
/// Same bits for any number of threads.
///
/// Source  Bertsekas 1982 (see CoupledOptimum); Nocedal and Wright 2006, Numerical Optimization, section 7.1 (truncated Newton steps)
class NewtonOptimum : public CoupledOptimum {
public:
  /// All must outlive this. @pre task.limits and system.has_multigrid()
  NewtonOptimum(const CoupledTask& task, CoupledSystem& system);

  bool solve(Displacement& u, Answer& answer) override;
  std::int64_t bytes() const override;

private:
  void stiffen();
  void find_direction(Answer& answer);
  void iterate(Answer& answer);
  bool take_step(Displacement& u);
  /// Of direction_ with its image, with the residual and with itself, and of the state with itself.
  struct Products {
    double curvature = 0, descent = 0, length = 0, size = 0;
  };
  Products find_products(const Displacement& u);
  template<class Work>
  void for_all(const Work& work);
  template<class Visit>
  void for_forces(const Displacement& field, const Visit& visit) const;

  Displacement remaining_, search_, image_of_search_; ///< of conjugate gradients, once they are needed
  std::vector<StiffenedLink> stiffened_;
  std::vector<Products> products_; ///< per plane
  bool is_stiffened_ = false;
  int depth_ = 1;     ///< iterations per direction
  double length_ = 0; ///< of the last step, 1 for a whole one
  double way_ = 0;    ///< u . K u of that, or of the whole one if that is more [J]
};

/// For systems with a multigrid NewtonOptimum, for others the general way.
std::unique_ptr<CoupledOptimum> make_optimum(const CoupledTask& task, CoupledSystem& system);

} // namespace maille::deform
