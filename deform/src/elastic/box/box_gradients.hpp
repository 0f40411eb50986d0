#pragma once
/// The fields of conjugate gradients on a box, in float32.

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"

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
  std::int64_t bytes() const { return static_cast<std::int64_t>(state_.bytes() + direction_.bytes()); }

private:
  BoxMultigrid& multigrid_;
  PaddedArray state_, direction_;
  BoxSteps steps_;
};

} // namespace maille::deform
