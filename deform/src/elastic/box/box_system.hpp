#pragma once
/// The operator of a box of one material, and conjugate gradients on it.

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_system.hpp"

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

/// The operator in float64.
class BoxSystem : public CoupledSystem {
public:
  /// @param unit of forces per displacement in the multigrid [N/m]; @param multigrid must outlive this
  BoxSystem(BoxMultigrid& multigrid, double unit) : multigrid_(multigrid), unit_(unit) {}
  void apply(const Displacement& u, Displacement& forces) override;
  void apply_at(const std::vector<Prescribed>& prescribed, const Displacement& u,
                Displacement& forces) override;
  bool finds_directions() const override { return true; }
  void set_penalties(const List<PenaltyLink>& links) override;
  int find_direction(const Displacement& residual, int most, double reduction,
                     const std::function<bool()>& must_stop, Displacement& direction) override;
  bool keeps_directions() const override { return true; }
  KeptDirection keep_direction(const Displacement& residual, int most, double reduction,
                               const std::function<bool()>& must_stop) override;
  double kept(int component, std::size_t node) const override {
    const BoxLevel& level = multigrid_.finest();
    const auto nx = static_cast<unsigned>(level.A().nodes[0]), ny = static_cast<unsigned>(level.A().nodes[1]);
    const auto i = static_cast<unsigned>(node), row = i / nx;
    return scale_ * double{kept_[level.offset(component, static_cast<int>(i % nx), static_cast<int>(row % ny),
                                              static_cast<int>(row / ny))]};
  }
  void move_along_kept(double step, Displacement& u, Displacement& residual) override;
  /// correction = one cycle for (K + penalties) correction = residual. @return residual . correction [J]
  /// @pre as find_direction
  double precondition(const Displacement& residual, Displacement& correction);

private:
  void take_in(const Displacement& residual);
  void take_over(const BoxSteps& steps, const float* p, float* x, Displacement& direction);
  BoxGradients& gradients();
  void apply_to_plane(int z, const Displacement& u, Displacement& forces);
  BoxMultigrid& multigrid_;
  double unit_;
  double scale_ = 0;                      ///< residuals are counted in this times unit_ [m]
  std::optional<BoxGradients> gradients_; ///< once they are needed
  const float* kept_ = nullptr;           ///< direction; its image is in the multigrid
};

} // namespace maille::deform
