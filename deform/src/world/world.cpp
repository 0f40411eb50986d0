#include "maille/deform/world/world.hpp"

#include "world/balance/balance.hpp"
#include "world/cell_overlap.hpp"
#include "world/dynamics/dynamics.hpp"
#include "world/dynamics/soft_dynamics.hpp"
#include "world/occupancy/posed_shape.hpp"
#include "world/voxels/single_voxels.hpp"
#include "world/world_parts.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::invalid_argument("World: " + what);
}

Pose pose_of(const WorldObject& object, int dimension) {
  Pose pose;
  for (int a = 0; a < dimension; ++a)
    pose.position[a] = object.position[static_cast<std::size_t>(a)];
  if (object.turn_angle != 0) {
    const Eigen::Vector3d axis(object.turn_axis[0], object.turn_axis[1], object.turn_axis[2]);
    pose.rotation = Eigen::AngleAxisd(object.turn_angle, axis).toRotationMatrix();
  }
  return pose;
}

void check(const WorldScene& scene) {
  if (scene.dimension < 1 || scene.dimension > 3)
    fail("one to three dimensions");
  for (std::size_t a = static_cast<std::size_t>(scene.dimension); a < 3; ++a)
    if (scene.cells[a] != 1)
      fail("one cell along an axis beyond the dimension");
  if (scene.method != "limits" && scene.method != "relaxed" && scene.method != "coupled" &&
      scene.method != "sweep" && scene.method != "hand_on")
    fail("the method `" + scene.method +
         "` moves no deformable objects: limits, relaxed, coupled, sweep and hand_on do");
  if (scene.is_open && (scene.method == "sweep" || scene.method == "hand_on"))
    fail("the method `" + scene.method + "`: a world with cells");
  if (!(scene.friction >= 0) || !std::isfinite(scene.friction))
    fail("a coefficient of friction is 0 or more");
  if (scene.dynamics && scene.contact != ContactLaw::surfaces)
    fail("dynamics: contact = \"surfaces\", which knows impulses");
  if (scene.is_open && (scene.objects.size() != 1 || scene.objects[0].kind != ObjectKind::deformable))
    fail("an open world is of one deformable object");
  for (const WorldObject& object : scene.objects) {
    if (object.scene.dimension() != scene.dimension)
      fail("object `" + object.name + "` is not of the world's dimension");
    const double length = std::hypot(object.turn_axis[0], object.turn_axis[1], object.turn_axis[2]);
    if (object.turn_angle != 0 && !(std::abs(length - 1) < 1e-9))
      fail("object `" + object.name + "` is turned about an axis that is not of length 1");
  }
}

RigidShape shape_of(const Specimen& specimen, const WorldScene& scene) {
  const Grid& grid = specimen.grid;
  std::vector<std::uint8_t> matter(static_cast<std::size_t>(grid.n_cells()));
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    matter[static_cast<std::size_t>(cell)] = specimen.is_matter(cell);
  Vec3 spacing = grid.spacing();
  for (std::size_t a = static_cast<std::size_t>(scene.dimension); a < 3; ++a)
    spacing[a] = scene.spacing[a];
  return {grid.cells(), spacing, matter};
}

} // namespace

void fail_to_place(const WorldScene& scene, int object, int other) {
  const auto name = [&](int of) { return "`" + scene.objects[static_cast<std::size_t>(of)].name + "` "; };
  fail("object " + name(object) +
       (other < 0 ? std::string("reaches beyond the border") : "is where " + name(other) + "is"));
}

