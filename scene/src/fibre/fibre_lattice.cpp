#include "maille/scene/fibre/fibre_field.hpp"

#include "cell_values.hpp"
#include "geometry/pieces.hpp"
#include "geometry/turned_lattice.hpp"
#include "maille/base/arena.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace maille {

using reader::TurnedLattice;

namespace {

constexpr double least_agreement = 0.6;
constexpr double rounding = TurnedLattice::rounding;

/// Prescribed components at one node of the scene.
struct NodeConditions {
  unsigned mask = 0, held = 0; ///< bits of components
  Vec3 value{};
};

std::vector<NodeConditions> conditions_by_node(const Scene& scene) {
  std::vector<NodeConditions> all(scene.specimen.grid.n_nodes());
  for (const Prescribed& p : scene.prescribed) {
    NodeConditions& node = all[p.node];
    node.mask |= 1U << p.component;
    node.held |= p.held ? 1U << p.component : 0U;
    node.value[p.component] = p.value;
  }
  return all;
}

/// Index of the first turn that prescribes a node; -1 if none exists.
std::vector<int> turns_by_node(const Scene& scene) {
  std::vector<int> turn(scene.specimen.grid.n_nodes(), -1);
  for (std::size_t t = 0; t < scene.turns.size(); ++t)
    for (const std::int64_t node : scene.turns[t].nodes)
      if (int& entry = turn[node]; entry < 0)
        entry = static_cast<int>(t);
  return turn;
}

/// For each node of the rotated body: the scene's nearest node, if it has conditions; else -1.
std::vector<std::int64_t> sources(const TurnedLattice& lattice, const Specimen& body,
                                  const std::vector<NodeConditions>& conditions) {
  std::vector<std::int64_t> source(body.grid.n_nodes(), -1);
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      if (const std::int64_t from = lattice.nearest_node(body, node); conditions[from].mask != 0)
        source[node] = from;
  return source;
}

void turn_turns(const TurnedLattice& lattice, Scene& turned) {
  for (Turn& turn : turned.turns) {
    turn.axis = lattice.to_turned(turn.axis);
    turn.about = lattice.to_turned(turn.about);
    turn.by = lattice.to_turned(turn.by);
    turn.nodes.clear();
  }
}

/// Sets holds and moves on the rotated body. @param source see sources
void prescribe(const TurnedLattice& lattice, const Scene& scene, const std::vector<std::int64_t>& source,
               const std::vector<NodeConditions>& conditions, Scene& turned) {
  const std::vector<int> turn_of = turns_by_node(scene);
  for (std::size_t node = 0; node < source.size(); ++node) {
    const auto number = static_cast<std::int64_t>(node);
    if (source[node] < 0 || !turned.specimen.is_node(turned.specimen.grid.node_at(number)))
      continue;
    const NodeConditions& from = conditions[source[node]];
    Vec3 value = lattice.to_turned(from.value);
    if (const int t = turn_of[source[node]]; t >= 0) {
      Turn& turn = turned.turns[t];
      turn.nodes.push_back(number);
      value = turn.displacement(turned.specimen.position(turned.specimen.grid.node_at(number)));
    }
    for (int j = 0; j < scene.dimension(); ++j)
      if (lattice.share(from.mask, j) > 0.5)
        turned.prescribed.push_back({number, j, value[j], lattice.share(from.held, j) > 1 - rounding});
  }
  std::ranges::sort(turned.prescribed, {}, [](const Prescribed& p) {
    return std::pair{p.component, p.node};
  });
}

/// True if the rotation maps jointly prescribed axes to axes of the lattice.
bool keeps_axes_apart(const TurnedLattice& lattice, const NodeConditions& node, int dimension) {
  for (int j = 0; j < dimension; ++j)
    for (const unsigned mask : {node.mask, node.held})
      if (const double share = lattice.share(mask, j); share > rounding && share < 1 - rounding)
        return false;
  return true;
}

/// Connected nodes with the same kind of condition, reachable from `start`; marks them as visited.
std::vector<std::int64_t> cluster_of(const Grid& grid, const std::vector<NodeConditions>& conditions,
                                     std::int64_t start, std::vector<bool>& is_seen) {
  std::vector<std::int64_t> cluster{start};
  is_seen[start] = true;
  for (std::size_t next = 0; next < cluster.size(); ++next) {
    const Index3 at = grid.node_at(cluster[next]);
    const NodeConditions& here = conditions[cluster[next]];
    for (int way = 0; way < 27; ++way) {
      const Index3 beside{at[0] + way % 3 - 1, at[1] + way / 3 % 3 - 1, at[2] + way / 9 - 1};
      if (!grid.has_node(beside))
        continue;
      const auto node = static_cast<std::size_t>(grid.node(beside));
      if (!is_seen[node] && conditions[node].mask == here.mask && conditions[node].held == here.held) {
        is_seen[node] = true;
        cluster.push_back(static_cast<std::int64_t>(node));
      }
    }
  }
  return cluster;
}

/// True if every patch of holds and moves has a node of the rotated body. @param source see sources
bool is_every_patch_met(const Grid& grid, const std::vector<NodeConditions>& conditions,
                        const std::vector<std::int64_t>& source) {
  std::vector<bool> is_met(conditions.size(), false), is_seen(conditions.size(), false);
  for (const std::int64_t from : source)
    if (from >= 0)
      is_met[from] = true;
  for (std::size_t node = 0; node < conditions.size(); ++node) {
    if (conditions[node].mask == 0 || is_seen[node])
      continue;
    const auto cluster = cluster_of(grid, conditions, static_cast<std::int64_t>(node), is_seen);
    if (std::ranges::none_of(cluster, [&](std::int64_t n) { return is_met[n]; }))
      return false;
  }
  return true;
}

/// Nodes of the rotated body that keep pieces in the scene: the held ones; without holds, the moved ones.
std::vector<std::int64_t> anchors_of(const std::vector<NodeConditions>& conditions,
                                     const std::vector<std::int64_t>& source) {
  const bool any_held = std::ranges::any_of(conditions, [](const NodeConditions& n) { return n.held != 0; });
  std::vector<std::int64_t> anchors;
  for (std::size_t node = 0; node < source.size(); ++node)
    if (source[node] >= 0 && (!any_held || conditions[source[node]].held != 0))
      anchors.push_back(static_cast<std::int64_t>(node));
  return anchors;
}

/// Checks memory: a slender oblique body needs a large grid.
std::optional<LatticeRefusal> refusal_for_memory(const TurnedLattice& lattice) {
  Vec3 origin{};
  const Grid grid = lattice.grid(origin);
  const double bytes = static_cast<double>(grid.n_nodes()) * grid.dimension() * sizeof(double);
  if (const auto available = static_cast<double>(available_memory()); bytes > available)
    return LatticeRefusal{
        fmt::format("a turned grid that fits into the {:.0f} MiB of free memory", available / 1048576),
        fmt::format("{} nodes, {:.0f} MiB for one displacement alone", grid.n_nodes(), bytes / 1048576)};
  return std::nullopt;
}

std::optional<LatticeRefusal> refusal_before_turning(const Scene& scene, const Vec3& fibre,
                                                     double agreement) {
  if (scene.dimension() == 1)
    return LatticeRefusal{"a scene of two or three dimensions", "a line, which has nothing to turn"};
  if (!(agreement >= least_agreement))
    return LatticeRefusal{
        "fibres with a common direction",
        fmt::format("a mean direction that holds {:.2f} of them (1: all alike)", agreement)};
  if (scene.dimension() == 2 && std::abs(fibre[2]) > rounding)
    return LatticeRefusal{"fibres in the plane of the scene",
                          fmt::format("a mean direction with z = {:.3g}", fibre[2])};
  if (!scene.springs.empty() || !scene.sliding.empty() || !scene.drives.empty() || !scene.timed.empty())
    return LatticeRefusal{"holds, moves, gravity and contraction alone",
                          "springs, sliding borders, drives or courses of contraction"};
  if (!scene.tractions.empty())
    return LatticeRefusal{"holds, moves, gravity and contraction: a stair has no face for a traction",
                          "a load with traction"};
  return std::nullopt;
}

} // namespace

