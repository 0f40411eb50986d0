#include "world/balance/soft_part.hpp"

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/plausibility.hpp"
#include "world/balance/surface_object.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Components of three distant nodes that, if fixed, remove all rigid motions and cause no strain.
std::vector<std::int64_t> supports(const PosedLattice& lattice) {
  const int d = lattice.dimension();
  const auto furthest = [&](const auto& distance) {
    std::int32_t best = 0;
    for (std::int32_t voxel = 1; voxel < lattice.n_voxels(); ++voxel)
      if (distance(lattice.rest(voxel)) > distance(lattice.rest(best)) * (1 + 1e-9))
        best = voxel;
    return best;
  };
  const auto within = [&](std::int32_t voxel) {
    return Eigen::Vector3d(lattice.pose().rotation.transpose() * lattice.rest(voxel));
  };
  const Eigen::Vector3d first = lattice.rest(0);
  const std::int32_t b = furthest([&](const Eigen::Vector3d& x) { return (x - first).norm(); });
  const Eigen::Vector3d ab = within(b) - within(0);
  Eigen::Index along = 0;
  ab.head(d).cwiseAbs().maxCoeff(&along);
  std::vector<std::int64_t> list;
  for (int component = 0; component < d; ++component) {
    list.push_back(component);
    if (component != along)
      list.push_back(std::int64_t{d} * b + component);
  }
  if (d == 3) {
    const std::int32_t c = furthest([&](const Eigen::Vector3d& x) {
      return (lattice.pose().rotation.transpose() * (x - first)).cross(ab).norm();
    });
    // With two nodes fixed, the body can still rotate about the line between them, which moves the third node
    // along `swing`.
    const Eigen::Vector3d swing = ab.cross(within(c) - within(0));
    Eigen::Index component = 0;
    swing.cwiseAbs().maxCoeff(&component);
    list.push_back(std::int64_t{3} * c + component);
  }
  std::ranges::sort(list);
  return list;
}

/// True if fixing these components removes all rigid motions.
bool holds(const Scene& scene, const PosedLattice& lattice, const std::vector<std::int64_t>& kept) {
  if (kept.empty())
    return false;
  Scene held = scene;
  held.prescribed.clear();
  for (const std::int64_t component : kept)
    held.prescribed.push_back({lattice.node(static_cast<std::int32_t>(component / scene.dimension())),
                               static_cast<int>(component % scene.dimension()), 0, true});
  std::ranges::sort(held.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  return remaining_rigid_motion(held).empty();
}

} // namespace

SoftPart::SoftPart(const DeformableObject& body, const Skin& skin)
    : body_(&body), dimension_(body.lattice().dimension()) {
  std::vector<char> of_node(body.scene().specimen.grid.n_nodes(), 0);
  for (const Prescribed& p : body.scene().prescribed)
    of_node[p.node] |= static_cast<char>(1 << p.component);
  for (std::int32_t node = 0; node < skin.n_nodes(); ++node) {
    first_.push_back(std::int64_t{dimension_} * body.lattice().voxel(skin.node(node)));
    held_.push_back(of_node[skin.node(node)]);
  }
  state_.displacement = Eigen::VectorXd::Zero(dimension_ * body.lattice().n_voxels());
  state_.unloaded = state_.contact_forces = state_.displacement;
  watch_all();
}

bool SoftPart::hold(bool is_elsewhere, int threads) {
  const PosedLattice& lattice = body_->lattice();
  std::vector<std::int64_t> kept;
  for (const Prescribed& p : body_->scene().prescribed)
    kept.push_back(std::int64_t{dimension_} * lattice.voxel(p.node) + p.component);
  for (const auto& [node, handle] : body_->handles())
    for (int b = 0; b < dimension_; ++b)
      kept.push_back(std::int64_t{dimension_} * lattice.voxel(node) + b);
  sort_uniquely(kept);
  const bool has_inertia = inertia_.size() > 0; // K is regular without holds, and the frame stays
  if (!has_inertia && kept != kept_) {
    kept_ = kept;
    is_kept_ = holds(body_->scene(), lattice, kept);
  }
  floats_ = !has_inertia && (!is_kept_ || is_elsewhere);
  pulled_ = floats_ ? kept : std::vector<std::int64_t>{};
  if (floats_)
    kept = supports(lattice);
  if (flexibility_ && kept == fixed_) // sets of floating and held bodies differ
    return false;
  flexibility_ = std::make_unique<Flexibility>(body_->scene(), kept, inertia_, floats_, threads);
  fixed_ = std::move(kept);
  watch_all();
  return true;
}

void SoftPart::set_inertia(Eigen::VectorXd inertia) {
  if (inertia_.size() != inertia.size() || inertia_ != inertia)
    flexibility_.reset();
  inertia_ = std::move(inertia);
}

