#include "elastic/finite/turned_limits.hpp"

#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/limits/active_links.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace maille::deform {

using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

Vector3d at_rest(const Grid& grid, int axis) {
  return grid.spacing()[axis] * Vector3d::Unit(axis);
}

/// From tail to head [m].
Vector3d link_vector(const Grid& grid, const Displacement& u, std::int64_t tail, int axis) {
  Vector3d now = at_rest(grid, axis);
  for (int b = 0; b < grid.dimension(); ++b)
    now[b] += u(b, tail + grid.stride(axis)) - u(b, tail);
  return now;
}

} // namespace

TurnedLimits::TurnedLimits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team)
    : scene_(scene), team_(team), moduli_(scene), fixed_(scene.specimen.grid, scene.prescribed) {
  const Grid& grid = scene.specimen.grid;
  for (int b = 0; b < scene.dimension(); ++b) {
    intervals_.emplace_back(scene, limits, b);
    y_[b].assign(fixed_.n_nodes(), Vec3{});
  }
  moments_.resize(grid.n_cells());
}

TurnedLimits::Measured TurnedLimits::measure(const Displacement& u, const FiniteElasticity& elasticity,
                                             std::int64_t tail, int axis) const {
  const Grid& grid = scene_.specimen.grid;
  MeanRotation mean;
  scene_.specimen.for_each_cell_at_link(grid.node_at(tail), axis,
                                        [&](std::int64_t cell) { mean.add(elasticity.frames()[cell]); });
  Measured link{mean.value(), link_vector(grid, u, tail, axis), {}};
  link.change = link.frame.conjugate() * link.now - at_rest(grid, axis);
  return link;
}

Vec3 TurnedLimits::weight(const Index3& tail, int axis) const {
  Vec3 weight{};
  for (std::size_t b = 0; b < d(); ++b)
    weight[b] = link_weight(scene_.specimen, moduli_, tail, axis, static_cast<int>(b));
  return weight;
}

void TurnedLimits::find_in_plane(int plane, const Displacement& u, const FiniteElasticity& elasticity,
                                 List<Pull>& found) const {
  const Grid& grid = scene_.specimen.grid;
  const std::int64_t in_plane = grid.n_nodes() / grid.nodes()[d() - 1];
  for (std::int64_t tail = plane * in_plane; tail < (plane + 1) * in_plane; ++tail)
    for (int axis = 0; axis < scene_.dimension(); ++axis) {
      const auto node = static_cast<std::size_t>(tail), a = static_cast<std::size_t>(axis);
      const Index3 at = grid.node_at(tail);
      if (at[a] + 1 >= grid.nodes()[a] || std::isinf(intervals_[0].high(axis, node)))
        continue;
      const Measured link = measure(u, elasticity, tail, axis);
      Pull pull{tail, axis, {}, {}, link.frame.toRotationMatrix()};
      bool pulls = false;
      for (std::size_t b = 0; b < d(); ++b) {
        const double v = link.change[static_cast<Eigen::Index>(b)] + y_[a][node][b];
        pull.excess[b] = v - std::clamp(v, intervals_[b].low(axis, node), intervals_[b].high(axis, node));
        pulls = pulls || pull.excess[b] != 0 || y_[a][node][b] != 0;
      }
      if (!pulls)
        continue;
      pull.weight = weight(at, axis);
      found.push_back(pull);
    }
}

/// Force of a link on its nodes, and its moment on the cells around it.
double TurnedLimits::pull(const Pull& pull, const Displacement& u, const FiniteElasticity& elasticity,
                          Displacement& forces) {
  const Grid& grid = scene_.specimen.grid;
  const Measured link = measure(u, elasticity, pull.tail, pull.axis);
  Vector3d force = Vector3d::Zero();
  double energy = 0;
  for (std::size_t b = 0; b < d(); ++b) {
    force[static_cast<Eigen::Index>(b)] = penalty_factor * pull.weight[b] * pull.excess[b];
    energy += 0.5 * penalty_factor * pull.weight[b] * pull.excess[b] * pull.excess[b];
  }
  force = link.frame * force;
  for (int b = 0; b < scene_.dimension(); ++b) {
    forces(b, pull.tail) -= force[b];
    forces(b, pull.tail + grid.stride(pull.axis)) += force[b];
  }
  // The mean is that of quaternions q_i: its turn is (sum of a_i t_i + t_i x v_i) / sum of a_i, with t_i the
  // turn of a cell and (a_i, v_i) = q_i over the mean.
  const Vector3d moment = -link.now.cross(force);
  std::array<std::pair<std::size_t, Quaterniond>, 4> around;
  std::size_t n = 0;
  double sum = 0;
  scene_.specimen.for_each_cell_at_link(grid.node_at(pull.tail), pull.axis, [&](std::int64_t cell) {
    Quaterniond over = elasticity.frames()[cell] * link.frame.conjugate();
    if (over.w() < 0)
      over.coeffs() = -over.coeffs();
    sum += over.w();
    around[n++] = {static_cast<std::size_t>(cell), over};
  });
  for (std::size_t i = 0; i < n; ++i)
    moments_[around[i].first] += (around[i].second.w() * moment + around[i].second.vec().cross(moment)) / sum;
  return energy;
}

