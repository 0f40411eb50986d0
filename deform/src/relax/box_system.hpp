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
  void stiffen(const std::vector<StiffenedLink>& links) override;
  double precondition(const Displacement& residual, Displacement& correction) override;

private:
  std::size_t in_plane() const;

  BoxMultigrid& multigrid_;
  double unit_;
  double scale_ = 0; ///< residuals are counted in this times unit_ [m]
};

} // namespace maille::deform
