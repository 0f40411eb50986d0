#pragma once
/// The least energy within the limits of links, where nodes are tied along arbitrary directions.
///
/// Scheme (ADMM): min over u of energy(u) + rho / 2 |d u - z + y|^2_w, then z = d u + y clamped to the limits
/// (over-relaxed), then y += d u - z. d u are the stretches of the links, w their weights, y scaled
/// multipliers. The two residuals are d u - z (primal) and the change of z (dual); both end below
/// `tolerance`. rho is adapted to balance them in the first half of the rounds. Ties are eliminated from u,
/// so they hold exactly.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/field_sums.hpp"
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
class LeastWithinLimits : private GradientSpace {
public:
  /// All must outlive it. @param links with limits; @param loads [component][node], empty: none [N];
  /// @param penalty of the links beside K at first [1]
  LeastWithinLimits(TiedModel& model, TiedLinks& links, const std::vector<List<double>>& loads,
                    double penalty);

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
  void apply(const Displacement& u, Displacement& forces);
  /// Loads and pulls of limits less what the body resists with.
  void find_residual(const Displacement& u, Displacement& residual);
  void take_state(Displacement& u, Answer& answer);
  void balance(const TiedLinks::Round& round);

  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  double overlap() const override { return overlap_; }

  TiedModel& model_;
  TiedLinks& links_;
  const std::vector<List<double>>& loads_;
  double penalty_, missed_ = 0, overlap_ = 0;
  Displacement residual_, correction_, direction_, image_;
  FieldSums sums_;
  Displacement* u_ = nullptr;
};

} // namespace maille::deform
