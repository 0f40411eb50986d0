#include "world/balance/balance.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <ranges>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Spring on a free object at its pose at the start of a round, in stiffnesses of a cell of the stiffest
/// body. The inverse is the spring between a driven object and its target. A stiffer spring takes more
/// rounds, a softer one loses digits.
constexpr double free_drag = 1e-4;
/// Largest number of components of a body in 2D: its factor grows faster than the body. Larger bodies are
/// refused.
constexpr std::int64_t most_components_2d = 400'000;

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

} // namespace

Balance::Balance(WorldObjects& world) : world_(world) {
  if (world.scene.dimension == 1)
    throw std::invalid_argument("World: contact = \"surfaces\": two or three dimensions");
  if (world.scene.method != "coupled")
    throw std::invalid_argument("World: contact = \"surfaces\": method = \"coupled\", which knows forces");
  if (world.scene.friction > 0 && world.scene.dynamics)
    throw std::invalid_argument("World: dynamics: no friction");
  cell_ = std::numeric_limits<double>::infinity();
  double stiffest = 0;
  for (int object = 0; object < world.n_objects(); ++object) {
    const WorldObject& what = world.scene.objects[object];
    const auto fail = [&](const std::string& why) {
      throw std::invalid_argument("World: contact = \"surfaces\": object `" + what.name + "` " + why);
    };
    const Vec3& spacing = what.scene.specimen.grid.spacing();
    cell_ = std::min(cell_, *std::min_element(spacing.begin(), spacing.begin() + world.scene.dimension));
    objects_.emplace_back(world, object);
    if (!world.is_body(object))
      continue;
    const DeformableObject& body = world.body(object);
    if (body.limits_bind())
      fail("has limits that bind: contact = \"cells\" keeps them");
    if (what.scene.strain == Strain::finite)
      fail("measures strains in blocks: contact = \"cells\" knows them");
    if (world.scene.dimension == 2 && 2 * body.lattice().n_voxels() > most_components_2d)
      fail("has too many nodes to factor its stiffness: contact = \"cells\", or a coarser body");
    stiffest = std::max(stiffest, body.cell_stiffness());
  }
  if (stiffest > 0)
    stiffness_ = stiffest;
  hold(1);
  find_touches();
  for (const Touch& touch : touches_)
    if (touch.gap < -overlap_over_cell * cell_)
      fail_to_place(world_.scene, touch.object, touch.other);
  for (int i = 0; i < world.n_objects(); ++i)
    for (int a = 0; a < world.scene.dimension && world.is_body(i); ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const double end = world.scene.cells[axis] * world.scene.spacing[axis],
                   little = overlap_over_cell * cell_;
      if (object(i).box.min()[a] < -little || object(i).box.max()[a] > end + little)
        fail_to_place(world_.scene, i, -1);
    }
  for (const auto& [i, j, nodes] : near_pairs_) // now, because set-up during contact would delay a frame
    for (const int number : {i, j})
      if (object(number).soft)
        object(number).soft->prepare();
}

void Balance::hold(int threads) {
  if (std::exchange(threads_, threads) != threads)
    for (SurfaceObject& one : objects_)
      if (one.soft)
        one.soft->forget_stiffness();
  for (int i = 0; i < world_.n_objects(); ++i) {
    SurfaceObject& one = object(i);
    if (one.soft) {
      const Pose& at_first = world_.body(i).lattice().pose();
      if (one.soft->hold(one.pose.rotation != at_first.rotation || one.pose.position != at_first.position,
                         threads_))
        distance_to_unloaded_ = cell_;
      one.rigid.hold(one.soft->floats(), stiffness_ * free_drag);
      continue;
    }
    const bool is_held = world_.member(i).is_driven;
    one.rigid.hold(one.kind == ObjectKind::rigid, is_held ? stiffness_ / free_drag : stiffness_ * free_drag);
    if (!is_held)
      one.rigid.target.reset();
    else if (!one.rigid.target)
      one.rigid.target = one.pose;
  }
  prescribe();
}

void Balance::prescribe() {
  const auto may_change = [&](int i) {
    const SurfaceObject& one = object(i);
    return one.is_body() &&
           (one.soft->floats() || one.soft->is_carried() || !world_.body(i).handles().empty());
  };
  if (std::ranges::any_of(std::views::iota(0, world_.n_objects()), may_change))
    catch_up(); // before the unloaded displacement of any body changes
  for (SurfaceObject& one : objects_)
    if (const double change = one.soft ? one.soft->prescribe() : 0; change > rounding * cell_)
      distance_to_unloaded_ += change;
}

double Balance::missed(int number, std::int64_t component) const {
  const SurfaceObject& one = object(number);
  const DeformableObject& body = world_.body(number);
  const PosedLattice& lattice = body.lattice();
  const auto voxel = static_cast<std::int32_t>(component / one.dimension);
  const int b = static_cast<int>(component % one.dimension);
  const Vec3 rest = body.scene().specimen.position(body.scene().specimen.grid.node_at(lattice.node(voxel)));
  const Eigen::Vector3d x = vector(rest) + one.soft->displacement_at(component - b);
  const Vec3 now = lattice.displacement_at(voxel, one.pose.position + one.pose.rotation * x);
  const auto handle = body.handles().find(lattice.node(voxel));
  const bool is_hold = std::ranges::any_of(body.scene().prescribed, [&](const Prescribed& p) {
    return p.node == lattice.node(voxel) && p.component == b;
  });
  const double wanted = is_hold || handle == body.handles().end() ? 0 : handle->second.at[b];
  return now[b] - wanted;
}

Vec3 Balance::pull_at(int number, std::int64_t node) const {
  const SurfaceObject& one = object(number);
  Vec3 force{};
  for (int b = 0; b < one.dimension; ++b)
    force[b] = one.soft->pull_at(std::int64_t{one.dimension} * world_.body(number).lattice().voxel(node) + b);
  return force;
}

void Balance::hand_back() {
  const auto start = std::chrono::steady_clock::now();
  catch_up();
  std::vector<Pose> poses(world_.rigid.n_objects());
  for (int i = 0; i < world_.n_objects(); ++i)
    if (!world_.is_body(i))
      poses[world_.member(i).index] = object(i).pose;
  world_.rigid.place(poses);
  world_.is_map_outdated = true;
  for (int i = 0; i < world_.n_objects(); ++i) {
    if (!world_.is_body(i))
      continue;
    const SurfaceObject& one = object(i);
    DeformableObject& body = world_.body(i);
    const PosedLattice& lattice = body.lattice();
    const bool is_carried = one.pose.rotation != lattice.pose().rotation ||
                            one.pose.position != lattice.pose().position; // its frame has moved
    Displacement state = body.displacement();
    for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel) {
      const std::int64_t node = lattice.node(voxel);
      Eigen::Vector3d u = one.soft->displacement_at(std::int64_t{one.dimension} * voxel);
      if (one.rigid.moves() || is_carried) {
        const Vec3 rest = body.scene().specimen.position(body.scene().specimen.grid.node_at(node));
        const Vec3 moved =
            lattice.displacement_at(voxel, one.pose.position + one.pose.rotation * (vector(rest) + u));
        u = vector(moved);
      }
      for (int b = 0; b < one.dimension; ++b)
        state(b, node) = u[b];
    }
    body.set_state(state);
  }
  seconds_to_hand_back_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace maille::deform