WorldParts::WorldParts(WorldScene asked)
    : scene((check(asked), std::move(asked))), rigid(scene.cells, scene.spacing) {
  if (scene.is_open) {
    lone.emplace(scene.objects.front(), scene);
    members.push_back({ObjectKind::deformable, 0, 0});
    by_number.push_back(0);
    return;
  }
  const int n = static_cast<int>(scene.objects.size());
  members.resize(scene.objects.size());
  for (const bool bodies_now : {false, true}) // numbers of the map: rigid and fixed objects first
    for (int object = 0; object < n; ++object) {
      member(object).kind = scene.objects[static_cast<std::size_t>(object)].kind;
      if ((member(object).kind == ObjectKind::deformable) == bodies_now)
        bodies_now ? add_body(object) : add_rigid(object);
    }
  check_apart();
  if (scene.method == "hand_on")
    check_single_voxels(*this);
  if (scene.contact == ContactLaw::surfaces)
    balance = std::make_unique<Balance>(*this);
  if (scene.dynamics && bodies.empty())
    dynamics = std::make_unique<Dynamics>(*this);
  else if (scene.dynamics)
    soft_dynamics = std::make_unique<SoftDynamics>(*this);
}

/// Cells of the world do not tell thin overlaps apart. What is smooth stands elsewhere than its voxels:
/// Balance looks at its surface.
void WorldParts::check_apart() const {
  const auto pose_in_world = [this](const WorldObject& object) {
    Pose pose = pose_of(object, scene.dimension);
    for (int a = 0; a < scene.dimension; ++a)
      pose.position += pose.rotation.col(a) * object.scene.specimen.origin[static_cast<std::size_t>(a)];
    return pose;
  };
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const WorldObject &one = scene.objects[i], &other = scene.objects[j];
      if (one.is_smooth || other.is_smooth ||
          (one.kind == ObjectKind::fixed && other.kind == ObjectKind::fixed))
        continue;
      const Vec3 &edges = one.scene.specimen.grid.spacing(),
                 &other_edges = other.scene.specimen.grid.spacing();
      const double edge =
          std::min(*std::min_element(edges.begin(), edges.begin() + scene.dimension),
                   *std::min_element(other_edges.begin(), other_edges.begin() + scene.dimension));
      if (is_matter_in(one.scene.specimen, pose_in_world(one), other.scene.specimen, pose_in_world(other),
                       overlap_over_cell * edge))
        fail_to_place(scene, static_cast<int>(i), static_cast<int>(j));
    }
}

WorldParts::WorldParts(const WorldParts& other, LoneBody body)
    : scene(other.scene), rigid(other.rigid), members(other.members), lone(std::move(body)),
      by_number(other.by_number) {}

WorldParts::WorldParts(const WorldParts& other)
    : scene(other.scene), rigid(other.rigid), members(other.members), bodies(other.bodies),
      pushes(other.pushes), by_number(other.by_number) {}

WorldParts::~WorldParts() = default;

void WorldParts::add_rigid(int object) {
  const WorldObject& what = scene.objects[static_cast<std::size_t>(object)];
  Pose pose = pose_of(what, scene.dimension);
  const Vec3& origin = what.scene.specimen.origin;
  for (int a = 0; a < scene.dimension; ++a)
    pose.position += pose.rotation.col(a) * origin[static_cast<std::size_t>(a)];
  member(object).first = rigid.n_voxels();
  // Two may meet in a cell: check_apart looks at their matter, but what is smooth stands elsewhere.
  const bool may_meet =
      scene.contact == ContactLaw::surfaces && std::ranges::none_of(scene.objects, &WorldObject::is_smooth);
  const auto added = rigid.add(shape_of(what.scene.specimen, scene), pose, may_meet);
  if (!added.object)
    fail_to_place(scene, object, added.refused_at ? object_in(added.refused_at->cell) : -1);
  member(object).index = *added.object;
  by_number.push_back(object);
}