double TurnedLimits::evaluate(const Displacement& u, const FiniteElasticity& elasticity,
                              Displacement& forces) {
  const int planes = scene_.specimen.grid.nodes()[d() - 1];
  std::vector<List<Pull>> of_plane(planes);
  team_.run(planes, [&](int plane, int) { find_in_plane(plane, u, elasticity, of_plane[plane]); });
  pulls_.clear();
  std::size_t n = 0;
  for (const auto& found : of_plane)
    n += found.size();
  pulls_.reserve(n);
  for (auto& found : of_plane) {
    pulls_.insert(pulls_.end(), found.begin(), found.end());
    found = {};
  }
  if (pulls_.empty())
    return 0;
  std::ranges::fill(moments_, Vector3d::Zero());
  double energy = 0;
  for (const Pull& link : pulls_)
    energy += pull(link, u, elasticity, forces);
  elasticity.add_moments(u, moments_, forces, team_);
  return energy;
}

void TurnedLimits::add_tangent(const Displacement& p, Displacement& forces) const {
  const Grid& grid = scene_.specimen.grid;
  for (const Pull& link : pulls_) {
    const Vector3d change =
        link.frame.transpose() * (link_vector(grid, p, link.tail, link.axis) - at_rest(grid, link.axis));
    Vector3d force = Vector3d::Zero();
    for (std::size_t b = 0; b < d(); ++b)
      if (const auto i = static_cast<Eigen::Index>(b); link.excess[b] != 0)
        force[i] = penalty_factor * link.weight[b] * change[i];
    force = link.frame * force;
    for (int b = 0; b < scene_.dimension(); ++b) {
      forces(b, link.tail) -= force[b];
      forces(b, link.tail + grid.stride(link.axis)) += force[b];
    }
  }
}

void TurnedLimits::improve_multipliers() {
  for (const Pull& pull : pulls_)
    y_[pull.axis][pull.tail] = pull.excess;
}

double TurnedLimits::gap() const {
  double sum = 0;
  for (const Pull& pull : pulls_)
    for (std::size_t b = 0; b < d(); ++b) {
      const double y = y_[pull.axis][pull.tail][b];
      sum += pull.weight[b] * (pull.excess[b] - y) * (pull.excess[b] - y);
    }
  return sum;
}

bool TurnedLimits::are_penalties_out_of_date() const {
  if (has_penalty_.empty())
    return true;
  std::size_t outside = 0, told = 0;
  for (const Pull& pull : pulls_)
    for (std::size_t b = 0; b < d(); ++b)
      if (pull.excess[b] != 0) {
        ++outside;
        told += (has_penalty_[pull.tail] & bit(pull.axis, b)) != 0 ? 1 : 0;
      }
  std::size_t before = 0;
  for (const std::uint16_t bits : has_penalty_)
    before += static_cast<std::size_t>(std::popcount(bits));
  return static_cast<double>(outside - told + before - told) > enough_changes * static_cast<double>(outside);
}

const List<PenaltyLink>& TurnedLimits::penalties() {
  has_penalty_.assign(fixed_.n_nodes(), 0);
  penalties_.clear();
  for (const Pull& pull : pulls_)
    for (std::size_t b = 0; b < d(); ++b) {
      if (pull.excess[b] == 0)
        continue;
      const auto tail = static_cast<std::size_t>(pull.tail),
                 head = tail + static_cast<std::size_t>(scene_.specimen.grid.stride(pull.axis));
      has_penalty_[tail] = static_cast<std::uint16_t>(has_penalty_[tail] | bit(pull.axis, b));
      if (!fixed_(b, tail) || !fixed_(b, head))
        penalties_.push_back({static_cast<int>(b), pull.axis, pull.tail, penalty_factor * pull.weight[b]});
    }
  return penalties_;
}

