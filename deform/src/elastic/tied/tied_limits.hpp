#pragma once
/// The least energy within the limits of links, where nodes are tied along arbitrary directions.
///
/// Scheme (ADMM): min over u of energy(u) + rho / 2 |d u - z + y|^2_w, then z = d u + y clamped to the limits
/// (over-relaxed), then y += d u - z. d u are the stretches of the links, w their weights, y scaled
/// multipliers. The two residuals are d u - z (primal) and the change of z (dual); both end below
/// `tolerance`. rho is adapted to balance them in the first half of the rounds. Ties are eliminated from u,
/// so they hold exactly.

#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/tied/tied_links.hpp"
#include "elastic/tied/tied_model.hpp"
#include "maille/scene/arena.hpp"

#include <optional>
#include <vector>

namespace maille::deform {

/// The minimum of 1/2 u . K u - f . u among tied states with low <= d u <= high on every link, by alternating
/// directions (ADMM): displacements that obey only the ties, and link values that obey only the limits,
/// approach each other, with multipliers that accumulate the difference. Every round is one linear solve with
/// one operator, K plus that of the links; if K is that of the links, a round halves the error.
///
/// Source  Boyd et al. 2011, Distributed Optimization and Statistical Learning via the Alternating Direction
///         Method of Multipliers, sections 3.3 and 3.4 (residuals, penalties that balance them, steps beyond)
/// Checked by  tests/deform/elastic/tied/tied_limits_test.cpp
class LeastWithinLimits : private FieldGradients, private ElasticOperator {
public:
  /// All must outlive it. @param links with limits; @param loads [component][node], empty: none [N];
  /// @param penalty of the links beside K at first [1]
  LeastWithinLimits(TiedModel& model, TiedLinks& links, const Loads& loads, double penalty);

  /// Changes u, in which tied nodes are together and what is prescribed has its values.
  /// @return whether links miss their limits by no more than `tolerance` [m], and go on to
  bool solve(Displacement& u, double tolerance, Answer& answer);
  /// Largest violation of the limits at the end [m].
  double missed() const { return missed_; }
  /// The forces of springs, loads and limits on every node, less those of ties [N]: in balance at free
  /// nodes to `tolerance` of the sum of all forces, for a state next to `u`. A round that ends by its
  /// displacement alone leaves a slender body's forces far from balance.
  /// @return whether they are
  bool balance_forces(Displacement u, double tolerance, Displacement& forces, Answer& answer);

private:
  /// K and the links.
  void apply(const Displacement& u, Displacement& forces) override;
  void precondition(const Displacement& residual, Displacement& correction) override {
    model_.precondition(residual, correction);
  }
  /// Loads and pulls of limits less what the body resists with.
  void find_residual(const Displacement& u, Displacement& residual);
  void take_state(Displacement& u, Answer& answer);
  void balance(const TiedLinks::Round& round);

  TiedModel& model_;
  TiedLinks& links_;
  const Loads& loads_;
  double penalty_, missed_ = 0;
};

/// Changes u, in which tied nodes are together, to the least energy within limits (see LeastWithinLimits) and
/// then to the nearest state that keeps them to the last bit, in which ties may be open by as much as the
/// answer's residual says. Adds to iterations, and says in the answer's message where borders stay open.
/// @param links    whose weights are those of penalties; takes the limits of the model's task
/// @param loads    [component][node], empty: none [N]; @param penalty at first, beside the operator [1]
/// @param knows_forces  reactions are wanted: those of the least energy
/// @return  whether every tie is closed to the scene's tolerance of the largest displacement
bool keep_within_limits(TiedModel& model, TiedLinks& links, const Loads& loads, double penalty,
                        bool knows_forces, Displacement& u, Answer& answer);

/// What holds every prescribed component. @param forces K u - loads, and what limits pull with; changed
std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces);

} // namespace maille::deform
