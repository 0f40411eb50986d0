#pragma once
/// The operator of a box of one material, and conjugate gradients on it.

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/model/lattice_elasticity.hpp"

namespace maille::deform {

/// Residual, correction and image are the fields f, u and r of the multigrid's finest level. Steps are taken
/// when their direction and its image are read for the next one.
class BoxGradients : public GradientSpace {
public:
  /// @param multigrid must outlive this
  explicit BoxGradients(BoxMultigrid& multigrid);

  /// The state is nothing, and no step is left to be taken.
  void restart();
  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  float* state() { return state_.data(); }
  float* direction() { return direction_.data(); }
  /// Not taken yet.
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
  /// Applies K cell by cell, from differences, from now on. On a body a thousand times as long as thick the
  /// rounding of sums over nodes would be as much as bending.
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