Vec3 mean_fibre(const Specimen& specimen, double& agreement) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::int64_t cell = 0; cell < specimen.grid.n_cells(); ++cell)
    if (specimen.is_matter(cell)) {
      const Vec3 along = specimen.fibre_of(cell);
      const Eigen::Vector3d f(along[0], along[1], along[2]);
      sum += f * f.transpose();
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum / std::max(sum.trace(), 1e-300));
  agreement = solver.eigenvalues()[2];
  if (specimen.fibres.empty()) { // avoids rounding by the eigenvector
    const double sign = specimen.fibre[0] < 0 ? -1 : 1;
    return {sign * specimen.fibre[0], sign * specimen.fibre[1], sign * specimen.fibre[2]};
  }
  const Eigen::Vector3d f = solver.eigenvectors().col(2);
  const double sign = f.x() < 0 ? -1 : 1;
  return {sign * f.x(), sign * f.y(), sign * f.z()};
}

std::variant<Scene, LatticeRefusal> on_fibre_lattice(const Scene& scene) {
  double agreement = 0;
  const Vec3 fibre = mean_fibre(scene.specimen, agreement);
  if (auto refusal = refusal_before_turning(scene, fibre, agreement))
    return *refusal;
  if (std::hypot(fibre[1], fibre[2]) < rounding)
    return scene;
  const TurnedLattice lattice(scene, fibre);
  if (auto refusal = refusal_for_memory(lattice))
    return *refusal;
  const std::vector<NodeConditions> conditions = conditions_by_node(scene);
  for (const NodeConditions& node : conditions)
    if (!keeps_axes_apart(lattice, node, scene.dimension()))
      return LatticeRefusal{"holds and moves of all axes, or of axes that the turn keeps apart",
                            "a hold or move of single axes, which are none of the turned lattice's"};
  Scene turned = scene;
  turned.prescribed.clear();
  turned.specimen = lattice.turned_body();
  reader::crop_to_matter(turned.specimen);
  turned.gravity = lattice.to_turned(scene.gravity);
  turned.active_stress =
      carried(scene.active_stress, turned.specimen.grid.n_cells(), 0.0,
              [&](std::int64_t cell) { return lattice.cell_at_middle_of(turned.specimen, cell); });
  turn_turns(lattice, turned);
  const std::vector<std::int64_t> source = sources(lattice, turned.specimen, conditions);
  if (!is_every_patch_met(scene.specimen.grid, conditions, source))
    return LatticeRefusal{"holds and moves of regions that the turned lattice has nodes in",
                          "one that holds none of its nodes"};
  const std::int64_t before = turned.specimen.n_matter_cells(),
                     kept = reader::leave_out_loose_pieces(turned, anchors_of(conditions, source));
  if (2 * kept < before)
    return LatticeRefusal{
        "a body that is thick enough across its fibres for a lattice along them, two cells or more",
        fmt::format("one of which {} of {} cells hang together there", kept, before)};
  prescribe(lattice, scene, source, conditions, turned);
  return turned;
}

} // namespace maille
