#include "elastic/corotated/coupled_blocks.hpp"

#include "control/method.hpp"
#include "elastic/corotated/corotated_relaxation.hpp"
#include "maille/scene/block_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Of a link's range, at either end.
constexpr double narrowed = 0.01;
constexpr int sweeps_per_frames = 8, most_frames = 60;

struct BlockLink {
  std::int64_t tail = 0, head = 0;
  std::size_t axis = 0;
  Index3 at{};
  Vec3 low{}, high{};
  Eigen::Matrix3d frame;
};

class BlockProjection {
public:
  BlockProjection(const Scene& scene, const LinkLimits& limits, const std::vector<Prescribed>& prescribed);
  ProjectionInBlocks run(const LinkLimits& limits, Displacement& u);

private:
  void find_frames(const Displacement& u);
  void bring_within(const BlockLink& link, Displacement& u) const;
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }

  const Scene& scene_;
  std::vector<BlockLink> links_;
  std::vector<std::uint8_t> fixed_; ///< per node, bit b for component b
};

BlockProjection::BlockProjection(const Scene& scene, const LinkLimits& limits,
                                 const std::vector<Prescribed>& prescribed)
    : scene_(scene), fixed_(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0) {
  for (const Prescribed& p : prescribed) {
    std::uint8_t& bits = fixed_[static_cast<std::size_t>(p.node)];
    bits = static_cast<std::uint8_t>(bits | 1 << p.component);
  }
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (std::size_t axis = 0; axis < d(); ++axis) {
      const Index3 at = grid.node_at(node);
      if (at[axis] + 1 >= grid.nodes()[axis])
        continue;
      const LinkBounds bounds = limits.bounds(at, static_cast<int>(axis));
      if (bounds.exists)
        links_.push_back({node, node + grid.stride(static_cast<int>(axis)), axis, at, bounds.low, bounds.high,
                          Eigen::Matrix3d::Identity()});
    }
}

void BlockProjection::find_frames(const Displacement& u) {
  const std::vector<Eigen::Quaterniond> rotation = block_rotations(scene_, u);
  for (BlockLink& link : links_) {
    MeanRotation mean;
    scene_.specimen.for_each_cell_at_link(link.at, static_cast<int>(link.axis), [&](std::int64_t cell) {
      mean.add(rotation[static_cast<std::size_t>(cell)]);
    });
    link.frame = mean.value().toRotationMatrix();
  }
}

void BlockProjection::bring_within(const BlockLink& link, Displacement& u) const {
  const Eigen::Vector3d at_rest =
      scene_.specimen.grid.spacing()[link.axis] * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(link.axis));
  const auto tail = static_cast<std::size_t>(link.tail), head = static_cast<std::size_t>(link.head);
  Eigen::Vector3d now = at_rest;
  for (std::size_t b = 0; b < d(); ++b)
    now[static_cast<Eigen::Index>(b)] += u(b, head) - u(b, tail);
  const Eigen::Vector3d change = link.frame.transpose() * now - at_rest;
  Eigen::Vector3d missing = Eigen::Vector3d::Zero();
  for (std::size_t b = 0; b < d(); ++b) {
    const auto i = static_cast<Eigen::Index>(b);
    const double margin = narrowed * (link.high[b] - link.low[b]);
    missing[i] = std::clamp(change[i], link.low[b] + margin, link.high[b] - margin) - change[i];
  }
  if (missing.isZero(0))
    return;
  const Eigen::Vector3d move = link.frame * missing;
  for (std::size_t b = 0; b < d(); ++b) {
    const bool is_tail_free = (fixed_[tail] >> b & 1) == 0, is_head_free = (fixed_[head] >> b & 1) == 0;
    const double step = move[static_cast<Eigen::Index>(b)] * (is_tail_free && is_head_free ? 0.5 : 1);
    u(b, tail) -= is_tail_free ? step : 0;
    u(b, head) += is_head_free ? step : 0;
  }
}

ProjectionInBlocks BlockProjection::run(const LinkLimits& limits, Displacement& u) {
  ProjectionInBlocks done;
  done.bytes = static_cast<std::int64_t>(links_.capacity() * sizeof(BlockLink) + fixed_.size());
  for (int frames = 0; frames < most_frames; ++frames) {
    done.is_feasible = largest_violation_in_blocks(scene_, limits, u) <= rounding_in_blocks;
    if (done.is_feasible)
      break;
    find_frames(u);
    for (int sweep = 0; sweep < sweeps_per_frames; sweep += 2) {
      for (const BlockLink& link : links_)
        bring_within(link, u);
      for (auto link = links_.rbegin(); link != links_.rend(); ++link)
        bring_within(*link, u);
    }
    done.sweeps += sweeps_per_frames;
  }
  return done;
}

} // namespace

ProjectionInBlocks project_in_blocks(const Scene& scene, const LinkLimits& limits,
                                     const std::vector<Prescribed>& prescribed, Displacement& u) {
  return BlockProjection(scene, limits, prescribed).run(limits, u);
}

