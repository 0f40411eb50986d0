#include "rivals/plain_caster.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace maille::lab::rivals {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d eigen(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Matrix3d eigen(const std::array<Vec3, 3>& rows) {
  Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      m(r, c) = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  return m;
}

/// Piecewise linear, constant beyond the ends.
template<class Points, class Value>
double between(const Points& points, double x, Value&& value) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (x < points[i].value) {
      if (i == 0)
        return value(points[0]);
      const double from = points[i - 1].value, to = points[i].value;
      return value(points[i - 1]) + (value(points[i]) - value(points[i - 1])) * (x - from) / (to - from);
    }
  return value(points.back());
}

/// What one object is at a point at rest.
struct Sampled {
  double value = 0;
  Vector3d gradient = Vector3d::Zero(); ///< at rest
};

class Sampler {
public:
  explicit Sampler(const PlainObject& of) : of_(of) {}

  std::optional<Sampled> at(const Vector3d& rest, bool with_gradient) const {
    std::array<int, 3> low{};
    std::array<double, 3> part{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double index = (rest[static_cast<Eigen::Index>(a)] - of_.origin[a]) / of_.spacing[a];
      if (!(index >= 0 && index <= of_.size[a] - 1))
        return std::nullopt;
      low[a] = std::min(static_cast<int>(index), of_.size[a] - 2);
      part[a] = index - low[a];
    }
    Sampled sampled;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<int, 3> at = low;
      for (std::size_t a = 0; a < 3; ++a) {
        const int upper = (corner >> a) & 1;
        weight *= upper == 1 ? part[a] : 1 - part[a];
        at[a] += upper;
      }
      sampled.value += weight * in(of_.values, at);
      if (with_gradient)
        sampled.gradient += weight * gradient(at);
    }
    return sampled;
  }

private:
  double in(const std::vector<double>& values, const std::array<int, 3>& at) const {
    const std::int64_t voxel =
        at[0] + std::int64_t{of_.size[0]} * (at[1] + std::int64_t{of_.size[1]} * at[2]);
    return std::clamp(values[static_cast<std::size_t>(voxel)], of_.low, of_.high);
  }
  Vector3d gradient(const std::array<int, 3>& at) const {
    Vector3d g;
    for (std::size_t a = 0; a < 3; ++a) {
      std::array<int, 3> before = at, after = at;
      before[a] = std::max(at[a] - 1, 0);
      after[a] = std::min(at[a] + 1, of_.size[a] - 1);
      g[static_cast<Eigen::Index>(a)] =
          (in(of_.smooth, after) - in(of_.smooth, before)) / ((after[a] - before[a]) * of_.spacing[a]);
    }
    const double knee = 0.005 * (of_.high - of_.low) / *std::ranges::min_element(of_.spacing);
    return g / (g.norm() + knee);
  }

  const PlainObject& of_;
};

/// A point of the object carried back to rest, with the derivative of the deformation there.
struct AtRest {
  Vector3d rest;
  Matrix3d derivative = Matrix3d::Identity();
};

class Lattice {
public:
  explicit Lattice(const PlainObject& of) : of_(of) {}

  /// Cells whose boxes a ray passes, in the object's frame.
  void keep_near(const Vector3d& origin, const Vector3d& direction) {
    near_.clear();
    for (int k = 0; k < of_.cells[2]; ++k)
      for (int j = 0; j < of_.cells[1]; ++j)
        for (int i = 0; i < of_.cells[0]; ++i) {
          Eigen::AlignedBox3d box;
          for (int corner = 0; corner < 8; ++corner)
            box.extend(node(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2)));
          double from = -1e300, to = 1e300;
          for (int a = 0; a < 3; ++a) {
            const double p = (box.min()[a] - origin[a]) / direction[a],
                         q = (box.max()[a] - origin[a]) / direction[a];
            from = std::max(from, std::min(p, q));
            to = std::min(to, std::max(p, q));
          }
          if (from <= to + 1e-12)
            near_.push_back({{i, j, k}, box});
        }
  }

  std::optional<AtRest> carry_back(const Vector3d& point) const {
    for (const auto& [cell, box] : near_)
      if (box.exteriorDistance(point) < 1e-12)
        if (const auto found = within(cell, point))
          return found;
    return std::nullopt;
  }

