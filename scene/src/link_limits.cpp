#include "maille/scene/link_limits.hpp"

#include "taut_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace maille {

namespace {

/// Limits, given or of the matter in a cell, along the object's axes.
NeighbourLimits cell_limits(const Scene& scene, std::int64_t cell) {
  if (scene.limits.from == LimitSource::given)
    return scene.limits.given;
  return turned(*scene.materials[scene.specimen.material(cell)].limits, scene.material_axes(cell));
}

} // namespace

LinkLimits::LinkLimits(const Scene& scene) : specimen_(&scene.specimen) {
  classify(scene);
  if (scene.limits.from != LimitSource::taut)
    return;
  taut_scale_ = scene.limits.taut_scale ? *scene.limits.taut_scale : maille::taut_scale(scene, *this);
  for (Slack& slack : classes_)
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) {
        slack.low[a][b] *= taut_scale_;
        slack.high[a][b] *= taut_scale_;
      }
}

LinkLimits::Slack LinkLimits::slack_of(const NeighbourLimits& limits, const Vec3& rest) {
  Slack slack;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      slack.low[a][b] = a == b ? (limits.compress[a] - 1) * rest[a] : -limits.shear[a][b] * rest[a];
      slack.high[a][b] = a == b ? (limits.stretch[a] - 1) * rest[a] : limits.shear[a][b] * rest[a];
    }
  return slack;
}

LinkLimits::Slack LinkLimits::taut_slack(const LinkCompliance& compliance, const Vec3& rest) {
  Slack slack;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      slack.high[a][b] = (a == b ? compliance.axial[a] : compliance.shear[a][b]) * rest[a];
      slack.low[a][b] = -slack.high[a][b];
    }
  return slack;
}

void LinkLimits::classify(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Vec3& rest = body.grid.spacing();
  const auto add_class = [&](std::int64_t cell) {
    classes_.push_back(scene.limits.from == LimitSource::taut
                           ? taut_slack(link_compliance(scene.cell_stiffness(cell)), rest)
                           : slack_of(cell_limits(scene, cell), rest));
    return static_cast<std::int32_t>(classes_.size() - 1);
  };

  const bool one_kind =
      scene.limits.from == LimitSource::given || (scene.materials.size() == 1 && body.fibres.empty());
  if (one_kind) {
    std::int64_t cell = 0;
    while (!body.is_matter(cell))
      ++cell;
    add_class(cell);
    return;
  }
  using Kind = std::tuple<std::uint8_t, float, float, float>;
  std::map<Kind, std::int32_t> class_of;
  cell_class_.assign(static_cast<std::size_t>(body.grid.n_cells()), -1);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Vec3 f = body.fibre_of(cell);
    const Kind kind{body.material(cell), static_cast<float>(f[0]), static_cast<float>(f[1]),
                    static_cast<float>(f[2])};
    auto place = class_of.find(kind);
    if (place == class_of.end())
      place = class_of.emplace(kind, add_class(cell)).first;
    cell_class_[static_cast<std::size_t>(cell)] = place->second;
  }
}

LinkBounds LinkLimits::bounds(const Index3& node, int axis) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  LinkBounds link{false, {-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
  const auto a = static_cast<std::size_t>(axis);
  specimen_->for_each_cell_at_link(node, axis, [&](std::int64_t cell) {
    link.exists = true;
    const std::int32_t kind = cell_class_.empty() ? 0 : cell_class_[static_cast<std::size_t>(cell)];
    const Slack& slack = classes_[static_cast<std::size_t>(kind)];
    for (std::size_t b = 0; b < 3; ++b) {
      link.low[b] = std::max(link.low[b], slack.low[a][b]);
      link.high[b] = std::min(link.high[b], slack.high[a][b]);
    }
  });
  return link;
}

std::int64_t LinkLimits::bytes() const {
  return static_cast<std::int64_t>(classes_.capacity() * sizeof(Slack) +
                                   cell_class_.capacity() * sizeof(std::int32_t));
}

} // namespace maille
