#pragma once
/// The answer to a scene: the result of every method, for all models.
///
/// An Answer holds one displacement per node [m, object's frame], zero without matter; a Status that tells
/// whether the displacement is complete; reactions if the model has stress; and the cost. Control steers a
/// running method: tolerance, budgets, threads, a stop request. compare() measures the difference of two
/// answers over the free nodes.

#include "maille/base/arena.hpp"
#include "maille/base/communicator.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"

#include <array>
#include <concepts>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// In the order of all lists of methods. Up to `coupled` they are in deform, the others in fem_ref and
/// studies.
enum class Method {
  limits,   ///< neighbour limits alone: least movement, by the cheapest algorithm
  dijkstra, ///< the same by shortest paths: reference for `limits`
  literal,  ///< Gibson's propagation of 1997, as published
  sweep,    ///< the relaxation of 1995, node by node
  relaxed,  ///< the same model with the material's weights, by multigrid
  coupled,  ///< full anisotropic elasticity on the lattice
  fem_q1,   ///< linear finite elements (deal.II)
  fem_q2,   ///< quadratic finite elements (deal.II)
  calculix, ///< the program CalculiX, if installed
};

inline constexpr std::array<Method, 9> every_method{Method::limits, Method::dijkstra, Method::literal,
                                                    Method::sweep,  Method::relaxed,  Method::coupled,
                                                    Method::fem_q1, Method::fem_q2,   Method::calculix};

/// `limits`, `fem_q1`, ... as on the command line and in Answer::method.
/// @param method one of every_method
std::string_view to_string(Method method);
/// The method of that exact name; nothing for another name.
std::optional<Method> method_from_string(std::string_view name);
/// False for methods that obey limits or relax by the rule of 1995: their displacement balances no stress.
bool has_stress(std::string_view method);

/// How a method ended. Only the first two have a complete displacement.
enum class Status {
  done,           ///< converged within the method's tolerance
  clamped,        ///< converged, but an infeasible move was clipped to the limits
  budget_reached, ///< iteration or time limit reached: a usable, not converged state
  interrupted,    ///< stopped by the caller: a usable, not converged state
  refused,        ///< the method does not support this scene; reason in `message`, no displacement
  failed,         ///< the solve failed; reason in `message`, no displacement
};
/// `done`, `clamped`, ... as written in tables and JSON.
std::string_view to_string(Status status);
/// True if answers of that status have a displacement.
bool has_displacement(Status status);
/// True if the answer is complete: done or clamped.
bool is_converged(Status status);

/// Displacement of every node of the grid [m], along the grid's axes; zero at grid points that are no nodes
/// of the body. One block of memory, components slowest: dimension x n_nodes.
class Displacement {
public:
  Displacement() = default;
  /// Zeros, one component per dimension.
  explicit Displacement(const Grid& grid);
  /// Zeros.
  Displacement(std::size_t n_components, std::size_t n_nodes);

  bool empty() const { return values_.empty(); }
  std::size_t n_components() const { return n_components_; }
  std::size_t n_nodes() const { return n_nodes_; }
  std::span<double> values() { return values_; }
  std::span<const double> values() const { return values_; }
  std::span<double> component(std::integral auto b) {
    return values().subspan(static_cast<std::size_t>(b) * n_nodes_, n_nodes_);
  }
  std::span<const double> component(std::integral auto b) const {
    return values().subspan(static_cast<std::size_t>(b) * n_nodes_, n_nodes_);
  }
  double& operator()(std::integral auto axis, std::integral auto node) {
    return values_[static_cast<std::size_t>(axis) * n_nodes_ + static_cast<std::size_t>(node)];
  }
  double operator()(std::integral auto axis, std::integral auto node) const {
    return values_[static_cast<std::size_t>(axis) * n_nodes_ + static_cast<std::size_t>(node)];
  }
  /// All components at a node, 0 along axes that are none of the grid's.
  Vec3 at(std::int64_t node) const;
  bool operator==(const Displacement&) const = default;

private:
  List<double> values_;
  std::size_t n_components_ = 0, n_nodes_ = 0;
};

struct Seconds {
  double setup = 0; ///< everything before the first iteration: limits, mesh, matrix, factor or hierarchy
  double solve = 0;
  double total() const { return setup + solve; }
};

/// A node on a sliding border, with its displacement in the cells of one label.
struct SplitNode {
  std::int64_t node = 0;
  std::int32_t label = 0;
  Vec3 displacement{}; ///< [m]
};