private:
  Vector3d node(int i, int j, int k) const {
    const std::int64_t n = i + std::int64_t{of_.cells[0] + 1} * (j + std::int64_t{of_.cells[1] + 1} * k);
    return eigen(of_.nodes[static_cast<std::size_t>(n)]);
  }
  std::optional<AtRest> within(const std::array<int, 3>& cell, const Vector3d& point) const {
    Vector3d r(0.5, 0.5, 0.5);
    Matrix3d derivative;
    for (int round = 0; round < 30; ++round) {
      Vector3d x = Vector3d::Zero();
      derivative.setZero();
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3d p =
            node(cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + (corner >> 2));
        std::array<double, 3> w{}, d{};
        for (int a = 0; a < 3; ++a) {
          const bool upper = ((corner >> a) & 1) == 1;
          w[static_cast<std::size_t>(a)] = upper ? r[a] : 1 - r[a];
          d[static_cast<std::size_t>(a)] = upper ? 1 : -1;
        }
        x += w[0] * w[1] * w[2] * p;
        derivative.col(0) += d[0] * w[1] * w[2] * p;
        derivative.col(1) += w[0] * d[1] * w[2] * p;
        derivative.col(2) += w[0] * w[1] * d[2] * p;
      }
      const Vector3d change = derivative.partialPivLu().solve(x - point);
      r -= change;
      if (!(change.norm() < 10))
        return std::nullopt;
      if (change.norm() < 1e-12)
        break;
    }
    if (r.minCoeff() < -1e-9 || r.maxCoeff() > 1 + 1e-9)
      return std::nullopt;
    AtRest found;
    for (int a = 0; a < 3; ++a) {
      const auto c = static_cast<std::size_t>(a);
      found.rest[a] = of_.lattice_origin[c] + of_.lattice_spacing[c] * (cell[c] + r[a]);
      found.derivative.col(a) = derivative.col(a) / of_.lattice_spacing[c];
    }
    return found;
  }

  const PlainObject& of_;
  std::vector<std::pair<std::array<int, 3>, Eigen::AlignedBox3d>> near_;
};

/// One object along one ray.
class ObjectOnRay {
public:
  ObjectOnRay(const PlainObject& of, const PlainView& view, const Vec3& origin, const Vec3& direction)
      : of_(of), view_(view), sampler_(of), lattice_(of), rotation_(eigen(of.rotation)) {
    origin_ = rotation_.transpose() * (eigen(origin) - eigen(of.position));
    direction_ = rotation_.transpose() * eigen(direction);
    if (of.cells[0] > 0)
      lattice_.keep_near(origin_, direction_);
    else
      begin_ = cut_ = std::max(0.0, enters_image());
    for (const auto& [point, normal] : view.clips) {
      const double off = eigen(normal).dot(eigen(origin) - eigen(point)),
                   slope = eigen(normal).dot(eigen(direction));
      if (slope > 0 && -off / slope > begin_)
        begin_ = cut_ = -off / slope;
      if (slope < 0)
        end_ = std::min(end_, -off / slope);
    }
  }

  std::optional<double> value(double t) const {
    if (t < begin_ || t > end_)
      return std::nullopt;
    const auto rest = at_rest(t);
    const auto sampled = rest ? sampler_.at(rest->rest, false) : std::nullopt;
    return sampled ? std::optional(sampled->value) : std::nullopt;
  }
  double opacity(double value) const {
    return between(of_.look.opacity, value, [](const OpacityPoint& p) { return p.opacity; });
  }
  /// The colour with its light; not premultiplied.
  std::array<double, 3> colour(double t) const {
    const auto rest = at_rest(t);
    const auto sampled = rest ? sampler_.at(rest->rest, true) : std::nullopt;
    if (!sampled)
      return {};
    // A surface has its value's colour, on a cut through what is inside of it, too.
    const double value = of_.look.mode == LookMode::isosurface ? of_.look.isovalue : sampled->value;
    std::array<double, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = between(of_.look.colours, value,
                       [&](const ColourPoint& p) { return static_cast<double>(p.colour[c]); });
    const Shading& shading = of_.look.shading;
    if (!shading.on || of_.look.mode == LookMode::maximum)
      return rgb;
    const double steepness = sampled->gradient.norm();
    Vector3d normal = rest->derivative.inverse().transpose() * sampled->gradient;
    normal = normal.norm() > 0 ? Vector3d(rotation_ * normal.normalized()) : Vector3d::Zero();
    const Vector3d eye = -eigen(view_.ahead), light = eigen(view_.light);
    const double towards_eye = normal.dot(eye), front = 0.5 + 0.5 * std::clamp(8 * towards_eye, -1.0, 1.0);
    const double facing =
        front * std::max(0.0, normal.dot(light)) + (1 - front) * std::max(0.0, -normal.dot(light));
    const double mirrored = std::max(0.0, 2 * facing * std::abs(towards_eye) - light.dot(eye));
    const double voxels_behind_cut = (t - cut_) / *std::ranges::min_element(of_.spacing);
    const double weight = std::min(1.0, 4 * steepness) * std::clamp(voxels_behind_cut - 1, 0.0, 1.0);
    const double part = shading.ambient + shading.diffuse * (1 + weight * (facing - 1));
    for (double& channel : rgb)
      channel =
          std::min(1.0, channel * part + weight * shading.specular * std::pow(mirrored, shading.shininess));
    return rgb;
  }

private:
  /// Depth of the outermost voxels' middles.
  double enters_image() const {
    double enters = -1e300;
    for (Eigen::Index a = 0; a < 3; ++a) {
      const auto c = static_cast<std::size_t>(a);
      const double low = of_.origin[c], high = low + of_.spacing[c] * (of_.size[c] - 1);
      if (direction_[a] != 0)
        enters = std::max(enters,
                          std::min((low - origin_[a]) / direction_[a], (high - origin_[a]) / direction_[a]));
    }
    return enters;
  }
  std::optional<AtRest> at_rest(double t) const {
    const Vector3d point = origin_ + t * direction_;
    if (of_.cells[0] > 0)
      return lattice_.carry_back(point);
    return AtRest{point};
  }

