/// Scenes of worlds. Those without fault are looked at once more: objects of the world's dimension, with
/// names that tell them apart.

#include "fuzzing.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <cmath>
#include <set>

namespace maille::fuzzing {
namespace {

bool are_finite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void check_world(const WorldScene& world) {
  require(!world.objects.empty(), "objects");
  for (std::size_t axis = 0; axis < 3; ++axis)
    require(world.cells[axis] > 0 && world.spacing[axis] > 0 && std::isfinite(world.spacing[axis]), "cells");
  require(std::isfinite(world.friction) && world.friction >= 0, "a coefficient of friction");
  require(!world.frame_budget || *world.frame_budget > 0, "a budget that is one");
  std::set<std::string> names;
  for (const WorldObject& object : world.objects) {
    require(!object.name.empty() && names.insert(object.name).second, "a name for every object");
    require(object.scene.dimension() == world.dimension, "objects of the world's dimension");
    require(object.scene.specimen.n_matter_cells() > 0, "a body for every object");
    require(are_finite(object.position) && are_finite(object.turn_axis) && std::isfinite(object.turn_angle),
            "a place for every object");
    require(object.kind != ObjectKind::deformable || !object.scene.materials.empty(),
            "something that gives way");
  }
}

} // namespace
} // namespace maille::fuzzing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maille::set_file_scope(maille::FileScope::sandbox); // what is tried reads nothing but fixtures
  using namespace maille;
  return fuzzing::tried([&] {
    fuzzing::check_world(parse_world_scene(fuzzing::text_of(data, size), fuzzing::fixtures() / "scene.toml"));
  });
}
