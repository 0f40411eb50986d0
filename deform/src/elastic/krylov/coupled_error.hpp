#pragma once
/// How far conjugate gradients are from the answer.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace maille::deform {

/// The error in the energy norm, from two sides: from the energies that the last steps brought, which tells
/// where convergence is even, and from the residual and the smallest eigenvalue that the steps have met (a
/// Ritz value of the preconditioned operator), which tells of an error that brings little energy because the
/// preconditioner hardly sees it: the bending of slender and thin bodies.
///
/// Source  Strakos and Tichy 2002, equation 4.4 (energies); Meurant and Tichy 2013, section 2 (Ritz values
///         from the coefficients)
class CoupledError {
public:
  /// A step of conjugate gradients: `step` along a direction whose residual r had r . B r = product, counted
  /// in scale^2.
  void add(double step, double product, double scale = 1);
  /// The residual was found anew, or the directions forgotten: products of before and after make no
  /// coefficients.
  void restart();
  /// Error of the present state, relative to `energy` of the answer (u . K u); 1 before there are enough
  /// steps, and where the error does not fall.
  double relative_to(double energy) const;
  /// The same for a residual that was recomputed after those steps, with r . B r = product.
  double of_residual(double product, double energy) const;
  /// Smallest eigenvalue of the preconditioned operator found so far (a Ritz value); at most 1.
  double smallest_eigenvalue() const { return smallest_; }
  /// Convergence rate: reduction of r . B r per step over the last steps; 1 without convergence.
  double rate() const;
  /// Starts with an eigenvalue found earlier, by the same operator and preconditioner.
  void begin_with(double smallest) { smallest_ = smallest; }
  bool is_empty() const { return gains_.empty(); }

private:
  /// Steps after which the energy that they brought says how far the state was from the answer.
  static constexpr std::size_t delay = 3;
  static constexpr double least_rate = 0.02; ///< smaller measured rates are not trusted
  void find_smallest();

  std::vector<double> gains_, products_;         ///< of all steps
  std::vector<double> diagonal_, beside_square_; ///< of Lanczos' matrix since the last restart
  double last_step_ = 0, last_product_ = 0;
  double smallest_ = 1;
};

/// Whether what is left of the error is no more than rounding leaves, where it no longer falls. If it is
/// more, a preconditioner in float32 has met matter whose moduli it cannot tell from nothing. @param left r .
/// B r; @param energy of the state, or of its first error, whichever is more; both in the same unit
inline bool is_left_by_rounding(double left, double energy) {
  constexpr double told_from_rounding = 1e-6; ///< in the energy norm
  return std::abs(left) <= told_from_rounding * told_from_rounding * energy;
}

} // namespace maille::deform
