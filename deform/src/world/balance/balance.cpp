#include "world/balance/balance.hpp"

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/plausibility.hpp"
#include "world/surface/smooth_surface.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <ranges>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Spring that keeps a free object where a round began, in stiffnesses of a cell of the stiffest body; its
/// inverse keeps a hand's object at its goal. A stiffer one takes more rounds, a softer one wastes digits.
constexpr double free_drag = 1e-4;
/// Components of a body in 2D [1]: its factor grows faster than the body, and larger ones are refused.
constexpr std::int64_t most_components_2d = 400'000;

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

Eigen::AlignedBox3d box_about(const std::vector<Eigen::Vector3d>& places) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& place : places)
    box.extend(place);
  return box;
}

/// Components of three nodes far from one another that leave a body no rigid motion and no strain.
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
    // A turn about the line moves the third node along this, and about the line alone it can still turn.
    const Eigen::Vector3d swing = ab.cross(within(c) - within(0));
    Eigen::Index component = 0;
    swing.cwiseAbs().maxCoeff(&component);
    list.push_back(std::int64_t{3} * c + component);
  }
  std::ranges::sort(list);
  return list;
}

/// True if fixing these components leaves the body no rigid motion.
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

BalancedObject::BalancedObject(const WorldObjects& world, int object)
    : dimension(world.scene.dimension), kind(world.member(object).kind),
      skin(world.scene.objects[static_cast<std::size_t>(object)].scene.specimen) {
  const Specimen& specimen = world.scene.objects[static_cast<std::size_t>(object)].scene.specimen;
  const Grid& grid = specimen.grid;
  for (std::int32_t node = 0; node < skin.n_nodes(); ++node) {
    const Index3 index = grid.node_at(skin.node(node));
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int a = 0; a < dimension; ++a)
      x[a] = index[static_cast<std::size_t>(a)] * grid.spacing()[static_cast<std::size_t>(a)];
    rest.push_back(is_body() ? vector(specimen.position(index)) : x);
  }
  if (is_body()) {
    const PosedLattice& lattice = world.body(object).lattice();
    pose = lattice.pose();
    for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
      first_component.push_back(std::int64_t{dimension} * lattice.voxel(skin.node(node)));
    displacement = unloaded = contact_forces = Eigen::VectorXd::Zero(dimension * lattice.n_voxels());
    std::vector<char> of_node(static_cast<std::size_t>(grid.n_nodes()), 0);
    for (const Prescribed& p : world.body(object).scene().prescribed)
      of_node[static_cast<std::size_t>(p.node)] |= static_cast<char>(1 << p.component);
    for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
      held.push_back(of_node[static_cast<std::size_t>(skin.node(node))]);
    move_all();
  } else {
    const int index = world.member(object).index;
    pose = world.rigid.pose(index);
    const RigidShape& shape = world.rigid.shape(index);
    std::vector<std::int32_t> by_cell(static_cast<std::size_t>(grid.n_cells()), -1);
    for (std::int32_t i = 0; i < shape.n_voxels(); ++i)
      by_cell[static_cast<std::size_t>(grid.cell(shape.index_of(i)))] = i;
    std::ranges::copy_if(by_cell, std::back_inserter(voxel), [](std::int32_t i) { return i >= 0; });
    if (world.scene.objects[static_cast<std::size_t>(object)].is_smooth)
      make_smooth(specimen, rest);
    const PlacedSkin placed(skin, rest, rest, 0);
    for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
      is_flat.push_back(std::ranges::all_of(skin.faces_at(node), [&](std::int32_t face) {
        return placed.normal_of(face).dot(placed.normal_of(skin.faces_at(node).front())) > 1 - rounding;
      }));
  }
  place();
}

bool BalancedObject::is_held_along(std::int32_t node, const Eigen::Vector3d& direction) const {
  if (kind != ObjectKind::deformable)
    return kind == ObjectKind::fixed;
  for (int a = 0; a < dimension; ++a)
    if (is_along(a, direction) && (held[static_cast<std::size_t>(node)] >> a & 1) == 0)
      return false;
  return !moves;
}

void BalancedObject::place(std::size_t node) {
  Eigen::Vector3d x = rest[node];
  if (is_body())
    x.head(dimension) += displacement.segment(first_component[node], dimension);
  at[node] = pose.position + pose.rotation * x;
}

