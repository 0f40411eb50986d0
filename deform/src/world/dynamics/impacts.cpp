#include "world/dynamics/impacts.hpp"

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "world/surface/contact_program.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Largest number of impacts per pair. Pairs that interact repeatedly, as in a stack, are then solved
/// together.
constexpr std::size_t most_turns_a_pair = 12;

/// Contact points of objects that are connected by contacts through objects with mass.
class Group {
public:
  Group(std::vector<ImpactPoint*> points, std::span<const Pose> poses, std::span<MovingObject> moving)
      : points_(std::move(points)) {
    const auto n = std::ssize(points_);
    answer_ = Eigen::MatrixXd::Zero(n, n);
    opening_.resize(n);
    added_ = Eigen::VectorXd::Zero(n);
    std::map<int, std::vector<Eigen::Index>> of_object;
    for (Eigen::Index i = 0; i < n; ++i) {
      const ImpactPoint& point = at(i);
      opening_[i] = -point.lead;
      active_.push_back(point.impulse > 0);
      of_object[point.object].push_back(i);
      if (point.other >= 0)
        of_object[point.other].push_back(i);
      if (i == 0 || point.object != at(i - 1).object || point.other != at(i - 1).other)
        pairs_.emplace_back();
      pairs_.back().push_back(i);
    }
    for (auto& [object, rows] : of_object) {
      MovingObject& one = moving[object];
      const Pose& pose = poses[object];
      Eigen::MatrixXd pushes(std::ssize(rows), 6); // force and moment of a unit impulse
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const ImpactPoint& point = at(rows[k]);
        const Eigen::Vector3d normal = point.object == object ? point.normal : Eigen::Vector3d(-point.normal);
        pushes.row(static_cast<Eigen::Index>(k)) << normal.transpose(),
            (point.at - one.place(pose)).cross(normal).transpose();
      }
      Eigen::Matrix<double, 6, 1> speed;
      speed << one.velocity, one.spin;
      opening_(rows) += pushes * speed;
      if (!one.has_mass)
        continue;
      Eigen::Matrix<double, 6, 6> mobility = Eigen::Matrix<double, 6, 6>::Zero();
      mobility.diagonal().head<3>().setConstant(1 / one.mass);
      mobility.bottomRightCorner<3, 3>() = one.inertia_in_world(pose).inverse();
      answer_(rows, rows) += pushes * mobility * pushes.transpose();
      objects_.push_back({&one, rows, mobility * pushes.transpose()});
    }
  }

  double approach() const { return -opening_.minCoeff(); }

  /// Solves pair after pair, the fastest first; then all at once. @param first fastest approach of all groups
  /// [m/s]
  double resolve(double first, double restitution) {
    const std::size_t most = restitution > 0 ? most_turns_a_pair * pairs_.size() : 0;
    for (std::size_t turn = 0;; ++turn) {
      double fastest_with_mass = 0;
      const std::vector<Eigen::Index>* next = nullptr;
      for (const std::vector<Eigen::Index>& pair : pairs_)
        if (const double approach = -opening_.segment(pair.front(), std::ssize(pair)).minCoeff();
            approach > fastest_with_mass && answer_(pair.front(), pair.front()) > 0) {
          fastest_with_mass = approach;
          next = &pair;
        }
      const double fastest = approach();
      first = std::max(first, fastest);
      if (next == nullptr || !(fastest_with_mass > rounding * first) || turn > most) {
        finish();
        return fastest > (turn > most ? negligible : rounding) * first ? fastest : 0;
      }
      if (turn < most) {
        press(*next, restitution);
        continue;
      }
      std::vector<Eigen::Index> movable;
      for (Eigen::Index i = 0; i < opening_.size(); ++i)
        if (answer_(i, i) > 0)
          movable.push_back(i);
      press(movable, 0);
    }
  }

