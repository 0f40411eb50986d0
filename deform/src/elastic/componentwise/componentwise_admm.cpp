#include "elastic/componentwise/componentwise_admm.hpp"

#include "elastic/componentwise/componentwise_problem.hpp"

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

ComponentwiseAdmm::ComponentwiseAdmm(const Grid& grid, ComponentwiseSolver& solver, const LinkRanges& ranges,
                                     std::span<const double> forces, ThreadTeam& team)
    : solver_(solver), ranges_(ranges), team_(team), nodes_(level_nodes(grid)),
      loads_(forces.begin(), forces.end()) {
  for (double& load : loads_)
    load /= solver.unit();
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    Axis& made = axes_.emplace_back();
    made.grid = axis;
    made.level = level_axis(grid, axis);
    made.step = grid.stride(axis);
    made.v.assign(static_cast<std::size_t>(grid.n_nodes()), 0);
    if (ranges.is_same_everywhere()) {
      made.low.assign(static_cast<std::size_t>(nodes_[0]), ranges.low(axis).front());
      made.high.assign(static_cast<std::size_t>(nodes_[0]), ranges.high(axis).front());
    }
  }
}

RowOfLinks ComponentwiseAdmm::row(const Axis& axis, float* v, int y, int z) const {
  const ComponentwiseLevel& level = solver_.multigrid().finest();
  const ComponentwiseOperator& A = level.A();
  const Index3 at{0, y, z};
  const auto a = static_cast<std::size_t>(axis.level);
  RowOfLinks links;
  if (a > 0 && at[a] + 1 >= nodes_[a])
    return links;
  links.n = a == 0 ? nodes_[0] - 1 : nodes_[0];
  const std::int64_t first = level.node(at);
  links.v = v + first;
  links.low = ranges_.is_same_everywhere() ? axis.low.data() : ranges_.low(axis.grid).data() + first;
  links.high = ranges_.is_same_everywhere() ? axis.high.data() : ranges_.high(axis.grid).data() + first;
  if (!level.weights().is_box()) {
    links.weight = A.link[a] + level.offset(at);
    return links;
  }
  links.weight = a == 0 ? A.axis_link[0] : A.axis_mass[0];
  for (std::size_t b = 1; b < 3; ++b)
    links.factor *= double{b == a ? A.axis_link[b][at[b]] : A.axis_mass[b][at[b]]};
  return links;
}

/// (f + rho D^T W (z - y)) / (1 + rho).
void ComponentwiseAdmm::gather_forces(int z, std::vector<double>& target) {
  const std::int64_t plane = std::int64_t{1} * nodes_[0] * nodes_[1], begin = plane * z;
  for (std::int64_t i = begin; i < begin + plane; ++i)
    target[static_cast<std::size_t>(i)] =
        loads_.empty() ? 0 : loads_[static_cast<std::size_t>(i)] / (1 + rho_);
  const double scale = rho_ / (1 + rho_);
  for (Axis& axis : axes_)
    for (int y = 0; y < nodes_[1]; ++y) {
      double* const here = target.data() + begin + std::int64_t{1} * nodes_[0] * y;
      const RowOfLinks links = row(axis, axis.v.data(), y, z);
      add_pulls(links, -scale, here);
      if (axis.level < 2)
        add_pulls(links, scale, here + axis.step);
      else if (z > 0)
        add_pulls(row(axis, axis.v.data(), y, z - 1), scale, here);
    }
}

LinkResiduals ComponentwiseAdmm::update_plane(int z, const double* u) {
  LinkResiduals sum;
  for (Axis& axis : axes_)
    for (int y = 0; y < nodes_[1]; ++y) {
      const double* const near = u + solver_.multigrid().finest().node({0, y, z});
      update_multipliers(row(axis, axis.v.data(), y, z), over_relaxation, near, near + axis.step, sum);
    }
  return sum;
}

