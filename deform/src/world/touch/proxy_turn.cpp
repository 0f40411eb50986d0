/// Combined rotation and shift of a tool of several voxels towards the goal.

#include "lattice/tolerances.hpp"
#include "maille/deform/probe/touch.hpp"
#include "world/touch/allowed_twist.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace maille::deform {

namespace {

/// Passes per tick: with a single pass, the rotation lags behind the goal; each pass costs time.
constexpr int most_passes = 3;
/// Length of a pass, and distance at which faces are in contact [cells].
constexpr double pass_length = 1, reach = 0.05;
/// Motion after which contacts are searched again [cells].
constexpr double well_off = 1e-3;
/// A rotation that lags by a pass is blocked. It then tries detours of length `aside_by`; a detour counts if
/// it reduces the distance by `nearer` [cells].
constexpr double aside_by = pass_length / 2, nearer = 0.01;

Eigen::Vector3d turn_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  const Eigen::AngleAxisd turn(to * from.transpose());
  return turn.angle() * turn.axis();
}

/// Normal from the occupied cells within 2.5 cells, so that a helix of cells has the normals of the helix.
/// The face's own normal if the two disagree.
Eigen::Vector3d smoothed(const OccupancyMap& map, const Index3& cell, const Eigen::Vector3d& at,
                         const Eigen::Vector3d& face) {
  constexpr double radius = 2.5, least_cosine = 0.05;
  constexpr int width = static_cast<int>(radius);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int z = -width; z <= width; ++z)
    for (int y = -width; y <= width; ++y)
      for (int x = -width; x <= width; ++x) {
        const Index3 near{cell[0] + x, cell[1] + y, cell[2] + z};
        if (!map.is_blocked(near))
          continue;
        const Eigen::Vector3d off = at - Eigen::Vector3d(near[0] + 0.5, near[1] + 0.5, near[2] + 0.5);
        sum += std::max(0.0, 1 - off.squaredNorm() / (radius * radius)) * off;
      }
  return sum.dot(face) > least_cosine * sum.norm() ? Eigen::Vector3d(sum.normalized()) : face;
}

/// Adds constraints for faces of occupied cells near the middles of the tool's voxels, as smooth surfaces.
void add_touched(const Surroundings& surroundings, const RigidShape& tool, const Pose& pose,
                 const Eigen::Vector3d& middle, TwistConstraints& constraints) {
  if (surroundings.map() == nullptr)
    return;
  const OccupancyMap& map = *surroundings.map();
  const auto size = Eigen::Vector3d::Map(surroundings.cell_size().data());
  for (std::int32_t voxel = 0; voxel < tool.n_voxels(); ++voxel) {
    if (tool.open_sides(voxel) == 0)
      continue;
    const Eigen::Vector3d place = pose.position + pose.rotation * tool.centre_of(voxel);
    const Eigen::Vector3d at = place.cwiseQuotient(size);
    for (int a = 0; a < 3; ++a) {
      const double below = at[a] - std::floor(at[a]);
      if (below > reach && below < 1 - reach)
        continue;
      const int side = below > 0.5 ? 1 : -1;
      Index3 next{static_cast<int>(std::floor(at[0])), static_cast<int>(std::floor(at[1])),
                  static_cast<int>(std::floor(at[2]))};
      next[a] += side;
      if (!map.is_blocked(next))
        continue;
      const Eigen::Vector3d face = -side * Eigen::Vector3d::Unit(a);
      const Eigen::Vector3d normal = smoothed(map, next, at, face);
      const double gap = (side > 0 ? 1 - below : below) * size[a];
      constraints.add(normal, place - middle, gap * normal.dot(face));
    }
  }
}

} // namespace

double Proxy::move_by(const Surroundings& surroundings, const Eigen::Vector3d& shift,
                      const Eigen::Vector3d& turn, std::optional<Obstacle>& obstacle) {
  RigidMotion motion;
  motion.by = shift;
  motion.angle = turn.norm();
  if (motion.angle > 0)
    motion.axis = turn / motion.angle;
  motion.about = middle();
  double done = 0;
  obstacle = surroundings.move(tool_, motion, pose_, done);
  return done;
}

