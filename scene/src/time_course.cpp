// Evaluation of time courses.
#include "time_course.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>
#include <vector>

namespace maille {

namespace {

/// The points around a time, and the fraction between them; equal points beyond the ends.
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

namespace {

/// Pose of a rigid label at a time.
RigidPose pose_at(const Drive& drive, double time) {
  const auto [i, part] = place_of(drive.poses, time, [](const RigidPose& p) { return p.time; });
  RigidPose pose = drive.poses[i];
  if (part > 0) {
    const RigidPose& next = drive.poses[i + 1];
    const Eigen::Quaterniond q = quaternion(pose).slerp(part, quaternion(next));
    pose.rotation = {q.w(), q.x(), q.y(), q.z()};
    for (std::size_t a = 0; a < 3; ++a)
      pose.shift[a] += part * (next.shift[a] - pose.shift[a]);
  }
  pose.time = time;
  return pose;
}

} // namespace

TimeCourse until(const TimeCourse& course, double time) {
  TimeCourse begun;
  if (course.points.empty())
    begun.points.push_back({0, 0});
  for (const auto& [t, value] : course.points)
    if (t < time)
      begun.points.push_back({t / time, value});
  begun.points.push_back({1, course.at(time)});
  return begun;
}

Drive until(const Drive& drive, double time) {
  Drive begun = drive;
  begun.poses.clear();
  for (RigidPose pose : drive.poses)
    if (pose.time < time) {
      pose.time /= time;
      begun.poses.push_back(pose);
    }
  begun.poses.push_back(pose_at(drive, time));
  begun.poses.back().time = 1;
  return begun;
}

double Drive::turned() const {
  double sum = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    sum += quaternion(poses[i - 1]).angularDistance(quaternion(poses[i]));
  return sum;
}

Vec3 Drive::displacement(const Vec3& x, double time) const {
  const RigidPose pose = pose_at(*this, time);
  const Eigen::Quaterniond rotation = quaternion(pose);
  const Eigen::Vector3d shift(pose.shift[0], pose.shift[1], pose.shift[2]);
  const Eigen::Vector3d arm(x[0] - about[0], x[1] - about[1], x[2] - about[2]);
  const Eigen::Vector3d u = rotation * arm - arm + shift;
  return {u[0], u[1], u[2]};
}

} // namespace maille
