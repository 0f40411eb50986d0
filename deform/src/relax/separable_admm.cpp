#include "relax/separable_admm.hpp"

#include "relax/separable_problem.hpp"
#include "relax/separable_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

constexpr int most_iterations = 1000;
constexpr double over_relaxation = 1.6;
/// Residuals that differ by more than this factor change the penalty, so far, so often.
constexpr double out_of_balance = 4;
constexpr double penalty_factor = 2;
constexpr int iterations_between_changes = 4;

} // namespace

SeparableAdmm::SeparableAdmm(const Grid& grid, SeparableSolver& solver, const LinkRanges& ranges,
                             std::span<const double> forces, ThreadTeam& team)
    : solver_(solver), ranges_(ranges), team_(team), nodes_(level_nodes(grid)),
      loads_(forces.begin(), forces.end()) {
  for (double& load : loads_)
    load /= solver.unit();
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    links_.push_back({axis, grid.stride(axis), level_axis(grid, axis)});
    v_[static_cast<std::size_t>(axis)].assign(static_cast<std::size_t>(grid.n_nodes()), 0);
  }
}

/// Calls visit(first node, weight) for the links along one axis that start in a plane and exist.
template<class Visit>
void SeparableAdmm::for_links_from(int z, const Link& link, Visit&& visit) const {
  const SeparableLevel& level = solver_.multigrid().finest();
  const auto a = static_cast<std::size_t>(link.level_axis);
  const auto each_row = [&](const auto& weight_of) {
    for (int y = 0; y < nodes_[1]; ++y) {
      const Index3 at{0, y, z};
      if (a > 0 && at[a] + 1 >= nodes_[a])
        continue;
      weight_of(y, level.node(at), a == 0 ? nodes_[0] - 1 : nodes_[0]);
    }
  };
  const auto with = [&](const auto& row, std::int64_t first, int n) {
    for (int x = 0; x < n; ++x) {
      const double weight = a == 0 ? row.x_link(x) : a == 1 ? row.y_above(x) : row.z_above(x);
      if (weight > 0)
        visit(static_cast<std::size_t>(first + x), weight);
    }
  };
  if (level.weights().is_box())
    each_row([&](int y, std::int64_t first, int n) { with(DoubleBoxRow(level, y, z), first, n); });
  else
    each_row([&](int y, std::int64_t first, int n) { with(DoubleLinkRow(level, y, z), first, n); });
}

/// f + rho D^T W (z - y), over 1 + rho.
void SeparableAdmm::gather_forces(int z, std::vector<double>& target) const {
  const std::int64_t plane = std::int64_t{1} * nodes_[0] * nodes_[1];
  const auto begin = static_cast<std::ptrdiff_t>(plane * z);
  if (loads_.empty())
    std::fill_n(target.begin() + begin, plane, 0.0);
  else
    for (std::int64_t i = begin; i < begin + plane; ++i)
      target[static_cast<std::size_t>(i)] = loads_[static_cast<std::size_t>(i)] / (1 + rho_);
  const double factor = rho_ / (1 + rho_);
  for (const Link& link : links_) {
    const std::vector<float>& v = v_[static_cast<std::size_t>(link.axis)];
    const auto pull = [&](std::size_t node, double weight) {
      const double value = double{v[node]};
      const double clamped =
          std::min(std::max(value, ranges_.low(link.axis, node)), ranges_.high(link.axis, node));
      return factor * weight * (2 * clamped - value);
    };
    for_links_from(z, link, [&](std::size_t node, double weight) {
      const double force = pull(node, weight);
      target[node] -= force;
      if (link.level_axis < 2)
        target[node + static_cast<std::size_t>(link.step)] += force;
    });
    if (link.level_axis == 2 && z > 0)
      for_links_from(z - 1, link, [&](std::size_t node, double weight) {
        target[node + static_cast<std::size_t>(link.step)] += pull(node, weight);
      });
  }
}

