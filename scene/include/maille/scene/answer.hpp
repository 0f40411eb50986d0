#pragma once
/// The answer to a scene: what every method returns, whichever model it solves.
///
/// An Answer holds one displacement per node [m, object's frame] with all zeros where there is no matter, a
/// Status that says whether the displacement answers the whole question, reactions where the model has
/// stress, and what the answer cost. Control steers a running method: tolerance, budgets, threads, a stop
/// request. compare() measures how far two answers lie apart, over the nodes that are free.

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

/// In the order of every list of methods. Those up to `coupled` are deform's, the others come with fem_ref
/// and studies.
enum class Method {
  limits,   ///< neighbour limits alone: the least movement, by the cheapest way
  dijkstra, ///< the same by shortest paths: its oracle
  literal,  ///< Gibson's propagation of 1997, as published
  sweep,    ///< the relaxation of 1995, node by node
  relaxed,  ///< the same model with the material's weights, by multigrid
  coupled,  ///< full anisotropic elasticity on the lattice
  fem_q1,   ///< linear finite elements (deal.II)
  fem_q2,   ///< quadratic finite elements (deal.II)
  calculix, ///< the program CalculiX, where it is installed
};

inline constexpr std::array<Method, 9> every_method{Method::limits, Method::dijkstra, Method::literal,
                                                    Method::sweep,  Method::relaxed,  Method::coupled,
                                                    Method::fem_q1, Method::fem_q2,   Method::calculix};

/// `limits`, `fem_q1`, ... as on the command line and in Answer::method.
/// @param method one of every_method
std::string_view to_string(Method method);
/// The method of exactly that name; nothing for another name.
std::optional<Method> method_from_string(std::string_view name);
/// False of methods that obey limits or relax by the rule of 1995: what they call displacement is in balance
/// with no stress.
bool has_stress(std::string_view method);

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

/// A node on a sliding border, as the cells of one label have it.
struct SplitNode {
  std::int64_t node = 0;
  std::int32_t label = 0;
  Vec3 displacement{}; ///< [m]
};

/// What rubs on a border that slides with friction; sums of sizes over its nodes.
struct RubbingBorder {
  std::int32_t one = 0, other = 0; ///< labels
  double pressed = 0;              ///< along the normals where they press [N]
  double rubbed = 0;               ///< along the border, at most friction times `pressed` [N]
  double slipping = 0;             ///< share of the nodes that slip [1]
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
  /// Elastic energy [J] (per metre in 2D); unset if the method has no energy.
  std::optional<double> strain_energy;
  /// The part of every cell of the grid in it [J], zero without matter; empty where the method keeps none.
  std::vector<double> cell_energy;
  /// Mean strain of every cell of the grid by the method's own interpolation, as CellFields has it, where
  /// that is not what the displacement of the corners says: of quadratic elements, also where they were
  /// brought over from a finer lattice. Else empty.
  std::vector<std::array<double, 6>> cell_strain;
  /// For sliding borders: nodes by label, sorted by node and label; `displacement` has the mean of a node's
  /// entries.
  std::vector<SplitNode> split;
  /// Force that presses together the nodes of every tie of Scene::tied with a normal [N], < 0: pulls; empty
  /// where no tie has friction.
  std::vector<double> tie_press;
  std::vector<RubbingBorder> rubbing; ///< of every border with friction
  /// Share of the coarsest lattice's nodes at which nested lattices showed a ratio to go on with [1]; unset
  /// where that was not asked.
  std::optional<double> extrapolated;
  /// Strain [1] and stress [Pa] at every node of the grid, object's frame, XX YY ZZ XY YZ XZ, tensor shear:
  /// recovered, zero where there is no matter. Empty where a method was not asked for them or has none.
  std::vector<std::array<double, 6>> nodal_strain, nodal_stress;
  std::int64_t bytes = 0; ///< memory that the method held at its peak, as its arena counted
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
  /// Ranks that are asked the same and answer together (see deform::is_for_all_ranks); null: this process
  /// alone. The first has the answer; it says when to stop.
  Communicator* communicator = nullptr;
  bool should_stop() const { return stop_requested && stop_requested(); }
};

/// The largest amount by which a link breaks its limits in a frame (that of an answer: object_frame(scene)),
/// in units of that link's rest length; 0 if none does.
double largest_violation(const Scene& scene, const LinkLimits& limits, const Displacement& displacement,
                         const Frame& frame = {});

/// Norms of u - r over the nodes without a fixed or moved component; all 0 without such nodes. The relative
/// norms are infinite where r is zero and u is not.
struct ErrorNorms {
  double relative_l2 = 0;  ///< |u-r|_2 / |r|_2
  double relative_max = 0; ///< max |u-r| / max |r|, Euclidean length per node
  double rms = 0;          ///< sqrt(mean |u-r|^2 per node) [m]
};

/// @pre both hold a displacement on the scene's grid
ErrorNorms compare(const Scene& scene, const Displacement& answer, const Displacement& reference);

} // namespace maille
