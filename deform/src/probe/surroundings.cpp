#include "maille/deform/probe/surroundings.hpp"

#include "world/first_contact.hpp"
#include "world/posed_shape.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace maille::deform {

namespace {

Eigen::Vector3d place_of(const RigidShape& tool, std::int32_t voxel, const Pose& pose) {
  const Index3 i = tool.index_of(voxel);
  const Vec3& h = tool.spacing();
  return pose.position +
         pose.rotation * Eigen::Vector3d((i[0] + 0.5) * h[0], (i[1] + 0.5) * h[1], (i[2] + 0.5) * h[2]);
}

/// The same motion, ended early.
RigidMotion part_of(const RigidMotion& motion, double fraction) {
  RigidMotion part = motion;
  part.by *= fraction;
  part.angle *= fraction;
  return part;
}

} // namespace

Surroundings::Surroundings(const OccupancyMap* map, const Vec3& cell_size,
                           std::vector<std::shared_ptr<const BodySurface>> bodies)
    : map_(map), cell_size_(cell_size), bodies_(std::move(bodies)) {
  for (const double size : cell_size)
    if (!(size > 0))
      throw std::invalid_argument("Surroundings: cells have sizes above 0");
}

std::optional<Obstacle> Surroundings::move(const RigidShape& tool, const RigidMotion& motion, Pose& pose,
                                           double& done) const {
  const Pose from = pose;
  std::optional<Obstacle> obstacle = move_before_bodies(tool, motion, from, done);
  if (map_ == nullptr) {
    pose = motion.moved(from, done);
    return obstacle;
  }
  const RigidMotion before = part_of(motion, done);
  double part = 0;
  if (const auto contact = move_until_contact(*map_, cell_size_, tool, before, pose, part)) {
    obstacle.emplace();
    obstacle->normal[contact->axis] = -contact->direction;
    obstacle->point = place_of(tool, contact->voxel, pose);
  }
  done *= part;
  return obstacle;
}

std::optional<Obstacle> Surroundings::move_before_bodies(const RigidShape& tool, const RigidMotion& motion,
                                                         const Pose& from, double& done) const {
  done = 1;
  std::optional<Obstacle> obstacle;
  if (bodies_.empty())
    return obstacle;
  const Pose end = motion.moved(from, 1);
  double time = 2; // of the first hit
  for (std::int32_t voxel = 0; voxel < tool.n_voxels(); ++voxel) {
    if (tool.open_sides(voxel) == 0)
      continue;
    const Eigen::Vector3d begin = place_of(tool, voxel, from), goal = place_of(tool, voxel, end);
    for (int number = 0; number < n_bodies(); ++number) {
      const auto hit = body(number).first_hit(begin, goal);
      if (!hit)
        continue;
      done = std::min(done, std::max(0.0, (hit->distance - body(number).skin()) / hit->towards));
      if (hit->time < time) {
        time = hit->time;
        obstacle = Obstacle{hit->normal, number, hit->face, begin + hit->time * (goal - begin)};
      }
    }
  }
  return obstacle;
}

std::int64_t Surroundings::n_inside(const RigidShape& tool, const Pose& pose) const {
  std::int64_t n = 0;
  any_voxel(PosedShape(tool, pose, cell_size_), 0, tool.n_voxels(),
            [&](std::int32_t voxel, const Index3& cell) {
              const bool in_cell = map_ != nullptr && map_->is_blocked(cell);
              n += in_cell || std::ranges::any_of(bodies_, [&](const auto& surface) {
                     return surface->is_inside(place_of(tool, voxel, pose));
                   });
              return false;
            });
  return n;
}

} // namespace maille::deform