SeparableAdmm::Residuals SeparableAdmm::update_links(int z, const double* u, bool begins) {
  Residuals sum;
  for (const Link& link : links_) {
    std::vector<float>& v = v_[static_cast<std::size_t>(link.axis)];
    for_links_from(z, link, [&](std::size_t node, double weight) {
      const double low = ranges_.low(link.axis, node), high = ranges_.high(link.axis, node);
      const double difference = u[node + static_cast<std::size_t>(link.step)] - u[node];
      if (begins) {
        v[node] = static_cast<float>(std::min(std::max(difference, low), high));
        return;
      }
      const double before = double{v[node]}, clamped_before = std::min(std::max(before, low), high);
      const double after = over_relaxation * difference - over_relaxation * clamped_before + before;
      const double clamped = std::min(std::max(after, low), high);
      v[node] = static_cast<float>(after);
      sum.primal += weight * (difference - clamped) * (difference - clamped);
      sum.dual += weight * (clamped - clamped_before) * (clamped - clamped_before);
      sum.norm += weight * difference * difference;
    });
  }
  return sum;
}

void SeparableAdmm::change_penalty(double factor) {
  rho_ *= factor;
  team_.run(nodes_[2], [&](int z, int) {
    for (const Link& link : links_)
      for_links_from(z, link, [&](std::size_t node, double) {
        float& v = v_[static_cast<std::size_t>(link.axis)][node];
        const double clamped =
            std::min(std::max(double{v}, ranges_.low(link.axis, node)), ranges_.high(link.axis, node));
        v = static_cast<float>(clamped + (double{v} - clamped) / factor);
      });
  });
}

SolveOutcome SeparableAdmm::solve(std::vector<double>& u, double tolerance,
                                  const std::function<bool()>& must_stop) {
  std::vector<double> forces(u.size());
  std::vector<Residuals> of_plane(static_cast<std::size_t>(nodes_[2]));
  const auto update = [&](bool begins) {
    team_.run(nodes_[2],
              [&](int z, int) { of_plane[static_cast<std::size_t>(z)] = update_links(z, u.data(), begins); });
    Residuals sum;
    for (const Residuals& part : of_plane) {
      sum.primal += part.primal;
      sum.dual += part.dual;
      sum.norm += part.norm;
    }
    return sum;
  };
  SolveOutcome outcome;
  outcome.remaining = std::numeric_limits<double>::infinity();
  update(true);
  for (int since_change = 0; outcome.iterations < most_iterations; ++since_change) {
    if (must_stop && must_stop()) {
      outcome.was_stopped = true;
      return outcome;
    }
    team_.run(nodes_[2], [&](int z, int) { gather_forces(z, forces); });
    solver_.improve(u, forces);
    const Residuals residuals = update(false);
    ++outcome.iterations;
    const double primal = std::sqrt(residuals.primal), dual = rho_ * std::sqrt(residuals.dual);
    outcome.remaining = residuals.norm > 0 ? std::max(primal, dual) / std::sqrt(residuals.norm) : 0;
    if (outcome.remaining <= tolerance)
      return outcome;
    if (since_change < iterations_between_changes)
      continue;
    if (primal > out_of_balance * dual || dual > out_of_balance * primal) {
      change_penalty(primal > dual ? penalty_factor : 1 / penalty_factor);
      since_change = 0;
    }
  }
  outcome.was_stopped = true;
  return outcome;
}

double SeparableAdmm::limit_force(std::int64_t node) const {
  const SeparableLevel& level = solver_.multigrid().finest();
  const Index3 at = level.node_at(node);
  double sum = 0;
  for (const Link& link : links_)
    for (const int side : {-1, 0}) {
      Index3 near = at;
      near[static_cast<std::size_t>(link.level_axis)] += side;
      const double weight = level.weight(near, link.level_axis);
      if (weight == 0)
        continue;
      const auto first = static_cast<std::size_t>(level.node(near));
      const double v = double{v_[static_cast<std::size_t>(link.axis)][first]};
      const double clamped =
          std::min(std::max(v, ranges_.low(link.axis, first)), ranges_.high(link.axis, first));
      sum += (side < 0 ? 1 : -1) * weight * (v - clamped);
    }
  return sum * rho_ * solver_.unit();
}

std::int64_t SeparableAdmm::bytes() const {
  std::size_t sum = 2 * loads_.size() * sizeof(double);
  for (const auto& axis : v_)
    sum += axis.size() * (sizeof(float) + sizeof(double));
  return static_cast<std::int64_t>(sum);
}

} // namespace maille::deform
