#pragma once
/// Linear elasticity on a 3D body of any shape and material: operator and solver.
///
/// Solves K u = f at free components. K is the lattice stiffness (LatticeElasticity), f the loads, u is
/// prescribed elsewhere. Mixed precision: MixedSolver computes residuals and sums in float64 from the
/// whole state; conjugate gradients in float32 around one multigrid cycle (MaskedMultigrid) correct it round
/// by round.
///
/// Storage: fields of the finest level have slots only for rows that touch the body (MaskedRows). A
/// displacement is dense, [component][node]. For large bodies without a cache the dense u is built only after
/// the last round: until then `earlier_` holds the corrections of the rounds in float32, and residuals are
/// formed plane by plane (put_planes). An empty u marks this state.
///
/// MaskedBody holds operator and hierarchy and can be cached for the next question: it accepts a few other
/// fixed components, and materials that changed by at most a factor of 2.
///
/// Exact: residual, energy and reactions, within float64 rounding. Heuristic: the reuse of the smallest
/// eigenvalue.
/// Ranks share a body by slabs of planes (Slabs); a rank's fields are valid in its own planes.

#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/krylov/mixed_solver.hpp"
#include "elastic/masked/masked_multigrid.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace maille::deform {

/// State and residuals in float64, directions in float32.
class MaskedSystem : public ElasticOperator {
public:
  /// All must outlive this.
  MaskedSystem(const Grid& grid, const LatticeElasticity& elasticity, MaskedMultigrid& multigrid,
               ThreadTeam& team)
      : grid_(grid), elasticity_(elasticity), multigrid_(multigrid), team_(team) {}

  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }
  void precondition(const Displacement& residual, Displacement& correction) override;
  /// direction = about K^-1 residual, by conjugate gradients in float32, until r . B r has fallen by
  /// `reduction`, at most `most` iterations. @pre as precondition()
  void find_direction(const Displacement& residual, int most, double reduction, Displacement& direction);

private:
  void load_residual(const Displacement& residual);
  void store_correction(const float* found, Displacement& direction);

  const Grid& grid_;
  const LatticeElasticity& elasticity_;
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  double scale_ = 1;                         ///< unit of residuals over the unit of the level [m]
  std::optional<MaskedGradients> gradients_; ///< once they are needed
};

/// Largest contrast of the stiffness of any material of a scene; see relaxation_steps().
double largest_contrast(const Scene& scene);

/// Cached set-up of a body: its operator, and a hierarchy for the components that were fixed when it was
/// built.
class MaskedBody : public KeptHierarchy {
public:
  /// @param scene its matter counts; it and the team must outlive this
  /// @param all see Slabs
  MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
             Communicator* all = nullptr);

  /// Records the fixed components that later questions are compared with. For cached bodies.
  void remember_fixed(const std::vector<Prescribed>& prescribed);
  /// Adapts to other fixed components.
  /// @return false if a new hierarchy is better, because too many fixed components differ
  bool adopt_fixed(const std::vector<Prescribed>& prescribed);
  /// True if it was built for exactly these fixed components.
  bool is_made_for(const std::vector<Prescribed>& prescribed);
  /// Fixes other components without that check.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  bool adopt_materials(double ratio) override;
  /// Frees all but elasticity and state, after the last solve.
  void release();

private:
  MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
             const Slabs& slabs);

public:
  LatticeElasticity elasticity;
  MaskedMultigrid multigrid;
  MaskedGradients fields;
  double smallest_eigenvalue = 0; ///< of the preconditioned operator, as estimated; 0: unknown

private:
  FixedMask made_for_, fixed_; ///< see remember_fixed()
};

/// MixedSolver around one multigrid cycle. If nothing is cached, the displacement is built after the
/// hierarchy is freed, so that a large body never holds both.
///
/// Same bits for any number of threads.
class MaskedSolver : public MixedSolver {
public:
  /// @param task of a scene in 3D
  explicit MaskedSolver(const CoupledTask& task);

  const char* algorithm() const override {
    return "lattice elasticity, conjugate gradients around multigrid of the body's pieces";
  }
  MaskedSystem& system() override { return system_; }
  CoupledRound solve(Displacement& u, Answer& answer) override;
  void find_energy_and_reactions(const Displacement& u, Answer& answer) override;
  const Slabs& slabs() const { return body_.multigrid.finest().slabs(); }

private:
  /// The start, in the planes that a rank stores.
  Displacement initial_part() const;
  GradientSpace& space() override { return body_.fields; }
  Residual begin_round(const Displacement& u, double scale) override;
  double work_of_loads() override;
  void finish_round(Displacement& u, CoupledRound end) override;
  /// Correction of one round.
  struct Round {
    double scale = 0;
    AlignedArray<float> state; ///< as fields
  };
  void add(double scale, const float* state, std::size_t component, int n, double* to) const;
  void add_earlier_rounds(std::int64_t at, std::size_t component, int n, double* to) const;
  bool put_planes(int first_plane, int end_plane, const std::array<double*, 3>& to) const;
  template<class Visit>
  void find_forces(const Displacement& u, const Visit& visit);

  std::int64_t first_node() const { ///< of displacements
    return task_.scene.specimen.grid.node({0, 0, slabs().layers().first});
  }
  static MaskedBody& body_of(const CoupledTask& task, std::unique_ptr<MaskedBody>& own);

  std::unique_ptr<MaskedBody> own_; ///< where nothing is kept
  MaskedBody& body_;
  MaskedSystem system_;
  std::vector<std::int32_t> by_node_; ///< what is prescribed, in the order of nodes
  std::vector<Round> earlier_;        ///< where there is no displacement yet
  std::vector<double> energies_;      ///< of planes of nodes
  double energy_ = 0;                 ///< u . K u at the last evaluation of forces [J]
  List<double> held_;                 ///< forces on the scene's prescribed components then [N]
  bool are_forces_of_state_ = false;  ///< no step was taken since then
};

} // namespace maille::deform
