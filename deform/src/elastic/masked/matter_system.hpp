#pragma once
/// The operator of a body of any shape and any matter in 3D.

#include "elastic/krylov/coupled_system.hpp"
#include "elastic/masked/matter_gradients.hpp"
#include "elastic/model/lattice_elasticity.hpp"

namespace maille::deform {

/// In float64; directions in float32.
class MatterSystem : public CoupledSystem {
public:
  /// All must outlive this.
  MatterSystem(const Grid& grid, const LatticeElasticity& elasticity, MatterMultigrid& multigrid,
               ThreadTeam& team)
      : grid_(grid), elasticity_(elasticity), multigrid_(multigrid), team_(team) {}

  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }
  bool has_multigrid() const override { return true; }
  std::int64_t bytes() const override { return gradients_ ? gradients_->bytes() : 0; }
  void stiffen(const std::vector<StiffenedLink>& links) override;
  int find_direction(const Displacement& residual, int most, double reduction,
                     const std::function<bool()>& must_stop, Displacement& direction) override;

private:
  template<class Visit>
  void for_each_row(const Visit& visit);
  void take_in(const Displacement& residual);
  void take_over(const float* found, Displacement& direction);

  const Grid& grid_;
  const LatticeElasticity& elasticity_;
  MatterMultigrid& multigrid_;
  ThreadTeam& team_;
  double scale_ = 1;                         ///< residuals are counted in this times the level's unit [m]
  std::optional<MatterGradients> gradients_; ///< once they are needed
};

} // namespace maille::deform
