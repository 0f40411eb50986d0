#include "maille/deform/probe/servo_loop.hpp"

#include <memory>
#include <stdexcept>
#include <utility>

namespace maille::deform {

ToolSurroundings surroundings_of(const World& world, int tool) {
  const auto rigid = std::make_shared<RigidWorld>(world.map().cells(), world.cell_size());
  ToolSurroundings around;
  for (int object = 0; object < world.n_objects(); ++object)
    if (world.kind(object) == ObjectKind::deformable)
      around.bodies.push_back(std::make_shared<const BodySurface>(
          world.scene().objects[object].scene, world.displacement(object), world.pose(object)));
    else if (object != tool)
      rigid->add(world.shape(object), world.pose(object));
  around.matter = std::make_shared<const Surroundings>(&rigid->map(), world.cell_size(), around.bodies);
  around.rigid = rigid;
  return around;
}

ProbedWorld::ProbedWorld(const WorldScene& scene, int tool, double radius) {
  const World world(scene); // also checks for overlaps
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
  around_ = surroundings_of(world, tool);
  for (const WorldObject& object : scene.objects)
    if (object.kind == ObjectKind::deformable)
      add_body(object.name, object.scene, radius);
}

ProbedWorld::ProbedWorld(const Scene& scene, double radius)
    : tool_(std::make_unique<RigidShape>(point_tool(scene.specimen.grid.spacing()))) {
  around_.bodies = {std::make_shared<const BodySurface>(scene, Displacement(), Pose{})};
  around_.matter =
      std::make_shared<const Surroundings>(nullptr, scene.specimen.grid.spacing(), around_.bodies);
  add_body(scene.name, scene, radius);
}

void ProbedWorld::add_body(const std::string& name, const Scene& scene, double radius) {
  auto own = std::make_unique<Scene>(scene);
  std::erase_if(own->prescribed, [](const Prescribed& p) { return !p.held; });
  own->turns.clear();
  own->tractions.clear();
  own->gravity = {0, 0, 0};
  own->active_stress.clear();
  auto solver = std::make_unique<ContactSolver>(*own, around_.bodies[bodies_.size()], radius, tool_.get());
  bodies_.push_back({name, std::move(own), std::move(solver)});
}

std::int64_t ProbedWorld::bytes() const {
  std::int64_t sum = around_.rigid ? around_.rigid->bytes() : 0;
  for (const auto& surface : around_.bodies)
    sum += surface->bytes();
  return sum;
}

} // namespace maille::deform