void BalancedObject::place() {
  at.resize(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i)
    place(i);
  box = box_about(at);
  middle = centre ? Eigen::Vector3d(pose.position + pose.rotation * *centre) : box.center();
  radius = 0.5 * box.diagonal().norm();
}

void BalancedObject::place_watched() {
  for (const std::int32_t node : watched)
    place(static_cast<std::size_t>(node));
}

void BalancedObject::move_all() {
  if (moved.size() == place_of.size() && flexibility && flexibility->watches_all())
    return;
  moved.resize(static_cast<std::size_t>(displacement.size() / dimension));
  std::iota(moved.begin(), moved.end(), 0);
  place_of = moved;
  way.resize(0);
  if (flexibility)
    flexibility->watch(moved);
}

void BalancedObject::turn_and_shift(const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  if (const double angle = turn.norm(); angle > 0) {
    RigidMotion motion;
    motion.angle = angle;
    motion.axis = turn / angle;
    motion.about = middle;
    pose = motion.moved(pose, 1);
  }
  pose.position += shift;
}

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
    const WorldObject& what = world.scene.objects[static_cast<std::size_t>(object)];
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
    if (what.scene.relaxation.frame == StrainFrame::blocks)
      fail("measures strains in blocks: contact = \"cells\" knows them");
    if (world.scene.dimension == 2 && objects_.back().displacement.size() > most_components_2d)
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
  for (const auto& [i, j, nodes] : near_pairs_) // a hand would feel it when they touch
    for (const int number : {i, j})
      if (object(number).flexibility)
        object(number).flexibility->prepare();
}

void Balance::hold(int threads) {
  if (std::exchange(threads_, threads) != threads)
    for (BalancedObject& one : objects_)
      one.flexibility.reset();
  for (int i = 0; i < world_.n_objects(); ++i) {
    BalancedObject& one = object(i);
    if (one.is_body()) {
      hold_body(i);
      continue;
    }
    one.moves = one.kind == ObjectKind::rigid;
    const bool is_held = world_.member(i).is_driven;
    one.stiffness = is_held ? stiffness_ / free_drag : stiffness_ * free_drag;
    if (!is_held)
      one.target.reset();
    else if (!one.target)
      one.target = one.pose;
  }
  prescribe();
}

void Balance::hold_body(int number) {
  BalancedObject& one = object(number);
  const DeformableObject& body = world_.body(number);
  const PosedLattice& lattice = body.lattice();
  const int d = one.dimension;
  std::vector<std::int64_t> kept;
  for (const Prescribed& p : body.scene().prescribed)
    kept.push_back(std::int64_t{d} * lattice.voxel(p.node) + p.component);
  for (const auto& [node, handle] : body.handles())
    for (int b = 0; b < d; ++b)
      kept.push_back(std::int64_t{d} * lattice.voxel(node) + b);
  sort_uniquely(kept);
  if (one.inertia.size() > 0) { // nothing floats that has mass; what is held is not turned
    one.moves = false;
    one.pulled.clear();
    if (!one.flexibility || kept != one.fixed) {
      one.flexibility = std::make_unique<Flexibility>(body.scene(), kept, one.inertia, false, threads_);
      one.fixed = std::move(kept);
      one.move_all();
      behind_ = cell_; // by what contacts did before
    }
    return;
  }
  if (kept != one.kept) {
    one.kept = kept;
    one.is_kept = holds(body.scene(), lattice, kept);
  }
  const bool floats = !one.is_kept || one.pose.rotation != lattice.pose().rotation ||
                      one.pose.position != lattice.pose().position;
  one.moves = floats;
  one.stiffness = stiffness_ * free_drag;
  one.pulled = floats ? kept : std::vector<std::int64_t>{};
  if (floats)
    kept = supports(lattice);
  if (!one.flexibility || kept != one.fixed) { // what floats has others than what is held
    one.flexibility = std::make_unique<Flexibility>(body.scene(), kept, Eigen::VectorXd(), floats, threads_);
    one.fixed = std::move(kept);
    one.move_all();
    behind_ = cell_;
  }
}