namespace {

constexpr std::int64_t nodes_worth_threads = 3000;
/// Of moves and loads, where limits grant less than all: to 3 %.
constexpr int halvings = 5;

void add_sentence(std::string& message, const std::string& sentence) {
  message += message.empty() ? sentence : "; " + sentence;
}

std::string message_for(const Scene& scene, const CorotatedRelaxation& relaxation) {
  std::string message;
  if (relaxation.fraction() < 1)
    add_sentence(message, fmt::format("cut short when {:.3g} % of moves and loads were on: handles are there",
                                      100 * relaxation.fraction()));
  if (relaxation.n_inverted() > 0)
    add_sentence(message, fmt::format("{} cells are turned inside out", relaxation.n_inverted()));
  if (scene.relaxation.extrapolation != Extrapolation::none)
    add_sentence(message, "nothing is extrapolated in blocks");
  return message;
}

/// The least energy, whatever limits say. @param fraction how much of moves and loads is on
Answer elastic_in_blocks(const Scene& scene, const Control& control, double* fraction = nullptr) {
  const Clock clock;
  std::optional<Status> stopped;
  ThreadTeam team(scene.specimen.grid.n_nodes() < nodes_worth_threads ? 1 : std::max(1, control.threads));
  const CoupledTask task{scene, control, scene.prescribed, team, clock, [&] {
                           if (!stopped)
                             stopped = reason_to_stop(control, clock);
                           return stopped.has_value();
                         }};
  Answer answer;
  answer.method = "coupled";
  CorotatedRelaxation relaxation(task);
  answer.seconds.setup = clock.seconds();
  const bool is_converged = relaxation.solve(answer);
  answer.algorithm =
      fmt::format("lattice elasticity in a frame for every cell, quasi-Newton around multigrid, "
                  "{} increment{}",
                  relaxation.increments(), relaxation.increments() == 1 ? "" : "s");
  answer.message = message_for(scene, relaxation);
  if (fraction != nullptr)
    *fraction = relaxation.fraction();
  const bool is_whole = is_converged && relaxation.n_inverted() == 0;
  answer.status = is_whole ? Status::done : stopped.value_or(Status::budget_reached);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  answer.bytes += bytes_of(answer.displacement);
  return answer;
}

double energy_in_blocks(const Scene& scene, const Displacement& u, int threads) {
  const LatticeElasticity linear(scene);
  CorotatedElasticity elasticity(scene, linear);
  ThreadTeam team(std::max(1, threads));
  Displacement forces(scene.specimen.grid);
  return elasticity.evaluate(u, forces, team);
}

/// Largest change over largest displacement.
double change_between(const Displacement& from, const Displacement& to) {
  double change = 0;
  for (std::size_t i = 0; i < from.values().size(); ++i)
    change = std::max(change, std::abs(to.values()[i] - from.values()[i]));
  return change > 0 ? change / std::max(largest_entry(from), largest_entry(to)) : 0;
}

/// Brings answers in blocks within limits, and moves and loads back where those grant less.
class WithinLimits {
public:
  WithinLimits(const Scene& scene, const Control& control)
      : scene_(scene), control_(control), limits_(scene) {}

  Answer run();

private:
  bool bring_within(const Scene& scene, Answer& answer) const;
  Answer at_rest() const;
  Control remaining() const;

  const Scene& scene_;
  const Control& control_;
  Clock clock_;
  LinkLimits limits_;
};

/// What is left of the time budget for one more solve.
Control WithinLimits::remaining() const {
  Control control = control_;
  if (control.seconds_budget)
    control.seconds_budget = std::max(0.0, *control.seconds_budget - clock_.seconds());
  return control;
}

/// @param scene with what is prescribed for this answer. @return false if no feasible state was found; then
/// the answer is what it was
bool WithinLimits::bring_within(const Scene& scene, Answer& answer) const {
  Displacement feasible = answer.displacement;
  const ProjectionInBlocks projection = project_in_blocks(scene, limits_, scene.prescribed, feasible);
  if (!projection.is_feasible || projection.sweeps == 0)
    return projection.is_feasible;
  answer.residual = std::min(1.0, std::max(answer.residual, change_between(answer.displacement, feasible)));
  answer.displacement = std::move(feasible);
  answer.strain_energy = energy_in_blocks(scene, answer.displacement, control_.threads);
  answer.reaction.clear();
  answer.iterations += projection.sweeps;
  answer.bytes += projection.bytes;
  add_sentence(answer.message, "limits are active: the elastic state was brought to a feasible one, each "
                               "link in the frame of its cells");
  return true;
}

Answer WithinLimits::at_rest() const {
  Answer answer;
  answer.method = "coupled";
  answer.algorithm = "nothing moves";
  answer.displacement = Displacement(scene_.specimen.grid);
  answer.strain_energy = 0;
  answer.residual = 1;
  answer.bytes = bytes_of(answer.displacement);
  return answer;
}

Answer WithinLimits::run() {
  double reached = 1; // a solve that was cut short may have handles on their way
  Answer whole = elastic_in_blocks(scene_, control_, &reached);
  if (!has_displacement(whole.status))
    return whole;
  const std::optional<Status> stopped =
      is_converged(whole.status) ? std::nullopt : std::optional(whole.status);
  if (bring_within(reached < 1 ? scaled(scene_, reached) : scene_, whole))
    return whole;
  Answer best = at_rest();
  double low = 0, high = reached;
  std::optional<Status> cut_short = stopped;
  for (int i = 0; i < halvings && !cut_short; ++i) {
    const double middle = (low + high) / 2;
    const Scene part = scaled(scene_, middle);
    Answer answer = elastic_in_blocks(part, remaining());
    if (!is_converged(answer.status))
      cut_short = answer.status;
    else if (bring_within(part, answer)) {
      low = middle;
      best = std::move(answer);
    } else
      high = middle;
  }
  best.status = cut_short.value_or(Status::clamped);
  best.reaction.clear();
  add_sentence(best.message,
               fmt::format("limits grant {:.3g} % of moves and loads, as far as was found: handles "
                           "are there",
                           100 * low));
  best.seconds.solve = clock_.seconds() - best.seconds.setup;
  return best;
}

} // namespace

Answer solve_coupled_in_blocks(const Scene& scene, const Control& control) {
  if (!scene.limits_bind_coupled())
    return elastic_in_blocks(scene, control);
  return WithinLimits(scene, control).run();
}

} // namespace maille::deform