  const PlainObject& of_;
  const PlainView& view_;
  Sampler sampler_;
  Lattice lattice_;
  Matrix3d rotation_;
  Vector3d origin_, direction_;
  double begin_ = 0, end_ = 1e300, cut_ = -1e300; ///< along the ray
};

} // namespace

std::vector<double> smoothed(const PlainObject& of) {
  std::vector<double> all = of.values;
  for (std::size_t pass = 0, stride = 1; pass < 6; ++pass) {
    const std::vector<double> before = all;
    const std::size_t n = of.size[pass % 3];
    for (std::size_t v = 0; v < all.size(); ++v)
      all[v] = before[v] / 2 + before[v / stride % n > 0 ? v - stride : v] / 4 +
               before[v / stride % n + 1 < n ? v + stride : v] / 4;
    stride = pass % 3 == 2 ? 1 : stride * n;
  }
  return all;
}

std::array<double, 4> cast_plainly(const std::vector<PlainObject>& objects, const PlainView& view,
                                   const Vec3& origin, const Vec3& direction) {
  constexpr int parts = 16; // of a step, for isosurfaces
  struct State {
    std::optional<double> before; // of isosurfaces
    double largest = -1e300, largest_at = 0;
    bool is_done = false;
  };
  std::vector<ObjectOnRay> rays;
  for (const PlainObject& object : objects)
    rays.emplace_back(object, view, origin, direction);
  std::vector<State> states(objects.size());
  std::array<double, 4> sum{};
  const auto add = [&](const std::array<double, 3>& colour, double alpha) {
    const double weight = (1 - sum[3]) * alpha;
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += weight * colour[c];
    sum[3] += weight;
  };
  const auto n = static_cast<std::int64_t>(view.farthest / view.step);
  for (std::int64_t k = 0; k < n; ++k) {
    const double t = (static_cast<double>(k) + 0.5) * view.step;
    for (std::size_t o = 0; o < objects.size(); ++o) {
      const Look& look = objects[o].look;
      State& state = states[o];
      if (look.mode == LookMode::isosurface) {
        for (int part = 1; part <= parts && !state.is_done; ++part) {
          double outside = t - view.step * (parts - part + 1) / parts, inside = outside + view.step / parts;
          const auto value = rays[o].value(inside);
          if (value && *value >= look.isovalue) {
            for (int round = 0; round < 60 && state.before; ++round) {
              const double middle = 0.5 * (outside + inside);
              (rays[o].value(middle).value_or(-1e300) >= look.isovalue ? inside : outside) = middle;
            }
            add(rays[o].colour(inside), rays[o].opacity(look.isovalue));
            state.is_done = true;
          }
          state.before = value;
        }
        continue;
      }
      const auto value = rays[o].value(t);
      if (value && look.mode == LookMode::composite) {
        const double alpha = 1 - std::pow(1 - rays[o].opacity(*value), view.step / objects[o].unit_distance);
        if (alpha > 0)
          add(rays[o].colour(t), alpha);
      } else if (value && look.mode == LookMode::maximum && *value > state.largest) {
        state.largest = *value;
        state.largest_at = t;
      }
    }
  }
  for (std::size_t o = 0; o < objects.size(); ++o)
    if (states[o].largest > -1e300)
      add(rays[o].colour(states[o].largest_at), rays[o].opacity(states[o].largest));
  return sum;
}

} // namespace maille::lab::rivals
