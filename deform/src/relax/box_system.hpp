#pragma once
/// The operator of a box of one material.

#include "relax/box_multigrid.hpp"
#include "relax/coupled_system.hpp"

namespace maille::deform {

/// In float64.
class BoxSystem : public CoupledSystem {
public:
  /// @param unit of forces per displacement in the multigrid [N/m]; @param multigrid must outlive this
  BoxSystem(BoxMultigrid& multigrid, double unit) : multigrid_(multigrid), unit_(unit) {}
  void apply(const Displacement& u, Displacement& forces) override;
  bool has_multigrid() const override { return true; }
  std::int64_t bytes() const override {
    return static_cast<std::int64_t>(state_.bytes() + direction_.bytes());
  }
  void stiffen(const std::vector<StiffenedLink>& links) override;
  Direction find_direction(const Displacement& residual, int most, double reduction,
                           const std::function<bool()>& must_stop, Displacement& direction,
                           Displacement* image) override;
  /// correction = one cycle for (K + stiffened links) correction = residual. @return residual . correction [J]
  double precondition(const Displacement& residual, Displacement& correction);

private:
  std::size_t in_plane() const;
  void take_in(const Displacement& residual);
  void take_over(const BoxSteps& steps, const float* p, float* x, Displacement& direction,
                 Displacement* image);
  int iterate(int most, double reduction, const std::function<bool()>& must_stop);

  BoxMultigrid& multigrid_;
  double unit_;
  double scale_ = 0;              ///< residuals are counted in this times unit_ [m]
  PaddedArray state_, direction_; ///< of conjugate gradients, once they are needed
  BoxSteps steps_;                ///< of them, not taken yet
};

} // namespace maille::deform
