#pragma once
/// Elasticity on a body of any shape and any material in 3D: its operator, and its solver.

#include "elastic/direct/direct_system.hpp"
#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/krylov/mixed_gradients.hpp"
#include "elastic/masked/masked_multigrid.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace maille::deform {

/// In float64; directions in float32.
class MaskedSystem : public CoupledSystem, public FlexibleOperator {
public:
  /// All must outlive this.
  MaskedSystem(const Grid& grid, const LatticeElasticity& elasticity, MaskedMultigrid& multigrid,
               ThreadTeam& team)
      : grid_(grid), elasticity_(elasticity), multigrid_(multigrid), team_(team) {}

  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }
  bool finds_directions() const override { return true; }
  void set_penalties(const List<PenaltyLink>& links) override;
  /// correction = one cycle for (K + penalties) correction = residual, at nodes of matter; beside them it
  /// stays what it is. @pre as find_direction
  void precondition(const Displacement& residual, Displacement& correction) override;
  Displacement diagonal() const override { return elasticity_.diagonal(); }
  int find_direction(const Displacement& residual, int most, double reduction,
                     const std::function<bool()>& must_stop, Displacement& direction) override;

private:
  void take_in(const Displacement& residual);
  void take_over(const float* found, Displacement& direction);

  const Grid& grid_;
  const LatticeElasticity& elasticity_;
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  double scale_ = 1;                         ///< residuals are counted in this times the level's unit [m]
  std::optional<MaskedGradients> gradients_; ///< once they are needed
};

/// Of the stiffness of any material of a scene; see relaxation_steps().
double largest_contrast(const Scene& scene);

/// What stands in memory for a body: its operator, and a hierarchy for what was fixed when it was made.
class MaskedBody : public KeptHierarchy {
public:
  /// @param scene its matter counts; it and the team must outlive this
  /// @param all see Slabs
  MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
             Communicator* all = nullptr);

  /// Makes it one for a question that fixes other components.
  /// @return false where it is better made anew: too much is fixed that was not, or the other way round
  bool take_fixed(const std::vector<Prescribed>& prescribed);
  /// Whether it was made for just these, and nothing else was ever fixed.
  bool is_made_for(const std::vector<Prescribed>& prescribed);
  /// Fixes others all the same.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  bool take_materials(double ratio) override;
  /// No other question comes: elasticity and the state are left.
  void release();

private:
  MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
             const Slabs& slabs);

public:
  LatticeElasticity elasticity;
  MaskedMultigrid multigrid;
  MaskedGradients fields;
  double smallest_eigenvalue = 0; ///< of the preconditioned operator, as it was met; 0: not yet

private:
  std::vector<FixedComponent> made_for_, fixed_;
};

/// MixedGradients around one multigrid cycle. The displacement is made when the fields that found it are
/// gone, where no other question comes: of large bodies neither has to find room beside the other.
///
/// Same bits for any number of threads.
class MaskedSolver : private MixedState {
public:
  /// @param task of a scene in 3D
  explicit MaskedSolver(const CoupledTask& task);

  /// Takes u, in which prescribed components have their values, to the answer, if it is not stopped and does
  /// not stall. An empty one begins at rest, but for what is prescribed.
  CoupledRound solve(Displacement& u, Answer& answer);
  /// What may have the answer where solve() has stalled; null: nothing.
  std::unique_ptr<DirectSystem> take_direct();
  /// Energy, and what holds every prescribed component of the scene there.
  void find_energy_and_reactions(const Displacement& u, Answer& answer);
  MaskedMultigrid& multigrid() { return body_.multigrid; }
  const Slabs& slabs() const { return body_.multigrid.finest().slabs(); }
  /// Where to begin, of the planes that a rank knows.
  Displacement initial_part() const;
  const LatticeElasticity& elasticity() const { return body_.elasticity; }

private:
  Residual begin_round(const Displacement& u, double scale) override;
  double work_of_loads() override;
  void finish_round(Displacement& u, bool is_last) override;
  bool gives_up(std::int64_t iterations) override;
  /// What a round has found.
  struct Round {
    double scale = 0;
    AlignedArray<float> state; ///< as fields
  };
  void add(double scale, const float* state, std::size_t component, int n, double* to) const;
  void add_earlier_rounds(std::int64_t at, std::size_t component, int n, double* to) const;
  bool put_planes(int first_plane, int end_plane, const std::array<double*, 3>& to) const;
  template<class Visit>
  void for_each_row(const Visit& visit);
  template<class Visit>
  void find_forces(const Displacement& u, const Visit& visit);

  std::int64_t first_node() const { ///< of displacements
    return task_.scene.specimen.grid.node({0, 0, slabs().layers().first});
  }
  static MaskedBody& body_of(const CoupledTask& task, std::unique_ptr<MaskedBody>& own);

  const CoupledTask& task_;
  std::unique_ptr<MaskedBody> own_; ///< where nothing is kept
  MaskedBody& body_;
  Loads loads_;
  std::unique_ptr<MixedGradients> gradients_;
  std::vector<std::int32_t> by_node_; ///< what is prescribed, in the order of nodes
  std::vector<Round> earlier_;        ///< where there is no displacement yet
  std::vector<double> energies_;      ///< of planes of nodes
  double energy_ = 0;                 ///< u . K u when forces were found the last time [J]
  List<double> held_;                 ///< what pulled at the scene's prescribed components then [N]
  bool are_forces_of_state_ = false;  ///< no step was taken since they were found
  std::optional<std::unique_ptr<DirectSystem>> direct_; ///< null: may not be made; nothing: not asked yet
};

} // namespace maille::deform
