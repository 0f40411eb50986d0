#include "maille/deform/probe/servo_loop.hpp"

#include "maille/deform/world/world.hpp"

#include <memory>
#include <stdexcept>
#include <utility>

namespace maille::deform {

ProbedWorld::ProbedWorld(const WorldScene& scene, int tool, double radius)
    : rigid_(std::make_unique<RigidWorld>(scene.cells, scene.spacing)) {
  const World world(scene); // which also finds out whether objects overlap
  if (tool >= world.n_objects() || (tool >= 0 && world.kind(tool) != ObjectKind::rigid))
    throw std::invalid_argument("ProbedWorld: a tool that is a rigid object");
  if (tool >= 0) {
    tool_ = std::make_unique<RigidShape>(world.shape(tool));
    Pose middle = world.pose(tool);
    for (int a = 0; a < 3; ++a)
      middle.position += middle.rotation.col(a) * 0.5 * tool_->size()[a] * tool_->spacing()[a];
    start_ = middle;
  } else {
    tool_ = std::make_unique<RigidShape>(point_tool(scene.spacing));
  }
  for (int object = 0; object < world.n_objects(); ++object) {
    const WorldObject& what = scene.objects[object];
    if (world.kind(object) == ObjectKind::deformable) {
      add_body(what.name, what.scene, world.pose(object), radius);
    } else if (object != tool) {
      rigid_->add(world.shape(object), world.pose(object));
    }
  }
  surround(&rigid_->map(), scene.spacing);
}

ProbedWorld::ProbedWorld(const Scene& scene, double radius)
    : tool_(std::make_unique<RigidShape>(point_tool(scene.specimen.grid.spacing()))) {
  add_body(scene.name, scene, {}, radius);
  surround(nullptr, scene.specimen.grid.spacing());
}

void ProbedWorld::add_body(const std::string& name, const Scene& scene, const Pose& pose, double radius) {
  Body body;
  body.name = name;
  body.scene = std::make_unique<Scene>(scene);
  Scene& own = *body.scene;
  std::erase_if(own.prescribed, [](const Prescribed& p) { return !p.held; });
  own.turns.clear();
  own.tractions.clear();
  own.gravity = {0, 0, 0};
  own.active_stress.clear();
  body.surface = std::make_shared<BodySurface>(own, Displacement(), pose);
  body.solver = std::make_unique<ContactSolver>(own, body.surface, radius, tool_.get());
  bodies_.push_back(std::move(body));
}

void ProbedWorld::surround(const OccupancyMap* map, const Vec3& cell_size) {
  std::vector<std::shared_ptr<const BodySurface>> surfaces;
  for (const Body& body : bodies_)
    surfaces.push_back(body.surface);
  surroundings_ = std::make_shared<Surroundings>(map, cell_size, std::move(surfaces));
}

std::int64_t ProbedWorld::bytes() const {
  std::int64_t sum = rigid_ ? rigid_->bytes() : 0;
  for (const Body& body : bodies_)
    sum += body.surface->bytes();
  return sum;
}

} // namespace maille::deform
