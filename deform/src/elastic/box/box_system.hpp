#pragma once
/// The operator of a box of one material, and conjugate gradients on it.

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/model/lattice_elasticity.hpp"

namespace maille::deform {

/// Residual, correction and image are the fields f, u and r of the finest level. A step is taken when its
/// direction and image are read for the next one.
class BoxGradients : public GradientSpace {
public:
  /// @param multigrid must outlive this
  explicit BoxGradients(BoxMultigrid& multigrid);

  /// Sets the state to 0 and drops pending steps.
  void restart();
  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  float* state() { return state_.data(); }
  float* direction() { return direction_.data(); }
  /// Pending steps.
  BoxSteps& steps() { return steps_; }

private:
  BoxMultigrid& multigrid_;
  PaddedArray state_, direction_;
  BoxSteps steps_;
};

/// The operator in float64, around the multigrid in float32.
class BoxSystem : public ElasticOperator {
public:
  /// @param unit of forces per displacement in the multigrid [N/m]; @param scene, multigrid must outlive this
  BoxSystem(const Scene& scene, BoxMultigrid& multigrid, double unit)
      : scene_(scene), multigrid_(multigrid), unit_(unit) {}
  /// Applies K cell by cell, from differences, in later calls. On a body a thousand times as long as thick,
  /// rounding of sums over nodes is as large as bending.
  void resolve_bending() { by_cells_.emplace(scene_, multigrid_.team()); }

  void apply(const Displacement& u, Displacement& forces) override;
  void precondition(const Displacement& residual, Displacement& correction) override;

private:
  const Scene& scene_;
  BoxMultigrid& multigrid_;
  double unit_;
  std::optional<LatticeElasticity> by_cells_; ///< see resolve_bending()
};

} // namespace maille::deform
