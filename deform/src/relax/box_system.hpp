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

private:
  std::size_t in_plane() const;

  BoxMultigrid& multigrid_;
  double unit_;
};

} // namespace maille::deform