namespace {

constexpr int sweeps_per_frames = 8, most_frames = 60;

struct FramedLink {
  std::int64_t tail = 0, head = 0;
  int axis = 0;
  LinkIntervals<double> interval; ///< by component [m]
  Eigen::Matrix3d frame;
};

class FrameProjection {
public:
  FrameProjection(const Scene& scene, const LinkLimits& limits, double narrowed);
  std::optional<int> run(const LinkLimits& limits, Displacement& u);

private:
  void find_frames(const Displacement& u);
  void bring_within(const FramedLink& link, Displacement& u) const;

  const Scene& scene_;
  double narrowed_;
  List<FramedLink> links_;
  FixedMask fixed_;
};

FrameProjection::FrameProjection(const Scene& scene, const LinkLimits& limits, double narrowed)
    : scene_(scene), narrowed_(narrowed), fixed_(scene.specimen.grid, scene.prescribed) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int axis = 0; axis < scene.dimension(); ++axis) {
      const Index3 at = grid.node_at(node);
      const auto a = static_cast<std::size_t>(axis);
      if (at[a] + 1 >= grid.nodes()[a])
        continue;
      if (const auto interval = limits.intervals(at, axis))
        links_.push_back({node, node + grid.stride(axis), axis, *interval, Eigen::Matrix3d::Identity()});
    }
}

void FrameProjection::find_frames(const Displacement& u) {
  const List<Quaterniond> rotation = block_rotations(scene_, u);
  for (FramedLink& link : links_) {
    MeanRotation mean;
    scene_.specimen.for_each_cell_at_link(scene_.specimen.grid.node_at(link.tail), link.axis,
                                          [&](std::int64_t cell) { mean.add(rotation[cell]); });
    link.frame = mean.value().toRotationMatrix();
  }
}

void FrameProjection::bring_within(const FramedLink& link, Displacement& u) const {
  const Grid& grid = scene_.specimen.grid;
  const auto tail = static_cast<std::size_t>(link.tail), head = static_cast<std::size_t>(link.head);
  const auto& [low, high] = link.interval;
  const Vector3d change =
      link.frame.transpose() * link_vector(grid, u, link.tail, link.axis) - at_rest(grid, link.axis);
  Vector3d missing = Vector3d::Zero();
  for (std::size_t b = 0; b < u.n_components(); ++b) {
    const auto i = static_cast<Eigen::Index>(b);
    const double margin = narrowed_ * (high[b] - low[b]);
    missing[i] = std::clamp(change[i], low[b] + margin, high[b] - margin) - change[i];
  }
  if (missing.isZero(0))
    return;
  const Vector3d move = link.frame * missing;
  for (std::size_t b = 0; b < u.n_components(); ++b) {
    const bool is_tail_free = !fixed_(b, tail), is_head_free = !fixed_(b, head);
    const double step = move[static_cast<Eigen::Index>(b)] * (is_tail_free && is_head_free ? 0.5 : 1);
    u(b, tail) -= is_tail_free ? step : 0;
    u(b, head) += is_head_free ? step : 0;
  }
}

std::optional<int> FrameProjection::run(const LinkLimits& limits, Displacement& u) {
  for (int frames = 0; frames < most_frames; ++frames) {
    if (largest_violation_in_blocks(scene_, limits, u) <= tolerance)
      return frames * sweeps_per_frames;
    find_frames(u);
    for (int sweep = 0; sweep < sweeps_per_frames; sweep += 2) {
      for (const FramedLink& link : links_)
        bring_within(link, u);
      for (auto link = links_.rbegin(); link != links_.rend(); ++link)
        bring_within(*link, u);
    }
  }
  return std::nullopt;
}

} // namespace

std::optional<int> project_in_turned_frames(const Scene& scene, const LinkLimits& limits, Displacement& u,
                                            double narrowed) {
  return FrameProjection(scene, limits, narrowed).run(limits, u);
}

} // namespace maille::deform