/// Friction on a sliding border; sums of magnitudes over its nodes.
struct RubbingBorder {
  std::int32_t one = 0, other = 0; ///< labels
  double pressed = 0;              ///< normal force, where in compression [N]
  double rubbed = 0;               ///< friction force, at most friction times `pressed` [N]
  double slipping = 0;             ///< share of the nodes that slip [1]
};

struct Answer {
  std::string method;    ///< limits, literal, sweep, fem_q1, ...
  std::string algorithm; ///< in words: "Dijkstra per component", "CHOLMOD"
  Status status = Status::done;
  std::string message; ///< reason for clamped, refused or failed; empty otherwise
  Displacement displacement;
  /// Number of prescribed components that limits clipped, for any status.
  std::int64_t n_cut = 0;
  std::int64_t iterations = 0; ///< sweeps, CG iterations, or processed nodes; 0 for direct solvers
  double residual = 0;         ///< estimated relative solver error [1]; 0 if exact
  Seconds seconds;
  /// Force [N] (per metre of thickness in 2D) that holds each component of Scene::prescribed: one value per
  /// entry, same order, acting on the body along that entry's component. Empty if the method has no forces.
  std::vector<double> reaction;
  /// Elastic energy [J] (per metre in 2D); unset if the method has no energy.
  std::optional<double> strain_energy;
  /// Elastic energy per cell of the grid [J], zero without matter; empty if the method does not store it.
  std::vector<double> cell_energy;
  /// Mean strain of every cell of the grid by the method's own interpolation, in the order of CellFields.
  /// Only if it differs from the strain of the corner displacements: for quadratic elements, also after
  /// transfer from a finer lattice. Else empty.
  std::vector<std::array<double, 6>> cell_strain;
  /// For sliding borders: nodes by label, sorted by node and label; `displacement` stores the mean per node.
  std::vector<SplitNode> split;
  /// Normal force of every tie of Scene::tied with a normal [N], > 0: compression, < 0: tension; empty if no
  /// tie has friction.
  std::vector<double> tie_press;
  std::vector<RubbingBorder> rubbing; ///< of every border with friction
  /// Share of the coarsest lattice's nodes at which nested lattices gave a ratio for extrapolation [1]; unset
  /// if extrapolation was not requested.
  std::optional<double> extrapolated;
  /// Recovered strain [1] and stress [Pa] at every node of the grid, object's frame, XX YY ZZ XY YZ XZ,
  /// tensor shear; zero without matter. Empty if they were not requested or the method has none.
  std::vector<std::array<double, 6>> nodal_strain, nodal_stress;
  std::int64_t bytes = 0; ///< peak memory of the method, as counted by its arena
};

/// An answer with status refused: no displacement; `message` is the reason.
Answer refusal(std::string method, std::string reason);

/// Options of a running method. All members are optional.
struct Control {
  int threads = 1;
  std::optional<double> seconds_budget;
  /// Memory limit of a lattice method [bytes]; unset: the free memory of the machine, see available_memory().
  std::optional<std::int64_t> bytes_budget;
  std::function<bool()> stop_requested; ///< polled often; true: end with status interrupted
  std::function<void(double fraction, std::string_view what)> progress; ///< called from the calling thread
  /// Ranks that solve the same scene together (see deform::is_for_all_ranks); null: this process alone. The
  /// first rank has the answer and decides when to stop.
  Communicator* communicator = nullptr;
  bool should_stop() const { return stop_requested && stop_requested(); }
};

/// Largest violation of a link's limits in a frame (that of an answer: object_frame(scene)), relative to the
/// link's rest length; 0 if all limits hold.
double largest_violation(const Scene& scene, const LinkLimits& limits, const Displacement& displacement,
                         const Frame& frame = {});

/// Norms of u - r over the nodes without a fixed or moved component; all 0 without such nodes. Relative norms
/// are infinite if r is zero and u is not.
struct ErrorNorms {
  double relative_l2 = 0;  ///< |u-r|_2 / |r|_2
  double relative_max = 0; ///< max |u-r| / max |r|, Euclidean length per node
  double rms = 0;          ///< sqrt(mean |u-r|^2 per node) [m]
};

/// @pre both hold a displacement on the scene's grid
ErrorNorms compare(const Scene& scene, const Displacement& answer, const Displacement& reference);

} // namespace maille
