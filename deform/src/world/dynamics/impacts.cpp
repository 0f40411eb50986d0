#include "world/dynamics/impacts.hpp"

#include "world/surface/contact_program.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

constexpr double slow = 1e-12;    ///< of the fastest approach: rounding
constexpr double give = 1e-11;    ///< of the largest entry: so that points that say the same share an impulse
constexpr double rounding = 1e-9; ///< of the work of an impulse
constexpr int most_turns_a_pair = 200; ///< of pairs that press one another to and fro

/// How much faster a point opens than it is to.
double opening(const ImpactPoint& point, std::span<const Pose> poses, std::span<const MovingObject> moving) {
  const auto speed = [&](int object) {
    const auto i = static_cast<std::size_t>(object);
    return moving[i].velocity_at(poses[i], point.at).dot(point.normal);
  };
  return speed(point.object) - (point.other < 0 ? 0 : speed(point.other)) - point.lead;
}

class Pair {
public:
  Pair(std::span<ImpactPoint> points, std::span<const Pose> poses, std::span<MovingObject> moving)
      : points_(points), poses_(poses), moving_(moving) {
    const auto n = static_cast<Eigen::Index>(points.size());
    answer_ = Eigen::MatrixXd::Zero(n, n);
    for (const int object : {points.front().object, points.front().other}) {
      if (object < 0 || !moving[static_cast<std::size_t>(object)].has_mass)
        continue;
      const MovingObject& one = moving[static_cast<std::size_t>(object)];
      const Pose& pose = poses[static_cast<std::size_t>(object)];
      Eigen::MatrixXd arms(n, 3), normals(n, 3);
      for (Eigen::Index i = 0; i < n; ++i) {
        const ImpactPoint& point = points[static_cast<std::size_t>(i)];
        normals.row(i) = point.normal.transpose() * (point.object == object ? 1 : -1);
        arms.row(i) = (point.at - one.place(pose)).cross(Eigen::Vector3d(normals.row(i))).transpose();
      }
      answer_ += normals * normals.transpose() / one.mass +
                 arms * one.inertia_in_world(pose).inverse() * arms.transpose();
    }
    has_mass_ = answer_.diagonal().maxCoeff() > 0;
    answer_.diagonal().array() += give * answer_.diagonal().maxCoeff();
  }

  double approach() const {
    double least = 0;
    for (const ImpactPoint& point : points_)
      least = std::min(least, opening(point, poses_, moving_));
    return -least;
  }
  bool has_mass() const { return has_mass_; }

  void resolve(double restitution) {
    const auto n = static_cast<Eigen::Index>(points_.size());
    Eigen::VectorXd before(n);
    for (Eigen::Index i = 0; i < n; ++i)
      before[i] = opening(points_[static_cast<std::size_t>(i)], poses_, moving_);
    Eigen::VectorXd impulse = impulses(before, restitution);
    // The work of an impulse is itself times the mean of the speeds before and after.
    if (impulse.dot(before + 0.5 * (answer_ * impulse)) > rounding * impulse.dot(before.cwiseAbs()))
      impulse = impulses(before, 0);
    for (Eigen::Index i = 0; i < n; ++i) {
      ImpactPoint& point = points_[static_cast<std::size_t>(i)];
      point.impulse += impulse[i];
      for (const auto& [object, sign] : {std::pair(point.object, 1.0), std::pair(point.other, -1.0)})
        if (object >= 0)
          moving_[static_cast<std::size_t>(object)].push(poses_[static_cast<std::size_t>(object)], point.at,
                                                         sign * impulse[i] * point.normal);
    }
  }

private:
  Eigen::VectorXd impulses(const Eigen::VectorXd& before, double restitution) const {
    std::vector<char> may_pull(points_.size(), 0), active;
    return contact_forces(answer_, before + restitution * before.cwiseMin(0.0), may_pull, active);
  }

  std::span<ImpactPoint> points_;
  std::span<const Pose> poses_;
  std::span<MovingObject> moving_;
  Eigen::MatrixXd answer_; ///< speeds at which points open for impulses on them [1/kg]
  bool has_mass_ = false;
};

} // namespace

double resolve_impacts(std::span<ImpactPoint> points, std::span<const Pose> poses,
                       std::span<MovingObject> moving, double restitution) {
  std::vector<Pair> pairs;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin;
    while (end < points.size() && points[end].object == points[begin].object &&
           points[end].other == points[begin].other)
      ++end;
    pairs.emplace_back(points.subspan(begin, end - begin), poses, moving);
    begin = end;
  }
  double first = 0;
  const std::size_t most = most_turns_a_pair * pairs.size();
  for (std::size_t turn = 0;; ++turn) {
    double fastest = 0, fastest_with_mass = 0;
    Pair* next = nullptr;
    for (Pair& pair : pairs) {
      const double approach = pair.approach();
      fastest = std::max(fastest, approach);
      if (pair.has_mass() && approach > fastest_with_mass) {
        fastest_with_mass = approach;
        next = &pair;
      }
    }
    first = std::max(first, fastest);
    if (next == nullptr || !(fastest_with_mass > slow * first) || turn == most)
      return fastest > slow * first ? fastest : 0;
    // Pairs that press one another to and fro stay together in the end.
    next->resolve(turn < most / 2 ? restitution : 0);
  }
}

} // namespace maille::deform