double SoftPart::prescribe() {
  Eigen::VectorXd given = state_.displacement; // a floating body stays in its frame
  if (!floats_) {
    given.setZero();
    const PosedLattice& lattice = body_->lattice();
    for (const auto& [node, handle] : body_->handles())
      for (int b = 0; b < dimension_; ++b)
        given[dimension_ * lattice.voxel(node) + b] = handle.at[b];
    for (const Prescribed& p : body_->scene().prescribed)
      given[dimension_ * lattice.voxel(p.node) + p.component] = 0;
  }
  Eigen::VectorXd unloaded = flexibility_->moved(given);
  if (is_carried())
    unloaded += flexibility_->solve(carried_);
  const double change = (unloaded - state_.unloaded).cwiseAbs().maxCoeff();
  state_.unloaded = std::move(unloaded);
  return change;
}

double SoftPart::pull_at(std::int64_t component) const {
  if (!floats_)
    return flexibility_->force_at(component, state_.displacement) - state_.contact_forces[component];
  const auto pulled = std::ranges::lower_bound(pulled_, component);
  return pulled != pulled_.end() && *pulled == component && state_.pull.size() > 0
             ? state_.pull[pulled - pulled_.begin()]
             : 0;
}

Eigen::VectorXd SoftPart::answer(const std::vector<std::pair<std::int64_t, double>>& forces) {
  if (flexibility_->watches_all()) {
    Eigen::VectorXd of_all = Eigen::VectorXd::Zero(state_.displacement.size());
    std::vector<std::int64_t> components;
    for (const auto& [component, force] : forces) {
      of_all[component] = force;
      components.push_back(component);
    }
    return state_.unloaded + flexibility_->moved_by(of_all, components);
  }
  Eigen::VectorXd answer(dimension_ * std::ssize(moved_));
  for (std::size_t k = 0; k < moved_.size(); ++k)
    answer.segment(dimension_ * static_cast<Eigen::Index>(k), dimension_) =
        state_.unloaded.segment(std::int64_t{dimension_} * moved_[k], dimension_);
  for (const auto& [component, force] : forces)
    answer += force * flexibility_->watched_column(component);
  return answer;
}

Eigen::VectorXd SoftPart::way_to(const Eigen::VectorXd& displacement) const {
  Eigen::VectorXd way = displacement;
  for (std::size_t k = 0; k < moved_.size(); ++k)
    way.segment(dimension_ * static_cast<Eigen::Index>(k), dimension_) -=
        state_.displacement.segment(std::int64_t{dimension_} * moved_[k], dimension_);
  return way;
}

Eigen::VectorXd SoftPart::way_at(std::int64_t first, const Eigen::VectorXd& displacement) const {
  const Eigen::Index place = dimension_ * place_of_[first / dimension_];
  return displacement.segment(place, dimension_) - state_.displacement.segment(first, dimension_);
}

double SoftPart::dot_with_last_step(const Eigen::VectorXd& displacement) {
  Eigen::VectorXd way = way_to(displacement);
  const double product = way_.size() == way.size() ? way_.dot(way) : 0;
  way_ = std::move(way);
  return product;
}

void SoftPart::go(const Response& response, double part) {
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    auto u = state_.displacement.segment(std::int64_t{dimension_} * moved_[k], dimension_);
    u += part * (response.displacement.segment(dimension_ * static_cast<Eigen::Index>(k), dimension_) - u);
  }
  for (const std::int64_t component : state_.forced)
    state_.contact_forces[component] *= 1 - part;
  double largest = 0;
  std::vector<std::int64_t> components, both;
  for (const auto& [component, force] : response.forces) {
    state_.contact_forces[component] += part * force;
    components.push_back(component);
    largest = std::max(largest, std::abs(force));
  }
  std::ranges::set_union(state_.forced, components, std::back_inserter(both));
  state_.forced = std::move(both);
  std::erase_if(state_.forced, [&](std::int64_t component) {
    const bool is_negligible = std::abs(state_.contact_forces[component]) <= rounding * largest;
    if (is_negligible)
      state_.contact_forces[component] = 0;
    return is_negligible;
  });
}

bool SoftPart::watch(std::vector<std::int32_t> nodes_of_skin) {
  watched_ = std::move(nodes_of_skin);
  std::vector<std::int32_t> moved;
  for (const std::int32_t node : watched_)
    moved.push_back(static_cast<std::int32_t>(first(node) / dimension_));
  for (const std::int64_t component : pulled_)
    moved.push_back(static_cast<std::int32_t>(component / dimension_));
  sort_uniquely(moved);
  if (moved == moved_)
    return false;
  moved_ = std::move(moved);
  flexibility_->watch(moved_);
  way_.resize(0);
  std::ranges::fill(place_of_, -1);
  for (std::size_t k = 0; k < moved_.size(); ++k)
    place_of_[moved_[k]] = static_cast<std::int32_t>(k);
  return true;
}

void SoftPart::watch_all() {
  if (moved_.size() == place_of_.size() && flexibility_ && flexibility_->watches_all())
    return;
  moved_.resize(body_->lattice().n_voxels());
  std::iota(moved_.begin(), moved_.end(), 0);
  place_of_ = moved_;
  way_.resize(0);
  if (flexibility_)
    flexibility_->watch(moved_);
}

bool SoftPart::catch_up() {
  if (moved_.size() == place_of_.size())
    return false;
  watch_all();
  state_.displacement = state_.unloaded + flexibility_->moved_by(state_.contact_forces, state_.forced);
  return true;
}

} // namespace maille::deform
