#pragma once
/// The fields of conjugate gradients on a body of any shape, in float32.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/masked/masked_multigrid.hpp"

namespace maille::deform {

/// Residual, correction and image are the fields f, u and r of the multigrid.
class MaskedGradients : public GradientSpace {
public:
  /// Both must outlive this.
  MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team);

  /// The state is nothing.
  void restart();
  double precondition() override { return multigrid_.precondition(); }
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  const float* state() const { return state_.data(); }
  const float* direction() const { return direction_.data(); }
  std::int64_t bytes() const { return static_cast<std::int64_t>(state_.bytes() + direction_.bytes()); }

private:
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  AlignedArray<float> state_, direction_;
};

} // namespace maille::deform
