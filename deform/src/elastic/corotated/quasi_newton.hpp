#pragma once
/// What the last steps of a descent say about the curvature of an energy.

#include "elastic/krylov/field_sums.hpp"

#include <deque>
#include <functional>

namespace maille::deform {

/// Limited-memory BFGS around a preconditioner. Its direction leads downhill whatever the energy is, for only
/// steps along which the energy curves upwards are remembered.
///
/// Source  Nocedal 1980 (Math. Comput. 35); with the multigrid of a constant operator in its middle: Liu,
///         Bouaziz, Kavan 2017 (ACM TOG 36), "Quasi-Newton methods for real-time simulation of hyperelastic
///         materials". docs/theory.md, section 4, accelerates local and global steps by Anderson's method,
///         which mixes the same past steps but minimises no energy
class QuasiNewton {
public:
  QuasiNewton(const Grid& grid, FieldSums& sums) : grid_(grid), sums_(sums) {}

  /// Turns `field`, the gradient where components are free and zero elsewhere, into minus a direction.
  /// @param precondition (residual, changed; correction)
  void apply(Displacement& field, const std::function<void(Displacement&, Displacement&)>& precondition);
  /// Remembers a step and what it did to the gradient, if energy curves upwards along it. @param slope of the
  /// energy along the whole step at its beginning, negative
  void remember(Displacement step, Displacement change_of_gradient, double slope);
  void forget() { pairs_.clear(); }
  bool is_empty() const { return pairs_.empty(); }
  static std::int64_t bytes_for(const Grid& grid) {
    return static_cast<std::int64_t>(most_pairs * 2 + 1) * grid.dimension() * grid.n_nodes() *
           static_cast<std::int64_t>(sizeof(double));
  }

private:
  struct Pair {
    Displacement step, change;
    double inverse = 0; ///< of step . change
  };
  static constexpr std::size_t most_pairs = 6;
  static constexpr double least_curvature = 0.05; ///< of the slope

  Grid grid_;
  FieldSums& sums_;
  std::deque<Pair> pairs_; ///< oldest first
};

} // namespace maille::deform
