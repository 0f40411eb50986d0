#include "world/occupancy/cell_walk.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace maille::deform {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Times in (0, 1) at which the rate of a coordinate changes sign, sorted; at most four, because |angle| <=
/// pi.
struct Turnings {
  std::array<double, 4> times{};
  std::size_t n = 0;

  void insert(double t) {
    std::size_t i = n++;
    for (; i > 0 && times[i - 1] > t; --i)
      times[i] = times[i - 1];
    times[i] = t;
  }
};

Turnings find_turnings(const CoordinatePath& path, double angle) {
  Turnings turnings;
  // rate = slope - amplitude angle sin(angle t - phase)
  const double amplitude = std::hypot(path.cosine, path.sine) * angle;
  if (!(std::abs(path.slope) < std::abs(amplitude)))
    return turnings;
  const double phase = std::atan2(path.sine, path.cosine), inner = std::asin(path.slope / amplitude);
  for (const double root : {inner, std::numbers::pi - inner})
    for (int turn = -2; turn <= 2; ++turn) {
      const double t = (root + phase + 2 * std::numbers::pi * turn) / angle;
      if (t > 0 && t < 1 && turnings.n < turnings.times.size())
        turnings.insert(t);
    }
  return turnings;
}

} // namespace

double CoordinatePath::at(double t, double angle) const {
  return angle == 0 ? offset + cosine + slope * t
                    : offset + slope * t + cosine * std::cos(angle * t) + sine * std::sin(angle * t);
}

double CoordinatePath::rate(double t, double angle) const {
  return slope + angle * (sine * std::cos(angle * t) - cosine * std::sin(angle * t));
}

CellWalk::CellWalk(const std::array<CoordinatePath, 3>& paths, double angle, const Index3& start)
    : paths_(paths), angle_(angle), cell_(start) {
  for (std::size_t a = 0; a < 3; ++a)
    next_[a] = find_crossing(a);
}

std::optional<CellWalk::Step> CellWalk::next(double end) {
  std::size_t axis = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (next_[a].time < next_[axis].time)
      axis = a;
  const Crossing crossing = next_[axis];
  if (!(crossing.time < end))
    return std::nullopt;
  time_ = crossing.time;
  cell_[axis] += crossing.direction;
  next_[axis] = find_crossing(axis);
  return Step{crossing.time, static_cast<int>(axis), crossing.direction};
}

CellWalk::Crossing CellWalk::find_crossing(std::size_t axis) const {
  const CoordinatePath& path = paths_[axis];
  if (angle_ == 0 || (path.cosine == 0 && path.sine == 0))
    return find_straight_crossing(axis);
  const Turnings turnings = find_turnings(path, angle_);
  double begin = time_;
  for (std::size_t i = 0; i <= turnings.n; ++i) {
    const double end = i < turnings.n ? turnings.times[i] : 1;
    if (end <= begin)
      continue;
    const Crossing crossing = crossing_in_piece(axis, begin, end);
    if (crossing.time < never)
      return crossing;
    begin = end;
  }
  return {never, 0};
}

CellWalk::Crossing CellWalk::find_straight_crossing(std::size_t axis) const {
  const CoordinatePath& path = paths_[axis];
  if (path.slope == 0)
    return {never, 0};
  const int direction = path.slope > 0 ? 1 : -1;
  const double plane = cell_[axis] + (direction > 0 ? 1 : 0);
  const double t = (plane - path.at(0, angle_)) / path.slope;
  return t < 1 ? Crossing{std::max(t, time_), direction} : Crossing{never, 0};
}

CellWalk::Crossing CellWalk::crossing_in_piece(std::size_t axis, double begin, double end) const {
  const CoordinatePath& path = paths_[axis];
  const int direction = path.rate(0.5 * (begin + end), angle_) > 0 ? 1 : -1;
  const double plane = cell_[axis] + (direction > 0 ? 1 : 0);
  const auto is_beyond = [&](double t) { return direction * (path.at(t, angle_) - plane) > 0; };
  if (is_beyond(begin))
    return {begin, direction};
  if (!is_beyond(end))
    return {never, 0};
  double inside = begin, beyond = end;
  for (double middle = 0.5 * (inside + beyond); middle > inside && middle < beyond;
       middle = 0.5 * (inside + beyond))
    (is_beyond(middle) ? beyond : inside) = middle;
  return {beyond, direction};
}

} // namespace maille::deform
