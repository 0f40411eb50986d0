#include "maille/deform/probe/probe.hpp"

#include "elastic/kept_answers.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/plausibility.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Polling interval for new sites: the loop must not wake a thread.
constexpr std::chrono::microseconds nap{500};

/// Order of Scene::prescribed.
bool is_before(const Prescribed& a, const Prescribed& b) {
  return std::pair(a.component, a.node) < std::pair(b.component, b.node);
}

} // namespace

struct ContactSolver::Kept {
  std::mutex mutex;
  KeptAnswers answers;
  explicit Kept(const Scene& scene)
      : answers(remaining_rigid_motion(scene).empty() ? Keeping::hierarchy_of_holds : Keeping::hierarchy) {}
};

ContactSolver::ContactSolver(const Scene& scene, std::shared_ptr<const BodySurface> surface, double radius,
                             const RigidShape* tool)
    : scene_(&scene), surface_(std::move(surface)), radius_(radius), tool_(tool),
      kept_(std::make_shared<Kept>(scene)) {
  if (scene.dimension() != 3 || !(radius >= 0) || !std::isfinite(radius))
    throw std::invalid_argument("ContactSolver: a scene of three dimensions, a footprint of 0 or more");
  if (scene.has_loads() || std::ranges::any_of(scene.prescribed, [](const Prescribed& p) { return !p.held; }))
    throw std::invalid_argument("ContactSolver: a scene with holds alone");
}

ContactStiffness ContactSolver::estimate() const {
  const Vec3& spacing = scene_->specimen.grid.spacing();
  const double least = *std::ranges::min_element(spacing);
  double modulus = 0; // E / (1 - nu^2) of a plane surface, mean of the materials
  for (const Material& material : scene_->materials) {
    const Matrix6 c = maille::stiffness(material.elasticity);
    modulus += (c(2, 2) - c(0, 2) * c(0, 2) / c(0, 0)) / static_cast<double>(scene_->materials.size());
  }
  ContactStiffness result;
  result.stiffness = 2 * std::max(radius_, 0.5 * least) * modulus;
  return result;
}

std::vector<std::int64_t> ContactSolver::footprint(const ContactSite& site) const {
  std::vector<std::int64_t> nodes;
  for (const Pressed& one : pressed(site))
    nodes.push_back(one.node);
  return nodes;
}

std::vector<ContactSolver::Pressed> ContactSolver::pressed(const ContactSite& site) const {
  std::vector<Pressed> list = before_tool(site);
  if (list.empty())
    for (const std::int64_t node : within_radius(site))
      list.push_back({node, site.depth});
  return list;
}

std::vector<std::int64_t> ContactSolver::within_radius(const ContactSite& site) const {
  const auto face = surface_->faces()[site.face];
  const auto rest = [&](std::int64_t node) {
    const Vec3 at = scene_->specimen.position(scene_->specimen.grid.node_at(node));
    return Eigen::Vector3d(Eigen::Vector3d::Map(at.data()));
  };
  const Pose& pose = surface_->pose();
  // The point at rest: at its present offset from the mean of the face's corners.
  Eigen::Vector3d now = Eigen::Vector3d::Zero(), before = now;
  for (const std::int32_t corner : face.corners) {
    now += 0.25 * surface_->position(corner);
    before += 0.25 * rest(surface_->node(corner));
  }
  Eigen::Vector3d point = before + pose.rotation.transpose() * (site.point - now);
  point[face.axis] = before[face.axis];

  const Grid& grid = scene_->specimen.grid;
  const Vec3 origin = scene_->specimen.origin;
  Index3 low, high;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double h = grid.spacing()[a], at = (point[i] - origin[a]) / h, reach = radius_ / h;
    low[a] = std::max(static_cast<int>(std::ceil(at - reach - 1e-9)), 0);
    high[a] = std::min(static_cast<int>(std::floor(at + reach + 1e-9)), grid.nodes()[a] - 1);
  }
  const auto normal = static_cast<std::size_t>(face.axis);
  low[normal] = high[normal] = grid.cell_at(face.cell)[normal] + (face.upper ? 1 : 0);
  const auto is_on_face = [&](const Index3& node) { // on the same side, and not covered by matter
    bool has_matter = false, is_covered = false;
    scene_->specimen.for_each_cell_at(node, [&](std::int64_t cell) {
      const bool above = grid.cell_at(cell)[normal] == node[normal];
      (above == face.upper ? is_covered : has_matter) = true;
    });
    return has_matter && !is_covered;
  };
  std::vector<std::int64_t> nodes;
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        if (is_on_face({x, y, z}) && (rest(grid.node({x, y, z})) - point).norm() <= radius_ * (1 + 1e-9))
          nodes.push_back(grid.node({x, y, z}));
  if (nodes.empty()) {
    const auto nearest = std::ranges::min_element(face.corners, {}, [&](std::int32_t corner) {
      return (rest(surface_->node(corner)) - point).squaredNorm();
    });
    nodes.push_back(surface_->node(*nearest));
  }
  return nodes;
}