/// z = D u within the ranges, y = 0.
void ComponentwiseAdmm::begin_with(const std::vector<double>& u) {
  team_.run(nodes_[2], [&](int z, int) {
    for (Axis& axis : axes_)
      for (int y = 0; y < nodes_[1]; ++y) {
        const RowOfLinks links = row(axis, axis.v.data(), y, z);
        const double* const near = u.data() + solver_.multigrid().finest().node({0, y, z});
        for (int x = 0; x < links.n; ++x)
          links.v[x] = static_cast<float>(
              std::min(std::max(near[x + axis.step] - near[x], links.low[x]), links.high[x]));
      }
  });
}

void ComponentwiseAdmm::change_penalty(double factor) {
  rho_ *= factor;
  team_.run(nodes_[2], [&](int z, int) {
    for (Axis& axis : axes_)
      for (int y = 0; y < nodes_[1]; ++y)
        scale_multipliers(row(axis, axis.v.data(), y, z), factor);
  });
}

SolveOutcome ComponentwiseAdmm::solve(std::vector<double>& u, double tolerance,
                                      const std::function<bool()>& must_stop) {
  std::vector<double> forces(u.size());
  std::vector<LinkResiduals> of_plane(static_cast<std::size_t>(nodes_[2]));
  SolveOutcome outcome;
  outcome.remaining = std::numeric_limits<double>::infinity();
  begin_with(u);
  for (int since_change = 0; outcome.iterations < most_iterations; ++since_change) {
    if (must_stop && must_stop()) {
      outcome.was_stopped = true;
      return outcome;
    }
    team_.run(nodes_[2], [&](int z, int) { gather_forces(z, forces); });
    solver_.improve(u, forces);
    team_.run(nodes_[2],
              [&](int z, int) { of_plane[static_cast<std::size_t>(z)] = update_plane(z, u.data()); });
    ++outcome.iterations;
    LinkResiduals sum;
    for (const LinkResiduals& part : of_plane) {
      sum.primal += part.primal;
      sum.dual += part.dual;
      sum.norm += part.norm;
    }
    const double primal = std::sqrt(sum.primal), dual = rho_ * std::sqrt(sum.dual);
    outcome.remaining = sum.norm > 0 ? std::max(primal, dual) / std::sqrt(sum.norm) : 0;
    if (outcome.remaining <= tolerance)
      return outcome;
    if (since_change >= iterations_between_changes &&
        (primal > out_of_balance * dual || dual > out_of_balance * primal)) {
      change_penalty(primal > dual ? penalty_factor : 1 / penalty_factor);
      since_change = 0;
    }
  }
  outcome.was_stopped = true;
  return outcome;
}

double ComponentwiseAdmm::limit_force(std::int64_t node) const {
  const ComponentwiseLevel& level = solver_.multigrid().finest();
  const Index3 at = level.node_at(node);
  double sum = 0;
  for (const Axis& axis : axes_)
    for (const int side : {-1, 0}) {
      Index3 near = at;
      near[static_cast<std::size_t>(axis.level)] += side;
      const double weight = level.weight(near, axis.level);
      if (weight == 0)
        continue;
      const auto first = static_cast<std::size_t>(level.node(near));
      const double v = double{axis.v[first]};
      const double z = std::min(std::max(v, ranges_.low(axis.grid, first)), ranges_.high(axis.grid, first));
      sum += (side < 0 ? 1 : -1) * weight * (v - z);
    }
  return sum * rho_ * solver_.unit();
}

std::int64_t ComponentwiseAdmm::bytes() const {
  // also the forces of a step, one float64 a node
  std::size_t sum = loads_.size() * sizeof(double);
  for (const Axis& axis : axes_)
    sum += axis.v.size() * sizeof(float) + (axis.low.size() + axis.high.size()) * sizeof(double);
  return static_cast<std::int64_t>(sum + axes_.front().v.size() * sizeof(double));
}

} // namespace maille::deform
