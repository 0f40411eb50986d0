#pragma once
/// A scene as a probe meets it.

#include "maille/deform/probe/contact_stiffness.hpp"
#include "maille/deform/probe/proxy.hpp"
#include "maille/scene/world_scene.hpp"

#include <memory>
#include <string>
#include <vector>

namespace maille::deform {

/// Fixed and rigid objects in one map, the surfaces of deformable ones at rest, and what answers how stiff these are. Nothing of it moves but
/// the probe's tool.
class ProbedWorld {
public:
  /// @param tool the rigid object that the hand holds; -1: a point of one cell's voxel @param radius of the footprint, see ContactSolver [m]
  /// @throws std::invalid_argument for objects that overlap, deformable ones of other than three dimensions, a tool that is not rigid
  ProbedWorld(const WorldScene& scene, int tool, double radius);
  /// One deformable body without walls about it: of the scene its body, materials, limits and holds. A point is the tool.
  ProbedWorld(const Scene& scene, double radius);

  const std::shared_ptr<const Surroundings>& surroundings() const { return surroundings_; }
  const RigidShape& tool() const { return *tool_; }
  /// Of the tool's middle in the scene; of a point: nothing.
  const std::optional<Pose>& start() const { return start_; }
  int n_bodies() const { return static_cast<int>(bodies_.size()); }
  const std::string& name(int body) const { return at(body).name; }
  const ContactSolver& solver(int body) const { return *at(body).solver; }
  const Scene& scene(int body) const { return *at(body).scene; }
  std::int64_t bytes() const;

private:
  struct Body {
    std::string name;
    std::unique_ptr<Scene> scene;
    std::shared_ptr<const BodySurface> surface;
    std::unique_ptr<ContactSolver> solver;
  };

  const Body& at(int body) const { return bodies_[static_cast<std::size_t>(body)]; }
  void add_body(const std::string& name, const Scene& scene, const Pose& pose, double radius);
  void surround(const OccupancyMap* map, const Vec3& cell_size);

  std::unique_ptr<RigidWorld> rigid_;
  std::vector<Body> bodies_;
  std::optional<RigidShape> tool_;
  std::optional<Pose> start_;
  std::shared_ptr<const Surroundings> surroundings_;
};

} // namespace maille::deform