/// Nodes of the surface, on faces with the normal of the site's face, that a tool voxel would reach when it
/// advances by the depth against that normal, and how far the tool then pushes each of them.
std::vector<ContactSolver::Pressed> ContactSolver::before_tool(const ContactSite& site) const {
  std::vector<Pressed> list;
  if (tool_ == nullptr || !site.tool || tool_->n_voxels() == 1)
    return list;
  const auto& of_site = surface_->faces()[site.face];
  const Eigen::Vector3d outwards = (of_site.upper ? 1 : -1) * surface_->pose().rotation.col(of_site.axis);
  const Eigen::Array3d spacing = Eigen::Array3d::Map(tool_->spacing().data());
  const Eigen::Matrix3d to_tool = site.tool->rotation.transpose();
  const Eigen::Array3d way = (to_tool * (site.depth * outwards)).array() / spacing;
  /// The part of the way after which a place in the lattice is in a voxel; 1: never.
  const auto first_part = [&](const Eigen::Array3d& from) {
    double first = 1;
    for (std::int32_t voxel = 0; voxel < tool_->n_voxels(); ++voxel) {
      const Index3 low = tool_->index_of(voxel);
      double enters = 0, leaves = 1;
      for (int a = 0; a < 3; ++a) {
        const double to_low = low[a] - negligible - from[a], to_high = to_low + 1 + 2 * negligible;
        if (way[a] == 0) {
          leaves = to_low <= 0 && to_high >= 0 ? leaves : -1;
          continue;
        }
        enters = std::max(enters, std::min(to_low / way[a], to_high / way[a]));
        leaves = std::min(leaves, std::max(to_low / way[a], to_high / way[a]));
      }
      if (enters <= leaves)
        first = std::min(first, enters);
    }
    return first;
  };
  for (const BodySurface::Face& face : surface_->faces())
    for (const std::int32_t corner : face.corners)
      if (face.axis == of_site.axis && face.upper == of_site.upper) {
        const Eigen::Vector3d at = to_tool * (surface_->position(corner) - site.tool->position);
        const double part = first_part(at.array() / spacing);
        if (part < 1)
          list.push_back({surface_->node(corner), (1 - part) * site.depth});
      }
  std::ranges::sort(list, {}, &Pressed::node);
  const auto same = std::ranges::unique(list, {}, &Pressed::node);
  list.erase(same.begin(), same.end());
  return list;
}

int ContactSolver::add_moves(const ContactSite& site, Scene& scene) const {
  const auto& face = surface_->faces()[site.face];
  std::vector<Prescribed> moves;
  for (const auto& [node, depth] : pressed(site)) {
    const Prescribed move{node, face.axis, face.upper ? -depth : depth, false};
    if (!std::ranges::binary_search(scene_->prescribed, move, is_before)) // held nodes stay
      moves.push_back(move);
  }
  scene.prescribed.insert(scene.prescribed.end(), moves.begin(), moves.end());
  std::ranges::sort(scene.prescribed, is_before);
  return static_cast<int>(moves.size());
}

Answer ContactSolver::answer(const Scene& scene, const Control& control) const {
  const std::lock_guard lock(kept_->mutex);
  return kept_->answers.answer(scene, control);
}

ContactStiffness ContactSolver::solve(const ContactSite& site, const Control& control) const {
  const auto begin = std::chrono::steady_clock::now();
  ContactStiffness result = estimate();
  result.number = site.number;
  result.depth = site.depth;
  Scene scene = *scene_;
  result.nodes = add_moves(site, scene);
  if (result.nodes == 0) {
    result.stiffness = std::numeric_limits<double>::infinity();
    return result;
  }
  const Answer pressed = answer(scene, control);
  result.status = pressed.status;
  if (is_converged(pressed.status)) {
    for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
      if (!scene.prescribed[i].held)
        result.reaction += pressed.reaction[i] * (scene.prescribed[i].value > 0 ? 1 : -1);
    result.stiffness = result.reaction / site.depth;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

ContactPhysics::ContactPhysics(const ContactSolver& solver, int threads)
    : solver_(&solver), threads_(threads), answers_(solver.estimate()), thread_([this] { serve(); }) {}

ContactPhysics::~ContactPhysics() {
  ending_ = true;
  thread_.join();
}

void ContactPhysics::serve() {
  Control control;
  control.threads = threads_;
  control.stop_requested = [this] { return ending_.load(std::memory_order_relaxed); };
  std::int64_t answers = 0;
  double slowest = 0;
  while (!ending_) {
    if (!sites_.update()) {
      std::this_thread::sleep_for(nap);
      continue;
    }
    ContactStiffness answer = solver_->solve(sites_.front(), control);
    if (answer.status == Status::interrupted)
      continue;
    answer.answers = ++answers;
    answer.slowest = slowest = std::max(slowest, answer.seconds);
    answers_.publish(answer);
  }
}

} // namespace maille::deform
