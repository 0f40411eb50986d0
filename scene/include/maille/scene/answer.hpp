#pragma once
/// The form of every method's answer, and how a caller steers a running method.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// How a method ended. Only the first two carry a displacement that answers the whole question.
enum class Status {
  done,           ///< settled within the method's tolerance
  clamped,        ///< settled, but a requested move was impossible within the limits and was cut back
  budget_reached, ///< ended at a limit of iterations or time: a usable state, not the settled one
  interrupted,    ///< the caller asked to stop: a usable state, not the settled one
  refused,        ///< the method cannot carry this scene; `message` says why, no displacement
  failed,         ///< the method tried and could not; `message` says why, no displacement
};
/// `done`, `clamped`, ... as written in tables and JSON.
std::string_view to_string(Status status);
/// True if an answer of that status carries a displacement.
bool has_displacement(Status status);
/// True if it is the method's whole answer: done or clamped.
bool is_converged(Status status);

/// Displacement of every node of the grid [m], along the grid's axes, one array per component of the scene;
/// zero at grid points that are no nodes of the body.
struct Displacement {
  std::vector<std::vector<double>> component; ///< dimension x n_nodes

  Displacement() = default;
  explicit Displacement(const Grid& grid);
  double operator()(int axis, std::int64_t node) const {
    return component[static_cast<std::size_t>(axis)][static_cast<std::size_t>(node)];
  }
  double& operator()(int axis, std::int64_t node) {
    return component[static_cast<std::size_t>(axis)][static_cast<std::size_t>(node)];
  }
};

struct Seconds {
  double setup = 0; ///< everything before the first iteration: limits, mesh, matrix, factor or hierarchy
  double solve = 0;
  double total() const { return setup + solve; }
};

struct Answer {
  std::string method;    ///< limits, literal, sweep, fem_q1, ...
  std::string algorithm; ///< which way the method took, in words: "Dijkstra per component", "CHOLMOD"
  Status status = Status::done;
  std::string message; ///< why it was clamped, refused or failed; empty otherwise
  Displacement displacement;
  /// Prescribed components that limits cut back, whatever the status says.
  std::int64_t n_cut = 0;
  std::int64_t iterations = 0; ///< sweeps, CG iterations, or nodes settled; 0 for direct solvers
  double residual = 0;         ///< estimated relative error of the algebra [1]; 0 where exact
  Seconds seconds;
  /// Force [N] (per metre of thickness in 2D) that keeps each of Scene::prescribed where it is: one value per
  /// entry, same order, acting on the body along that entry's component. Empty where a method knows no
  /// forces.
  std::vector<double> reaction;
  std::optional<double> strain_energy; ///< elastic energy [J] (per metre in 2D); unset where there is none
  /// The part of every cell of the grid in it [J], zero without matter; empty where the method keeps none.
  std::vector<double> cell_energy;
  /// Share of the coarsest lattice's nodes at which nested lattices showed a ratio to go on with [1]; unset
  /// where that was not asked.
  std::optional<double> extrapolated;
  /// Strain [1] and stress [Pa] at every node of the grid, object's frame, XX YY ZZ XY YZ XZ, tensor shear:
  /// recovered, zero where there is no matter. Empty where a method was not asked for them or has none.
  std::vector<std::array<double, 6>> nodal_strain, nodal_stress;
  std::int64_t bytes = 0; ///< memory that the method held at its peak, counted from its arrays
};

/// An answer without displacement that says why.
Answer refusal(std::string method, std::string reason);

/// What a caller may ask of a running method. All members are optional.
struct Control {
  int threads = 1;
  std::optional<double> seconds_budget;
  /// Memory that a lattice method may take [bytes]; unset: what the machine can give, see available_memory().
  std::optional<std::int64_t> bytes_budget;
  std::function<bool()> stop_requested; ///< polled often; true: end with status interrupted
  std::function<void(double fraction, std::string_view what)> progress; ///< called from the calling thread
  bool should_stop() const { return stop_requested && stop_requested(); }
};

/// The largest amount by which a link breaks its limits in a frame (that of an answer: object_frame(scene)),
/// in units of that link's rest length; 0 if none does.
double largest_violation(const Scene& scene, const LinkLimits& limits, const Displacement& displacement,
                         const Frame& frame = {});

} // namespace maille
