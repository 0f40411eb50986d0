/// Rigid objects that a hand leads by a spring.

#include "maille/deform/probe/touch.hpp"
#include "world/world_frame.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

Eigen::Vector3d middle_of(const RigidShape& shape) {
  Eigen::Vector3d middle;
  for (std::size_t a = 0; a < 3; ++a)
    middle[static_cast<Eigen::Index>(a)] = 0.5 * shape.size()[a] * shape.spacing()[a];
  return middle;
}

} // namespace

void RigidWorld::follow(int object, const Pose& goal) {
  Object& moving = at(object);
  const Eigen::Vector3d middle = middle_of(moving.shape);
  const auto about_middle = [&](const Pose& pose) {
    return Pose{pose.rotation, pose.position + pose.rotation * middle};
  };
  take(moving);
  const Surroundings around(&map_, cell_size_);
  Proxy proxy(moving.shape, about_middle(moving.pose));
  proxy.follow(around, about_middle(goal));
  moving.pose = proxy.pose();
  put(moving);
}

/// Part of a drive whose hand leads an object: of poses that no point of it goes further than a cell between.
void WorldFrame::lead(std::size_t i, int step, int n) {
  const Drive& drive = drives_[i];
  const int index = parts_.member(drive.object).index;
  const RigidMotion& motion = drive.motion;
  const Eigen::Vector3d middle = middle_of(parts_.rigid.shape(index));
  const Eigen::Vector3d at = drive.lead->hand.position + drive.lead->hand.rotation * middle;
  const double way = motion.by.norm() + std::abs(motion.angle) * ((at - motion.about).norm() + middle.norm());
  const double poses = std::ceil(way / *std::ranges::min_element(parts_.scene.spacing) + 1e-9);
  for (double pose = std::floor(poses * step / n) + 1; pose <= std::floor(poses * (step + 1) / n); ++pose)
    if (clock_.may_go_on())
      parts_.rigid.follow(index, motion.moved(drive.lead->hand, pose / poses));
}

/// Result of a led object's drive: the fraction counts as long as the lag behind the hand does not grow, and
/// the force is that of the spring.
void WorldFrame::report_lead(std::size_t i) {
  const Drive& drive = drives_[i];
  const Pose& pose = parts_.rigid.pose(parts_.member(drive.object).index);
  const Eigen::Vector3d middle = middle_of(parts_.rigid.shape(parts_.member(drive.object).index));
  const Pose end = drive.motion.moved(drive.lead->hand, 1);
  const Eigen::Vector3d behind =
      end.position + end.rotation * middle - pose.position - pose.rotation * middle;
  const double turn = Eigen::AngleAxisd(end.rotation * pose.rotation.transpose()).angle(),
               way = drive.motion.by.norm() + std::abs(drive.motion.angle) * middle.norm();
  result_.drives[i].force = drive.lead->stiffness * behind;
  const double left = behind.norm() + turn * middle.norm();
  result_.drives[i].fraction = way > 0 ? std::clamp(1 - left / way, 0.0, 1.0) : 1.0;
}

} // namespace maille::deform
