#include "world/world_objects.hpp"

#include "maille/deform/world/trajectory_drives.hpp"
#include "world/cell_overlap.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::invalid_argument("World: " + what);
}

/// Pose of the corner of its specimen's grid.
Pose pose_of_grid(const WorldObject& object, int dimension) {
  Pose pose = frame_of(object);
  for (int a = 0; a < dimension; ++a)
    pose.position += pose.rotation.col(a) * object.scene.specimen.origin[a];
  return pose;
}

void check(const WorldScene& scene) {
  if (scene.dimension < 1 || scene.dimension > 3)
    fail("one to three dimensions");
  for (std::size_t a = static_cast<std::size_t>(scene.dimension); a < 3; ++a)
    if (scene.cells[a] != 1)
      fail("one cell along an axis beyond the dimension");
  if (scene.method != "limits" && scene.method != "relaxed" && scene.method != "coupled")
    fail("the method `" + scene.method + "` moves no deformable objects: limits, relaxed and coupled do");
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
  std::vector<std::uint8_t> matter(grid.n_cells());
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    matter[cell] = specimen.is_matter(cell);
  Vec3 spacing = grid.spacing();
  for (std::size_t a = static_cast<std::size_t>(scene.dimension); a < 3; ++a)
    spacing[a] = scene.spacing[a];
  return {grid.cells(), spacing, matter};
}

} // namespace

void fail_to_place(const WorldScene& scene, int object, int other) {
  const auto name = [&](int of) { return "`" + scene.objects[of].name + "` "; };
  fail("object " + name(object) +
       (other < 0 ? std::string("reaches beyond the border") : "is where " + name(other) + "is"));
}

WorldObjects::WorldObjects(WorldScene asked)
    : scene((check(asked), std::move(asked))), rigid(scene.cells, scene.spacing) {
  if (scene.is_open) {
    members.push_back({ObjectKind::deformable, 0, 0});
    by_number.push_back(0);
    return;
  }
  const int n = static_cast<int>(scene.objects.size());
  members.resize(scene.objects.size());
  for (const bool bodies_now : {false, true}) // numbers of the map: rigid and fixed objects first
    for (int object = 0; object < n; ++object) {
      member(object).kind = scene.objects[object].kind;
      if ((member(object).kind == ObjectKind::deformable) == bodies_now)
        bodies_now ? add_body(object) : add_rigid(object);
    }
  check_apart();
}

/// Refuses initial overlaps by geometry, because cells of the world do not resolve thin overlaps. A
/// SurfaceEngine checks smooth objects: their surface differs from their voxels.
void WorldObjects::check_apart() const {
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
      if (is_matter_in(one.scene.specimen, pose_of_grid(one, scene.dimension), other.scene.specimen,
                       pose_of_grid(other, scene.dimension), overlap_over_cell * edge))
        fail_to_place(scene, static_cast<int>(i), static_cast<int>(j));
    }
}

void WorldObjects::add_rigid(int object) {
  const Specimen& specimen = this->object(object).scene.specimen;
  member(object).first = rigid.n_voxels();
  // Two objects may share a cell: check_apart() compares their matter, except for smooth objects.
  const bool may_meet =
      scene.contact == ContactLaw::surfaces && std::ranges::none_of(scene.objects, &WorldObject::is_smooth);
  const auto added =
      rigid.add(shape_of(specimen, scene), pose_of_grid(this->object(object), scene.dimension), may_meet);
  if (!added.object)
    fail_to_place(scene, object, added.refused_at ? object_in(added.refused_at->cell) : -1);
  member(object).index = *added.object;
  by_number.push_back(object);
}

void WorldObjects::add_body(int object) {
  const WorldObject& what = scene.objects[object];
  const VoxelId first = bodies.empty() ? rigid.n_voxels() : bodies.back().end_of_ids();
  member(object).first = first;
  member(object).index = static_cast<int>(bodies.size());
  DeformableObject& body = bodies.emplace_back(what, frame_of(what), scene, first);
  for (std::int32_t voxel = 0; voxel < body.lattice().n_voxels(); ++voxel) {
    const Index3 cell = cell_at(body.lattice().place(voxel, body.displacement()));
    const bool is_blocked = body.cells().is_blocked(map(), cell);
    if (is_blocked && scene.contact == ContactLaw::surfaces)
      continue; // two objects may share a cell: surfaces are checked later
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

int WorldObjects::object_in(const Index3& cell) {
  const OccupancyMap& cells = map();
  if (!cells.has_cell(cell) || !cells.is_occupied(cell))
    return -1;
  return object_of(cells.occupant(cell));
}

int WorldObjects::object_of(VoxelId id) const {
  const auto after =
      std::upper_bound(by_number.begin(), by_number.end(), id,
                       [this](VoxelId wanted, int object) { return wanted < member(object).first; });
  return *(after - 1);
}

std::string WorldObjects::name(int number) const {
  return number < 0 ? "the border of the world" : object(number).name;
}

std::int64_t WorldObjects::voxel_of(int object, VoxelId id) const {
  const VoxelId within = id - member(object).first;
  if (!is_body(object))
    return within;
  const DeformableObject& of = body(object);
  const std::int32_t n = of.lattice().n_voxels();
  return of.lattice().node(within < n ? within : of.matter().corners(within - n).front());
}

} // namespace maille::deform
