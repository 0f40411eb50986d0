// What changes over the time of a run by a course of its own.
#include "maille/scene/scene.hpp"

#include <Eigen/Geometry>

#include <algorithm>

namespace maille {

namespace {

/// The points around a time, and how far it is from the first to the second; both the same beyond the ends.
template<class Point, class TimeOf>
std::pair<std::size_t, double> place_of(const std::vector<Point>& points, double time, TimeOf&& time_of) {
  const auto after = std::ranges::find_if(points, [&](const Point& p) { return time_of(p) > time; });
  if (after == points.begin())
    return {0, 0};
  const auto i = static_cast<std::size_t>(after - points.begin()) - 1;
  if (after == points.end())
    return {i, 0};
  return {i, (time - time_of(points[i])) / (time_of(*after) - time_of(points[i]))};
}

Eigen::Quaterniond quaternion(const RigidPose& pose) {
  return {pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]};
}

} // namespace

double TimeCourse::at(double time) const {
  if (points.empty())
    return time;
  const auto [i, part] = place_of(points, time, [](const auto& p) { return p[0]; });
  return part == 0 ? points[i][1] : points[i][1] + part * (points[i + 1][1] - points[i][1]);
}

double Drive::turned() const {
  double sum = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    sum += quaternion(poses[i - 1]).angularDistance(quaternion(poses[i]));
  return sum;
}

Vec3 Drive::displacement(const Vec3& x, double time) const {
  const auto [i, part] = place_of(poses, time, [](const RigidPose& p) { return p.time; });
  Eigen::Quaterniond rotation = quaternion(poses[i]);
  Eigen::Vector3d shift(poses[i].shift[0], poses[i].shift[1], poses[i].shift[2]);
  if (part > 0) {
    const RigidPose& next = poses[i + 1];
    rotation = rotation.slerp(part, quaternion(next));
    shift += part * (Eigen::Vector3d(next.shift[0], next.shift[1], next.shift[2]) - shift);
  }
  const Eigen::Vector3d arm(x[0] - about[0], x[1] - about[1], x[2] - about[2]);
  const Eigen::Vector3d u = rotation * arm - arm + shift;
  return {u[0], u[1], u[2]};
}

} // namespace maille
