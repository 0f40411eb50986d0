#include "maille/deform/probe/touch.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/first_contact.hpp"
#include "world/occupancy/posed_shape.hpp"
#include "world/touch/allowed_twist.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace maille::deform {

namespace {

Eigen::Vector3d place_of(const RigidShape& tool, std::int32_t voxel, const Pose& pose) {
  return pose.position + pose.rotation * tool.centre_of(voxel);
}

/// Normal, in the tool's lattice, of the constraint by the open face of a voxel that a point is nearest to,
/// or beyond.
Eigen::Vector3d face_before(const RigidShape& tool, std::int32_t voxel, const Pose& pose,
                            const Eigen::Vector3d& point) {
  const Eigen::Vector3d at = pose.rotation.transpose() * (point - pose.position);
  const Index3 index = tool.index_of(voxel);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double furthest = -1e300;
  for (int a = 0; a < 3; ++a)
    for (int upper = 0; upper < 2; ++upper) {
      if ((tool.open_sides(voxel) >> (2 * a + upper) & 1) == 0)
        continue;
      const auto i = static_cast<std::size_t>(a);
      const double out = (upper ? 1 : -1) * (at[a] - (index[i] + upper) * tool.spacing()[i]);
      if (out > furthest) {
        furthest = out;
        normal.setZero();
        normal[a] = upper ? -1 : 1;
      }
    }
  return normal;
}

/// Calls visit(point) for the points of a voxel that are tested against surfaces, in the world: its middle,
/// and for tools of several voxels its protruding corners.
template<class Visit>
void for_each_point(const RigidShape& tool, std::int32_t voxel, const Pose& pose, Visit&& visit) {
  const unsigned open = tool.open_sides(voxel);
  if (open == 0)
    return;
  visit(place_of(tool, voxel, pose));
  if (tool.n_voxels() == 1)
    return;
  const Index3 i = tool.index_of(voxel);
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d x;
    bool sticks_out = true;
    for (int a = 0; a < 3; ++a) {
      const int upper = corner >> a & 1;
      sticks_out = sticks_out && (open >> (2 * a + upper) & 1) != 0;
      x[a] = (i[a] + upper) * tool.spacing()[a];
    }
    if (sticks_out)
      visit(pose.position + pose.rotation * x);
  }
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
    obstacle = met(*contact, tool, pose);
  }
  done *= part;
  return obstacle;
}

/// The obstacle of a contact: a face of a cell reached by a voxel's middle, or a face of a voxel reached by a
/// cell's middle.
Obstacle Surroundings::met(const Contact& contact, const RigidShape& tool, const Pose& pose) const {
  Obstacle obstacle;
  obstacle.point = place_of(tool, contact.voxel, pose);
  obstacle.normal[contact.axis] = -contact.direction;
  Eigen::Vector3d middle;
  bool is_at_the_face = true;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    middle[a] = (contact.cell[i] + 0.5) * cell_size_[i];
    const double off = std::abs(obstacle.point[a] / cell_size_[i] - contact.cell[i] - 0.5);
    is_at_the_face = is_at_the_face && (a == contact.axis ? std::abs(off - 0.5) < unnoticed_over_cell
                                                          : off < 0.5 + unnoticed_over_cell);
  }
  if (is_at_the_face)
    return obstacle;
  obstacle.normal = pose.rotation * face_before(tool, contact.voxel, pose, middle);
  obstacle.point = middle;
  return obstacle;
}

bool Surroundings::is_in_a_body(const RigidShape& tool, const Pose& pose) const {
  bool is_inside = false;
  for (std::int32_t voxel = 0; voxel < tool.n_voxels() && !is_inside; ++voxel)
    for_each_point(tool, voxel, pose, [&](const Eigen::Vector3d& at) {
      is_inside =
          is_inside || std::ranges::any_of(bodies_, [&](const auto& one) { return one->is_inside(at); });
    });
  return is_inside;
}

/// The obstacle of a tool that has just rotated into a body: opposite to the motion of the first voxel
/// inside.
Obstacle Surroundings::turned_into(const RigidShape& tool, const RigidMotion& motion,
                                   const Pose& pose) const {
  Obstacle obstacle;
  for (std::int32_t voxel = 0; voxel < tool.n_voxels() && obstacle.body < 0; ++voxel)
    for_each_point(tool, voxel, pose, [&](const Eigen::Vector3d& at) {
      for (int number = 0; number < n_bodies() && obstacle.body < 0; ++number)
        if (body(number).is_inside(at)) {
          const Eigen::Vector3d velocity = motion.by + motion.angle * motion.axis.cross(at - motion.about);
          obstacle = {-velocity.normalized(), number, -1, at};
        }
    });
  return obstacle;
}

/// Divides rotations into pieces whose arcs are at most a part of a cell. After each piece it tests whether
/// any voxel is in a body, because arcs deviate from their chords.
std::optional<Obstacle> Surroundings::move_before_bodies(const RigidShape& tool, const RigidMotion& motion,
                                                         const Pose& from, double& done) const {
  done = 1;
  if (bodies_.empty())
    return std::nullopt;
  if (motion.angle == 0)
    return go_straight(tool, from, motion.moved(from, 1), done);
  const double length = motion.by.norm() + std::abs(motion.angle) * furthest_corner(tool, from, motion.about);
  const double pieces =
      std::clamp(std::ceil(length / (step_over_cell * *std::ranges::min_element(cell_size_))), 1.0,
                 double{iteration_cap});
  for (double piece = 0; piece < pieces; ++piece) {
    const double begin = piece / pieces;
    double part = 1;
    auto obstacle =
        go_straight(tool, motion.moved(from, begin), motion.moved(from, (piece + 1) / pieces), part);
    done = begin + part / pieces;
    if (is_in_a_body(tool, motion.moved(from, done))) {
      double free = begin, blocked = done;
      for (double middle = 0.5 * (free + blocked); middle > free && middle < blocked;
           middle = 0.5 * (free + blocked))
        (is_in_a_body(tool, motion.moved(from, middle)) ? blocked : free) = middle;
      done = std::max(begin, free - 2 * body(0).skin() / length);
      if (!obstacle)
        obstacle = turned_into(tool, motion, motion.moved(from, blocked));
    }
    if (obstacle)
      return obstacle;
  }
  done = 1;
  return std::nullopt;
}

/// Moves along straight lines between poses. @param[out] done part of the way
std::optional<Obstacle> Surroundings::go_straight(const RigidShape& tool, const Pose& from, const Pose& end,
                                                  double& done) const {
  done = 1;
  std::optional<Obstacle> obstacle;
  double time = 2; // of the first hit
  for (std::int32_t voxel = 0; voxel < tool.n_voxels(); ++voxel)
    for_each_point(tool, voxel, from, [&](const Eigen::Vector3d& begin) {
      const Eigen::Vector3d goal =
          end.position + end.rotation * (from.rotation.transpose() * (begin - from.position));
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
    });
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