void WorldParts::add_body(int object) {
  const WorldObject& what = scene.objects[static_cast<std::size_t>(object)];
  const VoxelId first = bodies.empty() ? rigid.n_voxels() : bodies.back().end_of_ids();
  member(object).first = first;
  member(object).index = static_cast<int>(bodies.size());
  DeformableObject& body = bodies.emplace_back(what, pose_of(what, scene.dimension), scene, first);
  for (std::int32_t voxel = 0; voxel < body.lattice().n_voxels(); ++voxel) {
    const Index3 cell = cell_at(body.lattice().place(voxel, body.displacement()));
    const bool is_blocked = body.cells().is_blocked(map(), cell);
    if (is_blocked && scene.contact == ContactLaw::surfaces)
      continue; // two may meet in a cell: Balance looks at their surfaces
    if (is_blocked)
      fail_to_place(scene, object, object_in(cell));
    body.cells().put(map(), voxel, cell);
  }
  for (std::int32_t point = 0; point < body.matter().n_points(); ++point)
    if (const Index3 cell = cell_at(body.matter().place(point, body.lattice(), body.displacement()));
        scene.contact != ContactLaw::surfaces && body.cells().is_blocked(map(), cell))
      fail_to_place(scene, object, object_in(cell));
  body.put_matter(map());
  by_number.push_back(object);
}

int WorldParts::object_in(const Index3& cell) {
  const OccupancyMap& cells = map();
  if (!cells.has_cell(cell) || !cells.is_occupied(cell))
    return -1;
  const auto after = std::upper_bound(by_number.begin(), by_number.end(), cells.occupant(cell),
                                      [this](VoxelId id, int object) { return id < member(object).first; });
  return *(after - 1);
}

std::int64_t WorldParts::voxel_of(int object, VoxelId id) const {
  const VoxelId within = id - member(object).first;
  if (!is_body(object))
    return within;
  const DeformableObject& of = body(object);
  const std::int32_t n = of.lattice().n_voxels();
  return of.lattice().node(within < n ? within : of.matter().corners(within - n).front());
}

