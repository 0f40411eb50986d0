#include "world/dynamics/impacts.hpp"

#include "lattice/sort_uniquely.hpp"
#include "world/surface/contact_program.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

constexpr double slow = 1e-12;    ///< of the fastest approach: rounding
constexpr double nearly = 1e-6;   ///< likewise, of all pairs at once
constexpr double give = 1e-11;    ///< of the largest entry: so that points that say the same share an impulse
constexpr double rounding = 1e-9; ///< of the work of an impulse, and of the sine of an angle
/// Pairs that press one another to and fro, as they do in a stack, are resolved together in the end.
constexpr std::size_t most_turns_a_pair = 12;

/// How much faster a point opens than it is to.
double opening(const ImpactPoint& point, std::span<const Pose> poses, std::span<const MovingObject> moving) {
  const auto speed = [&](int object) {
    const auto i = static_cast<std::size_t>(object);
    return moving[i].velocity_at(poses[i], point.at).dot(point.normal);
  };
  return speed(point.object) - (point.other < 0 ? 0 : speed(point.other)) - point.lead;
}

/// Points of a pair of objects, or of all that press one another.
class Pair {
public:
  Pair(std::span<ImpactPoint> points, std::span<const Pose> poses, std::span<MovingObject> moving)
      : points_(points), poses_(poses), moving_(moving) {
    const auto n = static_cast<Eigen::Index>(points.size());
    answer_ = Eigen::MatrixXd::Zero(n, n);
    std::vector<int> objects;
    for (const ImpactPoint& point : points) {
      objects.insert(objects.end(), {point.object, point.other});
      active_.push_back(point.impulse > 0);
    }
    sort_uniquely(objects);
    for (const int object : objects) {
      if (object < 0 || !moving[static_cast<std::size_t>(object)].has_mass)
        continue;
      const MovingObject& one = moving[static_cast<std::size_t>(object)];
      const Pose& pose = poses[static_cast<std::size_t>(object)];
      Eigen::MatrixXd arms(n, 3), normals(n, 3);
      for (Eigen::Index i = 0; i < n; ++i) {
        const ImpactPoint& point = points[static_cast<std::size_t>(i)];
        normals.row(i) = point.normal.transpose() * (point.object == object  ? 1
                                                     : point.other == object ? -1
                                                                             : 0);
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
  Eigen::VectorXd impulses(const Eigen::VectorXd& before, double restitution) {
    const std::vector<char> may_pull(points_.size(), 0);
    return contact_forces(answer_, before + restitution * before.cwiseMin(0.0), may_pull, active_);
  }

  std::span<ImpactPoint> points_;
  std::span<const Pose> poses_;
  std::span<MovingObject> moving_;
  Eigen::MatrixXd answer_;   ///< speeds at which points open for impulses on them [1/kg]
  std::vector<char> active_; ///< points that have pressed last: mostly those that will
  bool has_mass_ = false;
};

constexpr double same_normal = 1e-6; ///< of two of length 1, as faces that lie on one another have
constexpr std::size_t few_points = 4;

/// Places in the plane across a normal, with the numbers of their points.
struct Flat {
  Eigen::Vector2d at;
  std::size_t point;
};

/// Corners of the convex hull, straight angles left out.
/// Source  Andrew 1979 (Inf. Process. Lett. 9)
std::vector<std::size_t> hull_of(std::vector<Flat> places) {
  std::ranges::sort(places, {}, [](const Flat& one) { return std::tuple(one.at[0], one.at[1], one.point); });
  const double size = (places.back().at - places.front().at).norm();
  std::vector<Flat> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Flat& next : places) {
      while (hull.size() >= first + 2) {
        const Eigen::Vector2d along = hull.back().at - hull[hull.size() - 2].at,
                              on = next.at - hull[hull.size() - 2].at;
        if (along[0] * on[1] - along[1] * on[0] > rounding * size * on.norm())
          break;
        hull.pop_back();
      }
      hull.push_back(next);
    }
    hull.pop_back(); // the first of the other side
    std::ranges::reverse(places);
  }
  std::vector<std::size_t> corners;
  for (const Flat& one : hull)
    corners.push_back(one.point);
  return corners;
}

/// Appends those of a pair's points that carry all that the others could: where normals are the same, the
/// corners of the convex hull, between which speeds of rigid objects are linear, and the deepest.
void add_carriers(std::span<const ImpactPoint> pair, std::vector<ImpactPoint>& carriers) {
  std::vector<char> is_known(pair.size(), 0);
  for (std::size_t i = 0; i < pair.size(); ++i) {
    if (is_known[i] != 0)
      continue;
    const Eigen::Vector3d &normal = pair[i].normal, across = normal.unitOrthogonal();
    const Eigen::Vector3d last = normal.cross(across);
    std::vector<Flat> same;
    for (std::size_t k = i; k < pair.size(); ++k)
      if (is_known[k] == 0 && (pair[k].normal - normal).norm() < same_normal) {
        is_known[k] = 1;
        same.push_back({{across.dot(pair[k].at), last.dot(pair[k].at)}, k});
      }
    std::vector<std::size_t> chosen;
    if (same.size() <= few_points) {
      for (const Flat& one : same)
        chosen.push_back(one.point);
    } else {
      chosen = hull_of(same);
      chosen.push_back(
          std::ranges::min(same, {}, [&](const Flat& one) { return pair[one.point].gap; }).point);
      sort_uniquely(chosen);
    }
    for (const std::size_t point : chosen)
      carriers.push_back(pair[point]);
  }
}

} // namespace

std::vector<ImpactPoint> carriers_of(std::span<const ImpactPoint> points) {
  std::vector<ImpactPoint> carriers;
  for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end) {
    while (end < points.size() && points[end].object == points[begin].object &&
           points[end].other == points[begin].other)
      ++end;
    add_carriers(points.subspan(begin, end - begin), carriers);
  }
  return carriers;
}

namespace {

void resolve_together(std::span<ImpactPoint> points, std::span<const Pose> poses,
                      std::span<MovingObject> moving) {
  const auto has_mass = [&](int object) {
    return object >= 0 && moving[static_cast<std::size_t>(object)].has_mass;
  };
  std::vector<ImpactPoint> movable;
  std::ranges::copy_if(points, std::back_inserter(movable), [&](const ImpactPoint& point) {
    return has_mass(point.object) || has_mass(point.other);
  });
  Pair(movable, poses, moving).resolve(0);
  auto next = movable.begin();
  for (ImpactPoint& point : points)
    if (has_mass(point.object) || has_mass(point.other))
      point = *next++;
}

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
    if (next == nullptr || !(fastest_with_mass > slow * first) || turn > most)
      return fastest > (turn > most ? nearly : slow) * first ? fastest : 0;
    if (turn == most)
      resolve_together(points, poses, moving);
    else
      next->resolve(restitution);
  }
}

} // namespace maille::deform
