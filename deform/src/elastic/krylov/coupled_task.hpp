#pragma once
/// What every solver of `coupled` is asked.
///
/// A task is one question: the scene, values to prescribe, limits that bind or none, a start, and a cache of
/// earlier questions. solve_on_ladder() finds the elastic state; solve_within_limits() enforces limits on it.
/// Solvers pass the task on unchanged; ties, coarser bodies and increments make tasks of their own.

#include "control/method.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

namespace maille::deform {

/// Nodal forces of a scene's loads, dense, per component; empty: none along it [N].
using Loads = std::array<List<double>, 3>;
inline Loads loads_of(const Scene& scene) {
  Loads loads;
  for (int c = 0; c < scene.dimension() && scene.has_loads(); ++c)
    loads[c] = nodal_forces(scene, c);
  return loads;
}

/// Euclidean product over all entries, in their order.
inline double product(const Displacement& a, const Displacement& b) {
  const auto of_a = a.values(), of_b = b.values();
  return std::inner_product(of_a.begin(), of_a.end(), of_b.begin(), 0.0);
}

/// Reactions of the scene's prescribed components: the forces that hold the state, less the loads [N].
inline std::vector<double> reactions_of(const Scene& scene, const Loads& loads, const Displacement& forces) {
  std::vector<double> reactions;
  for (const Prescribed& p : scene.prescribed) {
    const auto& along = loads[p.component];
    reactions.push_back(forces(p.component, p.node) - (along.empty() ? 0 : along[p.node]));
  }
  return reactions;
}

class KeptBody;

struct CoupledTask {
  const Scene& scene;
  const Control& control;
  const std::vector<Prescribed>& prescribed; ///< the scene's, cut back where limits ask for it
  ThreadTeam& team;
  const Clock& clock;
  std::function<bool()> must_stop;
  const LinkLimits* limits = nullptr; ///< null: none bind
  /// Start, on the scene's grid; prescribed components are set in it. Null: the solver's own start.
  const Displacement* start = nullptr;
  /// Cache of earlier questions about this body, updated for later ones. Null: no cache.
  KeptBody* kept = nullptr;

  /// Shows how many of the tolerance's orders of magnitude the estimated error has fallen.
  void show_progress(double residual) const {
    const double orders = std::log(residual) / std::log(scene.relaxation.tolerance);
    if (control.progress)
      control.progress(std::clamp(orders, 0.0, 0.99), "solving");
  }
  /// The start, or rest, with what is prescribed.
  Displacement initial_state() const {
    Displacement u = start != nullptr ? *start : Displacement(scene.specimen.grid);
    for (const Prescribed& p : prescribed)
      u(p.component, p.node) = p.value;
    return u;
  }
};

/// How a round of conjugate gradients ended. finished: within tolerance, or at rounding level; used_up: the
/// residual has to be recomputed; stopped: by the caller or the limit of iterations; stalled: the error
/// stagnates above rounding level.
enum class CoupledRound { finished, used_up, stopped, stalled };

/// Each fills in displacement, iterations, residual, strain energy, setup time and algorithm, and the
/// reactions if it came to the end. @return false if it was stopped, or gave up: with status failed and a
/// message where it has no answer
using CoupledAlgorithm = bool(const CoupledTask& task, Answer& answer);

/// Any body in 1D, 2D and 3D: conjugate gradients around the componentwise model's multigrid. In 3D the
/// tests' oracle.
CoupledAlgorithm solve_coupled_body;
/// The one for the scene: solve_within_limits, or that of bodies that slide.
CoupledAlgorithm& coupled_algorithm(const Scene& scene);
/// Number of threads worth using for a scene, of those that the caller allows.
int elastic_threads(const Scene& scene, const Control& control);
/// Why full elasticity has no answer to the scene; empty if it has.
std::string reason_to_refuse_coupled(const Scene& scene);

/// True if every cell of a 3D grid holds the same matter, turned the same way, and it is not thin.
bool is_uniform_box(const Scene& scene);
/// Give up after this many iterations of a solve, which converge or stagnate earlier.
constexpr int most_coupled_iterations = 5000;

} // namespace maille::deform