World::World(WorldScene scene) : parts_(std::make_unique<WorldParts>(std::move(scene))) {}
World::World(std::unique_ptr<WorldParts> parts) : parts_(std::move(parts)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

const WorldScene& World::scene() const {
  return parts_->scene;
}

const OccupancyMap& World::map() const {
  return parts_->map();
}

const Vec3& World::cell_size() const {
  return parts_->scene.spacing;
}

int World::n_objects() const {
  return parts_->n_objects();
}

ObjectKind World::kind(int object) const {
  return parts_->member(object).kind;
}

const RigidShape& World::shape(int object) const {
  return parts_->rigid.shape(parts_->member(object).index);
}

const Pose& World::pose(int object) const {
  static const Pose of_the_world;
  if (parts_->lone)
    return of_the_world;
  return parts_->is_body(object) ? parts_->body(object).lattice().pose()
                                 : parts_->rigid.pose(parts_->member(object).index);
}

const Displacement& World::displacement(int object) const {
  return parts_->lone ? parts_->lone->displacement() : parts_->body(object).displacement();
}

std::shared_ptr<const Displacement> World::shared_displacement(int object) const {
  return parts_->lone ? parts_->lone->shared_displacement()
                      : std::make_shared<const Displacement>(parts_->body(object).displacement());
}

void World::prepare(const FrameBudget& budget) {
  if (parts_->lone)
    parts_->lone->prepare(budget);
}

Eigen::Vector3d World::position(int object, std::int64_t node) const {
  if (parts_->lone)
    return parts_->lone->position(node);
  const PosedLattice& lattice = parts_->body(object).lattice();
  return lattice.position(lattice.voxel(node), displacement(object));
}

ObjectMotion World::motion(int object) const {
  if (parts_->soft_dynamics)
    return parts_->soft_dynamics->motion(object);
  if (!parts_->dynamics)
    return {};
  const MovingObject& one = parts_->dynamics->moving()[static_cast<std::size_t>(object)];
  return {one.mass, one.velocity, one.spin, one.place(parts_->balance->object(object).pose)};
}

double World::energy() const {
  if (parts_->soft_dynamics)
    return parts_->soft_dynamics->energy();
  return parts_->dynamics ? parts_->dynamics->energy() : 0;
}

bool World::is_closed(int object) const {
  return !parts_->lone && parts_->body(object).is_closed();
}

void World::release(int object) {
  parts_->member(object).is_driven = false;
  if (parts_->lone) {
    parts_->lone->release();
  } else if (parts_->is_body(object)) {
    DeformableObject& body = parts_->body(object);
    parts_->member(object).is_unsettled |= body.knows_forces() && !body.handles().empty();
    body.handles().clear();
  }
}

std::optional<World> World::copy() const {
  if (parts_->balance)
    return std::nullopt;
  if (!parts_->lone)
    return World(std::make_unique<WorldParts>(*parts_));
  auto body = parts_->lone->copy();
  if (!body)
    return std::nullopt;
  return World(std::make_unique<WorldParts>(*parts_, std::move(*body)));
}

bool World::is_settled() const {
  if (parts_->dynamics || parts_->soft_dynamics)
    return false; // time goes on
  return parts_->lone ? parts_->lone->is_settled()
                      : std::ranges::none_of(parts_->members, &WorldParts::Member::is_unsettled);
}

Scene World::question(int object) const {
  return parts_->lone ? parts_->lone->question() : parts_->body(object).question();
}

World::Occupant World::occupant(VoxelId id) const {
  const auto after =
      std::upper_bound(parts_->by_number.begin(), parts_->by_number.end(), id,
                       [this](VoxelId wanted, int object) { return wanted < parts_->member(object).first; });
  const int object = *(after - 1);
  return {object, parts_->voxel_of(object, id)};
}

std::vector<WorldContact> World::touched(int object, double reach) const {
  std::vector<WorldContact> list;
  const int index = parts_->member(object).index;
  parts_->map(); // in which they are found
  for (const Contact& contact : parts_->rigid.touched(index, reach)) {
    const Occupant other = occupant(contact.other);
    list.push_back(
        {object, contact.voxel, other.object, other.voxel, contact.axis, contact.direction, {0, 0, 0}});
  }
  return list;
}

std::vector<World::Occupant> World::voxels_in(const Index3& cell) const {
  std::vector<Occupant> list;
  const int object = parts_->object_in(cell);
  if (object < 0)
    return list;
  if (parts_->is_body(object)) {
    const DeformableObject& body = parts_->body(object);
    for (const std::int32_t voxel : body.cells().voxels_in(map(), cell))
      list.push_back({object, body.lattice().node(voxel)});
    return list;
  }
  const PosedShape posed(shape(object), pose(object), cell_size());
  any_voxel(posed, 0, shape(object).n_voxels(), [&](std::int32_t voxel, const Index3& at) {
    if (at == cell)
      list.push_back({object, voxel});
    return false;
  });
  return list;
}

std::int64_t World::n_shared_cells() const {
  if (parts_->lone)
    return 0;
  OccupancyMap owners(parts_->rigid.map().cells()); // object numbers in place of voxels'
  std::int64_t n = 0;
  const auto look = [&](int object, const Index3& cell) {
    if (!owners.has_cell(cell) || (owners.is_occupied(cell) && owners.occupant(cell) != object))
      ++n;
    else
      owners.put(cell, object);
  };
  for (int object = 0; object < n_objects(); ++object) {
    if (parts_->is_body(object)) {
      const PosedLattice& lattice = parts_->body(object).lattice();
      for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel)
        look(object, cell_at(lattice.place(voxel, displacement(object))));
      continue;
    }
    any_voxel(PosedShape(shape(object), pose(object), cell_size()), 0, shape(object).n_voxels(),
              [&](std::int32_t, const Index3& cell) {
                look(object, cell);
                return false;
              });
  }
  return n;
}

double World::largest_violation() const {
  double largest = parts_->lone ? parts_->lone->largest_violation() : 0;
  for (const DeformableObject& body : parts_->bodies)
    largest = std::max(largest, body.largest_violation());
  return largest;
}

std::int64_t World::bytes() const {
  std::int64_t sum = parts_->rigid.bytes() + (parts_->lone ? parts_->lone->bytes() : 0);
  for (const DeformableObject& body : parts_->bodies)
    sum += body.bytes();
  return sum;
}

} // namespace maille::deform
