#include "geometry/box_tree.hpp"
#include "maille/base/vectors.hpp"
#include "maille/scene/fibre/fibre_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {

namespace {

/// a + t (b - a)
Vec3 blend(const Vec3& a, const Vec3& b, double t) {
  return plus(a, times(t, minus(b, a)));
}
Vec3 of_length_1(const Vec3& v) {
  const double size = norm(v);
  return {v[0] / size, v[1] / size, v[2] / size};
}

} // namespace

FibreCurve::FibreCurve(std::span<const Vec3> points) : points_(points.begin(), points.end()) {
  std::vector<Vec3> pieces;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i)
    pieces.push_back(of_length_1(minus(points_[i + 1], points_[i])));
  const bool is_closed = points_.front() == points_.back();
  directions_.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec3& before = i > 0 ? pieces[i - 1] : is_closed ? pieces.back() : pieces.front();
    const Vec3& after = i < pieces.size() ? pieces[i] : is_closed ? pieces.front() : pieces.back();
    directions_[i] = of_length_1(blend(before, after, 0.5));
  }
  std::vector<std::array<Vec3, 2>> ends;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i)
    ends.push_back({points_[i], points_[i + 1]});
  pieces_ = std::make_shared<const BoxTree>(ends);
}

Vec3 FibreCurve::direction_at(const Vec3& position) const {
  double nearest = std::numeric_limits<double>::infinity();
  std::size_t first = points_.size();
  Vec3 direction{};
  pieces_->near(position, nearest, [&](std::size_t i) {
    const Vec3 piece = minus(points_[i + 1], points_[i]);
    const double t = std::clamp(dot(minus(position, points_[i]), piece) / dot(piece, piece), 0.0, 1.0);
    const Vec3 away = minus(position, blend(points_[i], points_[i + 1], t));
    if (const double square = dot(away, away); square < nearest || (square == nearest && i < first)) {
      nearest = square;
      first = i;
      direction = blend(directions_[i], directions_[i + 1], t);
    }
    return nearest;
  });
  return of_length_1(direction);
}

bool FibreCurve::doubles_back(const Vec3& before, const Vec3& at, const Vec3& after) {
  return dot(of_length_1(minus(at, before)), of_length_1(minus(after, at))) < -1 + 1e-9;
}

} // namespace maille