void Proxy::turn(const Surroundings& surroundings, const Pose& goal) {
  const double cell = *std::ranges::min_element(surroundings.cell_size()), length = pass_length * cell;
  std::optional<Obstacle> obstacle;
  for (int pass = 0; pass < most_passes; ++pass) {
    const Eigen::Vector3d left = turn_between(pose_.rotation, goal.rotation);
    const double arc = left.norm() * arm_;
    if (arc <= least_step_over_cell * cell)
      break;
    const Eigen::Vector3d part = std::min(1.0, length / arc) * left;
    double gone = move_by(surroundings, Eigen::Vector3d::Zero(), part, obstacle) * part.norm() * arm_;
    if (obstacle)
      gone += slide_and_turn(surroundings, goal, length);
    if (gone <= well_off * cell && !(arc > pass_length * cell && free_itself(surroundings, goal)))
      break;
  }
  is_turn_blocked_ = turn_between(pose_.rotation, goal.rotation).norm() * arm_ > least_step_over_cell * cell;
}

/// Distance from a goal: shift and rotation together [m].
double Proxy::distance(const Pose& goal) const {
  return std::hypot((goal.position - middle()).norm(),
                    arm_ * turn_between(pose_.rotation, goal.rotation).norm());
}

/// Leaves a wedge: first by a small detour along or about one of its own axes, then towards the goal; the
/// detour that ends nearest is used. @return true if any reduces the distance
bool Proxy::free_itself(const Surroundings& surroundings, const Pose& goal) {
  const double cell = *std::ranges::min_element(surroundings.cell_size());
  const Pose bound = pose_;
  const Eigen::Vector3d at = middle();
  Pose best = bound;
  double nearest = distance(goal) - nearer * cell;
  for (int way = 0; way < 12; ++way) {
    pose_ = bound;
    const Eigen::Vector3d aside = (way % 2 == 0 ? 1 : -1) * aside_by * cell * bound.rotation.col(way / 2 % 3);
    Pose there{bound.rotation, at};
    if (way < 6)
      there.position += aside;
    else
      there.rotation = Eigen::AngleAxisd(aside.norm() / arm_, aside.normalized()) * bound.rotation;
    slide_and_turn(surroundings, there, aside_by * cell);
    slide_and_turn(surroundings, goal, pass_length * cell);
    if (const double left = distance(goal); left < nearest) {
      nearest = left;
      best = pose_;
    }
  }
  pose_ = best;
  return best.position != bound.position || best.rotation != bound.rotation;
}

/// Shifts and rotates along its contacts. @param length largest motion [m] @return distance moved [m]
double Proxy::slide_and_turn(const Surroundings& surroundings, const Pose& goal, double length) {
  const double cell = *std::ranges::min_element(surroundings.cell_size());
  TwistConstraints touched(arm_), hit(arm_);
  std::array<Obstacle, most_obstacles> hits;
  std::size_t n_hits = 0;
  double gone = 0;
  for (int i = 0; i < most_obstacles && length - gone > unnoticed_over_cell * cell; ++i) {
    Twist wanted;
    wanted << goal.position - middle(), arm_ * turn_between(pose_.rotation, goal.rotation);
    wanted *= std::min(1.0, (length - gone) / wanted.norm());
    touched.clear();
    add_touched(surroundings, tool_, pose_, middle(), touched);
    Twist twist = touched.allowed(wanted, negligible * cell);
    // A step of the voxel staircase constrains the motion along the smooth surface, not the requested motion:
    // motion along the surface leads off the step.
    hit.clear();
    for (std::size_t k = 0; k < n_hits; ++k)
      hit.add(hits[k].normal, hits[k].point - middle(), 0);
    twist = hit.allowed(twist, negligible * cell);
    const double size = twist.norm();
    if (size <= unnoticed_over_cell * cell)
      break;
    std::optional<Obstacle> obstacle;
    const double way = move_by(surroundings, twist.head<3>(), twist.tail<3>() / arm_, obstacle) * size;
    gone += way;
    if (!obstacle)
      break;
    if (way > well_off * cell)
      n_hits = 0;
    hits[n_hits++] = *obstacle;
  }
  return gone;
}

} // namespace maille::deform