private:
  struct Object {
    MovingObject* one;
    std::vector<Eigen::Index> rows;
    Eigen::MatrixXd speeds; ///< for unit impulses on these rows
  };
  ImpactPoint& at(Eigen::Index i) const { return *points_[i]; }

  void press(const std::vector<Eigen::Index>& rows, double restitution) {
    Eigen::MatrixXd answer = answer_(rows, rows);
    answer.diagonal().array() += rounding * answer.diagonal().maxCoeff();
    const Eigen::VectorXd before = opening_(rows);
    std::vector<char> active;
    for (const Eigen::Index row : rows)
      active.push_back(active_[row]);
    const std::vector<char> may_pull(rows.size(), 0);
    const auto impulses = [&](double part) {
      return contact_forces(answer, before + part * before.cwiseMin(0.0), may_pull, active);
    };
    Eigen::VectorXd impulse = impulses(restitution);
    // The work of an impulse is itself times the mean of the speeds before and after.
    if (restitution > 0 &&
        impulse.dot(before + 0.5 * (answer * impulse)) > tolerance * impulse.dot(before.cwiseAbs()))
      impulse = impulses(0);
    opening_ += answer_(Eigen::all, rows) * impulse;
    added_(rows) += impulse;
    for (std::size_t k = 0; k < rows.size(); ++k)
      active_[rows[k]] = active[k];
  }

  void finish() const {
    for (Eigen::Index i = 0; i < added_.size(); ++i)
      at(i).impulse += added_[i];
    for (const Object& object : objects_) {
      const Eigen::VectorXd change = object.speeds * added_(object.rows);
      object.one->velocity += change.head<3>();
      object.one->spin += change.tail<3>();
    }
  }

  std::vector<ImpactPoint*> points_;
  Eigen::MatrixXd answer_;   ///< opening speeds for unit impulses [1/kg]
  Eigen::VectorXd opening_;  ///< excess of the opening speed of a point over the required one [m/s]
  Eigen::VectorXd added_;    ///< impulses [N s]
  std::vector<char> active_; ///< points that were active last: initial guess
  std::vector<std::vector<Eigen::Index>> pairs_;
  std::vector<Object> objects_;
};

/// Places in the plane perpendicular to a normal, with the numbers of their points.
struct Flat {
  Eigen::Vector2d at;
  std::size_t point;
};

/// Corners of the convex hull, without straight angles.
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
        if (along[0] * on[1] - along[1] * on[0] > tolerance * size * on.norm())
          break;
        hull.pop_back();
      }
      hull.push_back(next);
    }
    hull.pop_back(); // it begins the other side
    std::ranges::reverse(places);
  }
  std::vector<std::size_t> corners;
  for (const Flat& one : hull)
    corners.push_back(one.point);
  return corners;
}

/// Appends the points of a pair that can carry any load of all points: for equal normals, the corners of the
/// convex hull, between which speeds of rigid objects are linear, and the deepest point.
void add_carriers(std::span<const ImpactPoint> pair, std::vector<ImpactPoint>& carriers) {
  std::vector<char> is_known(pair.size(), 0);
  for (std::size_t i = 0; i < pair.size(); ++i) {
    if (is_known[i] != 0)
      continue;
    const Eigen::Vector3d &normal = pair[i].normal, across = normal.unitOrthogonal();
    const Eigen::Vector3d last = normal.cross(across);
    std::vector<Flat> same;
    for (std::size_t k = i; k < pair.size(); ++k)
      if (is_known[k] == 0 && (pair[k].normal - normal).norm() < negligible) {
        is_known[k] = 1;
        same.push_back({{across.dot(pair[k].at), last.dot(pair[k].at)}, k});
      }
    std::vector<std::size_t> chosen;
    if (same.size() <= 2) {
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

double resolve_impacts(std::span<ImpactPoint> points, std::span<const Pose> poses,
                       std::span<MovingObject> moving, double restitution) {
  std::vector<int> group(moving.size()); // union-find of objects with mass
  std::iota(group.begin(), group.end(), 0);
  const auto group_of = [&](int object) {
    while (object >= 0 && group[object] != object)
      object = group[object];
    return object >= 0 && moving[object].has_mass ? object : -1;
  };
  for (const ImpactPoint& point : points)
    if (const int one = group_of(point.object), other = group_of(point.other); one >= 0 && other >= 0)
      group[std::max(one, other)] = std::min(one, other);
  std::map<int, std::vector<ImpactPoint*>> groups;
  for (ImpactPoint& point : points)
    groups[std::max(group_of(point.object), group_of(point.other))].push_back(&point);
  std::vector<Group> all;
  double first = 0, left = 0;
  for (auto& [number, own] : groups)
    first = std::max(first, all.emplace_back(std::move(own), poses, moving).approach());
  for (Group& one : all)
    left = std::max(left, one.resolve(first, restitution));
  return left;
}

} // namespace maille::deform
