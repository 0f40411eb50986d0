#pragma once
/// When conjugate gradients have converged, stagnated or diverged: the one stopping rule of elastic solves.
///
/// Notation: r = f - K u the residual, B the preconditioner, product = r . B r, energy = u . K u, both in the
/// same unit.
///
/// The energy norm of the error, relative to the answer's, is estimated from two sides: from the energies
/// that the last steps brought, which tell where convergence is even; and from product and the smallest
/// eigenvalue that the steps have met (a Ritz value of B K), which tells of an error that brings little
/// energy because B hardly sees it: the bending of slender and thin bodies. The displacement norm (Euclidean)
/// is estimated from the length of the last step.
///
/// converged   Float32 rounds: the energy norm is within the tolerance. Float64 (judge()): both norms are
///             within a third of it, confirmed on a recomputed residual; or the residual is at the level of
///             its rounding and no longer falls
/// stagnated   no better product for `patience` iterations, or no descent direction, above rounding level
/// diverged    a number is not finite
///
/// Exact: nothing; all are estimates. Heuristic: the factors 2, 3, a third, and 100 for rounding.
///
/// Source  Strakos and Tichy 2002, equation 4.4 (energies); Meurant and Tichy 2013, section 2 (Ritz values
///         from the coefficients)

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace maille::deform {

class Convergence {
public:
  enum class End { converged, stagnated, diverged };
  /// The state after the last step.
  struct State {
    double energy = 0; ///< u . K u
    double moved = 0;  ///< squared length of the last step
    double length = 0; ///< squared, of u
  };

  /// @param tolerance of the error, relative to the answer [1]
  explicit Convergence(double tolerance) : tolerance_(tolerance) {}

  /// Adds a step along a direction whose residual r had r . B r = product, counted in scale^2.
  void add(double step, double product, double scale = 1);
  /// The residual was recomputed, or the directions forgotten: products of before and after make no
  /// coefficients.
  void restart();
  bool is_empty() const { return gains_.empty(); }
  /// True if there were enough steps to tell rates and the smallest eigenvalue.
  bool is_measured() const;
  /// Smallest eigenvalue of B K found so far (a Ritz value); at most 1.
  double smallest_eigenvalue() const { return smallest_; }
  /// Starts with the eigenvalue that an earlier solve with the same K and B has found, so that a residual
  /// tells the error before the first step.
  void begin_with(double smallest) {
    smallest_ = smallest;
    knows_spectrum_ = true;
  }

  /// The last estimate of the error [1].
  double residual() const { return residual_; }
  /// True if the energy norm is within the tolerance after the last step. The estimate is 1 before there are
  /// enough steps, and where the error does not fall.
  bool is_within(double energy);
  /// The product at a start, or at the start of a round.
  void starts(double product) { first_ = std::max(first_, product); }
  /// True if a residual tells, before the first step, that the energy norm is within the tolerance.
  bool starts_within(double product, double energy);
  /// How a solve ends that has no descent direction, or stops improving. @param product_of_rounding r . B r
  /// of a residual that is pure rounding; none: not compared
  End without_descent(double product, double energy,
                      const std::function<double()>& product_of_rounding = nullptr);

  /// Forgets that a residual was to be confirmed.
  void begin() { is_to_confirm_ = false; }
  /// True if the residual has to be recomputed, because both norms are within a third of the tolerance after
  /// the last step, or because the residual that is carried along may have drifted.
  bool should_recompute(const State& state, std::int64_t iteration);
  /// The verdict on a residual; none: go on.
  std::optional<End> judge(double product, const State& state, std::int64_t iteration,
                           const std::function<double()>& product_of_rounding);

private:
  void find_smallest();
  double rate() const;
  double of_steps(double energy) const;
  double of_residual(double product, double energy) const;
  double worse_of_both(double of_energy, const State& state) const;
  bool is_at_rounding(double product, double energy, const std::function<double()>& of_rounding);

  double tolerance_, residual_ = 1;
  std::vector<double> gains_, products_;         ///< of all steps
  std::vector<double> diagonal_, beside_square_; ///< of Lanczos' matrix since the last restart
  double last_step_ = 0, last_product_ = 0;
  double smallest_ = 1;
  bool knows_spectrum_ = false, is_to_confirm_ = false;
  double first_ = 0, best_ = 0; ///< products: the largest at a start, and the smallest
  std::int64_t best_at_ = 0;    ///< iteration
};

} // namespace maille::deform
