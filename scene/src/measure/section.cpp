#include "measure/section.hpp"

#include "maille/base/vectors.hpp"
#include "maille/scene/sliding.hpp"
#include "mechanics/face_force.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille {

namespace {

/// Volume fraction of the unit cube with s . t <= offset. @pre all s > 0, 0 < offset < sum of s
double share_within(const std::vector<double>& s, double offset) {
  double share = 0, scale = 1;
  for (std::size_t a = 0; a < s.size(); ++a)
    scale *= static_cast<double>(a + 1) * s[a];
  for (unsigned corner = 0; corner < 1U << s.size(); ++corner) {
    double left = offset, sign = 1;
    for (std::size_t a = 0; a < s.size(); ++a)
      if (corner >> a & 1U) {
        left -= s[a];
        sign = -sign;
      }
    if (left > 0)
      share += sign * std::pow(left, static_cast<double>(s.size()));
  }
  return share / scale;
}

void add(Vec3& sum, const Vec3& force, double factor) {
  for (std::size_t a = 0; a < 3; ++a)
    sum[a] += factor * force[a];
}

} // namespace

double share_beyond(std::span<const double> sizes, std::span<const double> normal, double offset) {
  constexpr double negligible = 1e-5;
  double most = 0;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    most = std::max(most, std::abs(normal[a]) * sizes[a]);
    offset -= std::min(normal[a], 0.0) * sizes[a]; // reverses axes with a negative normal
  }
  std::vector<double> rises;
  double sum = 0;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    const double rise = std::abs(normal[a]) * sizes[a];
    if (rise <= negligible * most) {
      offset -= rise / 2;
      continue;
    }
    rises.push_back(rise);
    sum += rise;
  }
  if (rises.empty())
    return offset < 0 ? 1 : 0;
  if (offset <= 0 || offset >= sum)
    return offset <= 0 ? 1 : 0;
  return std::clamp(1 - share_within(rises, offset), 0.0, 1.0);
}

BeyondPlane::BeyondPlane(const Specimen& specimen, const SectionPlane& plane)
    : body_(specimen), plane_(plane) {
  const Vec3& h = body_.grid.spacing();
  rounding_ = 1e-4 * *std::min_element(h.begin(), h.begin() + body_.grid.dimension());
}

double BeyondPlane::distance(std::int64_t node) const {
  const Vec3 x = body_.position(body_.grid.node_at(node));
  double distance = 0;
  for (std::size_t a = 0; a < 3; ++a)
    distance += plane_.normal[a] * (x[a] - plane_.point[a]);
  return std::abs(distance) < rounding_ ? 0 : distance;
}

double BeyondPlane::share_of(std::int64_t cell, const FaceLoad* face) const {
  const Grid& grid = body_.grid;
  const auto d = static_cast<std::size_t>(grid.dimension());
  const Vec3 x = body_.position(grid.node_at(grid.corner(grid.cell_at(cell), 0)));
  std::vector<double> sizes, normal;
  double offset = 0;
  for (std::size_t a = 0; a < 3; ++a)
    offset -= plane_.normal[a] * (x[a] - plane_.point[a]);
  for (std::size_t a = 0; a < d; ++a)
    if (face == nullptr || static_cast<std::size_t>(face->axis) != a) {
      sizes.push_back(grid.spacing()[a]);
      normal.push_back(plane_.normal[a]);
    } else if (face->upper) {
      offset -= plane_.normal[a] * grid.spacing()[a];
    }
  return share_beyond(sizes, normal, std::abs(offset) < rounding_ ? 0 : offset);
}

double BeyondPlane::share(std::int64_t cell) const {
  return share_of(cell, nullptr);
}

double BeyondPlane::share(const FaceLoad& face) const {
  return share_of(face.cell, &face);
}

Vec3 force_across(const Scene& scene, const SectionPlane& plane, const Answer& answer) {
  const Specimen& body = scene.specimen;
  const BeyondPlane beyond(body, plane);
  Vec3 force{};
  for (std::size_t i = 0; i < answer.reaction.size(); ++i)
    if (beyond.distance(scene.prescribed[i].node) > 0)
      force[scene.prescribed[i].component] += answer.reaction[i];
  const double volume = cell_volume(body.grid);
  for (const FaceLoad& load : scene.tractions)
    add(force, force_on_face(scene, answer, load), beyond.share(load));
  if (scene.gravity != Vec3{0, 0, 0})
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
      if (body.is_matter(cell))
        add(force, scene.gravity,
            beyond.share(cell) * volume * body.tissue_of(cell) *
                scene.materials[body.material(cell)].density);
  for (const SpringPull& pull : pulls_of_springs(scene, answer))
    if (beyond.distance(pull.node) > 0)
      add(force, pull.force, 1);
  return force;
}

} // namespace maille