void Balance::prescribe() {
  const auto may_change = [&](int i) {
    const BalancedObject& one = object(i);
    return one.is_body() && (one.moves || one.carried.size() > 0 || !world_.body(i).handles().empty());
  };
  if (std::ranges::any_of(std::views::iota(0, world_.n_objects()), may_change))
    catch_up(); // before any is somewhere else without contacts
  for (int i = 0; i < world_.n_objects(); ++i) {
    BalancedObject& one = object(i);
    if (!one.is_body())
      continue;
    Eigen::VectorXd given = one.displacement; // what floats stays where it is in its frame
    if (!one.moves) {
      given.setZero();
      const DeformableObject& body = world_.body(i);
      for (const auto& [node, handle] : body.handles())
        for (int b = 0; b < one.dimension; ++b)
          given[one.dimension * body.lattice().voxel(node) + b] = handle.at[static_cast<std::size_t>(b)];
      for (const Prescribed& p : body.scene().prescribed)
        given[one.dimension * body.lattice().voxel(p.node) + p.component] = 0;
    }
    Eigen::VectorXd unloaded = one.flexibility->moved(given);
    if (one.carried.size() > 0)
      unloaded += one.flexibility->solve(one.carried);
    if (const double change = (unloaded - one.unloaded).cwiseAbs().maxCoeff(); change > rounding * cell_)
      behind_ += change;
    one.unloaded = std::move(unloaded);
  }
}

double Balance::missed(int number, std::int64_t component) const {
  const BalancedObject& one = object(number);
  const DeformableObject& body = world_.body(number);
  const PosedLattice& lattice = body.lattice();
  const auto voxel = static_cast<std::int32_t>(component / one.dimension);
  const int b = static_cast<int>(component % one.dimension);
  const Vec3 rest = body.scene().specimen.position(body.scene().specimen.grid.node_at(lattice.node(voxel)));
  Eigen::Vector3d x = vector(rest);
  x.head(one.dimension) += one.displacement.segment(std::int64_t{one.dimension} * voxel, one.dimension);
  const Vec3 now = lattice.displacement_at(voxel, one.pose.position + one.pose.rotation * x);
  const auto handle = body.handles().find(lattice.node(voxel));
  const bool is_hold = std::ranges::any_of(body.scene().prescribed, [&](const Prescribed& p) {
    return p.node == lattice.node(voxel) && p.component == b;
  });
  const double wanted =
      is_hold || handle == body.handles().end() ? 0 : handle->second.at[static_cast<std::size_t>(b)];
  return now[static_cast<std::size_t>(b)] - wanted;
}

Vec3 Balance::pull_at(int number, std::int64_t node) const {
  const BalancedObject& one = object(number);
  const std::int64_t first = std::int64_t{one.dimension} * world_.body(number).lattice().voxel(node);
  Vec3 force{};
  for (int b = 0; b < one.dimension; ++b) {
    const auto component = static_cast<std::size_t>(b);
    const auto pulled = std::ranges::lower_bound(one.pulled, first + b);
    if (!one.moves)
      force[component] =
          one.flexibility->force_at(first + b, one.displacement) - one.contact_forces[first + b];
    else if (pulled != one.pulled.end() && *pulled == first + b && one.pull.size() > 0)
      force[component] = one.pull[pulled - one.pulled.begin()];
  }
  return force;
}

void Balance::hand_back() {
  const auto start = std::chrono::steady_clock::now();
  catch_up();
  std::vector<Pose> poses(static_cast<std::size_t>(world_.rigid.n_objects()));
  for (int i = 0; i < world_.n_objects(); ++i)
    if (!world_.is_body(i))
      poses[static_cast<std::size_t>(world_.member(i).index)] = object(i).pose;
  world_.rigid.place(poses);
  world_.is_map_outdated = true;
  for (int i = 0; i < world_.n_objects(); ++i) {
    if (!world_.is_body(i))
      continue;
    const BalancedObject& one = object(i);
    DeformableObject& body = world_.body(i);
    const PosedLattice& lattice = body.lattice();
    const bool is_carried = one.pose.rotation != lattice.pose().rotation ||
                            one.pose.position != lattice.pose().position; // its frame goes with it
    Displacement state = body.displacement();
    for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel) {
      const std::int64_t node = lattice.node(voxel);
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      u.head(one.dimension) = one.displacement.segment(std::int64_t{one.dimension} * voxel, one.dimension);
      if (one.moves || is_carried) {
        const Vec3 rest = body.scene().specimen.position(body.scene().specimen.grid.node_at(node));
        const Vec3 moved =
            lattice.displacement_at(voxel, one.pose.position + one.pose.rotation * (vector(rest) + u));
        u = vector(moved);
      }
      for (int b = 0; b < one.dimension; ++b)
        state(b, node) = u[b];
    }
    body.stand_at(state);
  }
  seconds_to_hand_back_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace maille::deform
