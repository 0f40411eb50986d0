#include "maille/scene/frame.hpp"

#include "maille/scene/answer.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace maille {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double epsilon = std::numeric_limits<double>::epsilon();
/// Points are on a line if the second singular value is below this fraction of the first.
constexpr double thin = 1e-9;

Vector3d vector(const Vec3& v) {
  return {v[0], v[1], v[2]};
}
Vec3 vec3(const Vector3d& v) {
  return {v[0], v[1], v[2]};
}
Vec3 mean(std::span<const Vec3> points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vec3& point : points)
    sum += vector(point);
  return vec3(sum / static_cast<double>(points.size()));
}
double largest_norm(std::span<const Vec3> points) {
  double largest = 0;
  for (const Vec3& point : points)
    largest = std::max(largest, vector(point).norm());
  return largest;
}

/// The rotation nearest to sum b a^T in the plane; nothing if it is not unique.
std::optional<Matrix3d> rotation_in_plane(const Matrix3d& sum, double size) {
  const double cosine = sum(0, 0) + sum(1, 1), sine = sum(1, 0) - sum(0, 1);
  if (std::hypot(cosine, sine) <= thin * size)
    return std::nullopt;
  return Eigen::AngleAxisd(std::atan2(sine, cosine), Vector3d::UnitZ()).toRotationMatrix();
}

std::optional<Matrix3d> rotation_in_space(const Matrix3d& sum, double size) {
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d& s = svd.singularValues();
  if (s[0] <= thin * size)
    return std::nullopt;
  if (s[1] <= thin * s[0])
    return Eigen::Quaterniond::FromTwoVectors(svd.matrixV().col(0), svd.matrixU().col(0)).toRotationMatrix();
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  if (s[1] + sign * s[2] <= thin * s[0]) // a reflection: all rotations about the third axis are equally near
    return std::nullopt;
  return Matrix3d(svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose());
}

template<class Map>
void map_nodes(const Scene& scene, Displacement& displacement, const Map& map) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 place = grid.node_at(node);
    if (!scene.specimen.is_node(place))
      continue;
    const Vec3 mapped = map(scene.specimen.position(place), displacement.at(node));
    for (std::size_t b = 0; b < displacement.n_components(); ++b)
      displacement(b, node) = mapped[b];
  }
}

/// Moved nodes with all components prescribed; empty if a hold or a spring ties the body to the world, or a
/// component is free.
struct Handles {
  explicit Handles(const Scene& scene);
  std::vector<Vec3> rest, displacement;
};

Handles::Handles(const Scene& scene) {
  const auto d = static_cast<std::size_t>(scene.dimension());
  const auto& all = scene.prescribed; // by component, then by node
  const std::size_t n = all.size() / d;
  if (all.empty() || all.size() % d != 0 || !scene.springs.empty() ||
      std::ranges::any_of(all, &Prescribed::held))
    return;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t b = 0; b < d; ++b)
      if (all[b * n + i].node != all[i].node || all[b * n + i].component != static_cast<int>(b) ||
          !std::isfinite(all[b * n + i].value))
        return;
  for (std::size_t i = 0; i < n; ++i) {
    rest.push_back(scene.specimen.position(scene.specimen.grid.node_at(all[i].node)));
    displacement.push_back({});
    for (std::size_t b = 0; b < d; ++b)
      displacement.back()[b] = all[b * n + i].value;
  }
}

} // namespace

// Subtracts nearby values first, so that a body that moved far keeps its digits.
Vec3 Frame::in_object(const Vec3& x, const Vec3& u) const {
  if (!is_turned)
    return u;
  const Vector3d arm = vector(x) - vector(from), shift = vector(to) - vector(from);
  return vec3(rotation.transpose() * (vector(u) - shift + arm) - arm);
}

Vec3 Frame::in_world(const Vec3& x, const Vec3& w) const {
  if (!is_turned)
    return w;
  const Vector3d arm = vector(x) - vector(from), shift = vector(to) - vector(from);
  return vec3(shift + (rotation * (arm + vector(w)) - arm));
}

double Frame::angle() const {
  return is_turned ? Eigen::AngleAxisd(rotation).angle() : 0;
}

Frame fit_frame(int dimension, std::span<const Vec3> rest, std::span<const Vec3> displacement) {
  Frame frame;
  if (dimension < 2 || std::ranges::all_of(displacement, [&](const Vec3& u) { return u == displacement[0]; }))
    return frame;
  const Vec3 centre = mean(rest), shift = mean(displacement);
  Matrix3d sum = Matrix3d::Zero();
  double size = 0, radius = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vector3d a = vector(rest[i]) - vector(centre), b = a + (vector(displacement[i]) - vector(shift));
    sum += b * a.transpose();
    size += a.squaredNorm();
    radius = std::max(radius, a.norm());
  }
  const auto rotation = dimension == 2 ? rotation_in_plane(sum, size) : rotation_in_space(sum, size);
  if (!rotation)
    return frame;
  const double rounding = 32 * epsilon * (1 + (largest_norm(rest) + largest_norm(displacement)) / radius);
  if ((*rotation - Matrix3d::Identity()).norm() <= rounding)
    return frame;
  frame.is_turned = true;
  frame.rotation = *rotation;
  frame.from = centre;
  frame.to = vec3(vector(centre) + vector(shift));
  return frame;
}

Frame object_frame(const Scene& scene) {
  const Handles handles(scene);
  return handles.rest.empty() ? Frame{} : fit_frame(scene.dimension(), handles.rest, handles.displacement);
}

std::vector<Prescribed> prescribed_in_object(const Scene& scene, const Frame& frame) {
  std::vector<Prescribed> prescribed = scene.prescribed;
  if (!frame.is_turned)
    return prescribed;
  const Handles handles(scene);
  const std::size_t n = handles.rest.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 w = frame.in_object(handles.rest[i], handles.displacement[i]);
    for (int b = 0; b < scene.dimension(); ++b)
      prescribed[b * n + i].value = w[b];
  }
  return prescribed;
}

Scene in_object(const Scene& scene, const Frame& frame) {
  Scene turned = with_taut_scale(scene);
  turned.prescribed = prescribed_in_object(scene, frame);
  const Matrix3d back = frame.rotation.transpose();
  turned.gravity = vec3(back * vector(scene.gravity));
  for (FaceLoad& load : turned.tractions)
    load.traction = vec3(back * vector(load.traction));
  for (FaceSpring& spring : turned.springs)
    spring.direction = vec3(back * vector(spring.direction));
  return turned;
}

void to_object(const Scene& scene, const Frame& frame, Displacement& displacement) {
  if (frame.is_turned)
    map_nodes(scene, displacement, [&](const Vec3& x, const Vec3& u) { return frame.in_object(x, u); });
}

void to_world(const Scene& scene, const Frame& frame, Displacement& displacement) {
  if (frame.is_turned)
    map_nodes(scene, displacement, [&](const Vec3& x, const Vec3& w) { return frame.in_world(x, w); });
}

} // namespace maille
