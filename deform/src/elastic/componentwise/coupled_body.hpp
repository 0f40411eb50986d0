#pragma once
/// Full elasticity on any body in 1D, 2D and 3D, around the componentwise model's multigrid.

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/model/lattice_elasticity.hpp"

namespace maille::deform {

/// 0 to dimension - 1.
std::vector<int> all_components(const Scene& scene);

/// In float64, cell by cell.
class BodySystem : public CoupledSystem, public FlexibleOperator {
public:
  /// @param task must outlive this
  explicit BodySystem(const CoupledTask& task);
  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task_.team);
  }
  void precondition(const Displacement& residual, Displacement& correction) override {
    preconditioner_.precondition(residual, correction);
  }
  Displacement diagonal() const override { return elasticity_.diagonal(); }

  /// Prescribed values, and where no start is given one from the componentwise model, which knows no more
  /// than each component by itself.
  void prescribe(Displacement& u);
  FlexibleGradients gradients() const;
  std::int64_t held_bytes() const { return elasticity_.bytes() + moduli_.bytes() + preconditioner_.bytes(); }

private:
  const CoupledTask& task_;
  LatticeElasticity elasticity_;
  CellModuli moduli_;
  ComponentwisePreconditioner preconditioner_;
};

} // namespace maille::deform
