#include "maille/scene/link_limits.hpp"

#include "taut_scale.hpp"

#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace maille {

namespace {

/// Limits of a cell along the object's axes: given ones, or those of its material.
NeighbourLimits cell_limits(const Scene& scene, std::int64_t cell) {
  if (scene.limit_source() == LimitSource::given)
    return scene.limits.given;
  const Material& material = scene.materials[scene.specimen.material(cell)];
  return turned(scene.limit_source() == LimitSource::failure ? limits_before_failure(*material.damage)
                                                             : *material.limits,
                scene.material_axes(cell));
}

bool is_of_one_kind(const Scene& scene) {
  return scene.limit_source() == LimitSource::given ||
         (scene.materials.size() == 1 && scene.specimen.fibres.empty());
}

/// Key of a kind of cell: material and fibre.
using CellKind = std::tuple<std::uint8_t, float, float, float>;
CellKind kind_in(const Specimen& body, std::int64_t cell) {
  const Vec3 f = body.fibre_of(cell);
  return {body.material(cell), static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2])};
}

} // namespace

LinkLimits::LinkLimits(const Scene& scene) : specimen_(&scene.specimen) {
  classify(scene);
  if (scene.limit_source() != LimitSource::taut)
    return;
  taut_scale_ = scene.limits.taut_scale ? *scene.limits.taut_scale : maille::taut_scale(scene, *this);
  for (OfCell& cell : classes_)
    for (LinkIntervals<double>& link : cell)
      for (std::size_t b = 0; b < 3; ++b) {
        link.low[b] *= taut_scale_;
        link.high[b] *= taut_scale_;
      }
}

LinkLimits::OfCell LinkLimits::given_intervals(const NeighbourLimits& limits, const Vec3& rest) {
  OfCell cell;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      cell[a].low[b] = a == b ? (limits.compress[a] - 1) * rest[a] : -limits.shear[a][b] * rest[a];
      cell[a].high[b] = a == b ? (limits.stretch[a] - 1) * rest[a] : limits.shear[a][b] * rest[a];
    }
  return cell;
}

LinkLimits::OfCell LinkLimits::taut_intervals(const LinkCompliance& compliance, const Vec3& rest) {
  OfCell cell;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      cell[a].high[b] = (a == b ? compliance.axial[a] : compliance.shear[a][b]) * rest[a];
      cell[a].low[b] = -cell[a].high[b];
    }
  return cell;
}

void LinkLimits::classify(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Vec3& rest = body.grid.spacing();
  const LimitSource source = scene.limit_source();
  const auto add_class = [&](std::int64_t cell) {
    classes_.push_back(source == LimitSource::taut
                           ? taut_intervals(link_compliance(scene.cell_stiffness(cell)), rest)
                           : given_intervals(cell_limits(scene, cell), rest));
  };

  if (is_of_one_kind(scene)) {
    std::int64_t cell = 0;
    while (!body.is_matter(cell))
      ++cell;
    add_class(cell);
    return;
  }
  std::map<CellKind, std::int32_t, std::less<>, ChargedAllocator<std::pair<const CellKind, std::int32_t>>>
      class_of;
  cell_class_.assign(body.grid.n_cells(), -1);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      cell_class_[cell] =
          class_of.try_emplace(kind_in(body, cell), static_cast<std::int32_t>(class_of.size())).first->second;
  classes_.reserve(class_of.size());
  // Classes are numbered in order of appearance.
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (cell_class_[cell] == static_cast<std::int32_t>(classes_.size()))
      add_class(cell);
}

std::int64_t LinkLimits::bytes_at_most(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (is_of_one_kind(scene))
    return sizeof(OfCell);
  // Counts up to a few thousand kinds; beyond, assumes one kind per cell.
  constexpr std::size_t most_counted = 4096;
  std::set<CellKind> kinds;
  if (!body.fibres.empty())
    for (std::int64_t cell = 0; cell < body.grid.n_cells() && kinds.size() <= most_counted; ++cell)
      if (body.is_matter(cell))
        kinds.insert(kind_in(body, cell));
  const std::int64_t n = body.fibres.empty()            ? std::ssize(scene.materials)
                         : kinds.size() <= most_counted ? std::ssize(kinds)
                                                        : body.n_matter_cells();
  // During classification every kind is also in a tree: key, number, three pointers and a colour.
  constexpr std::int64_t in_a_tree = 64;
  return body.grid.n_cells() * std::int64_t{sizeof(std::int32_t)} +
         n * (std::int64_t{sizeof(OfCell)} + in_a_tree);
}

std::optional<LinkIntervals<double>> LinkLimits::intervals(const Index3& node, int axis) const {
  std::optional<LinkIntervals<double>> link;
  specimen_->for_each_cell_at_link(node, axis, [&](std::int64_t cell) {
    const auto& of_cell = classes_[kind_of(cell)][axis];
    if (link)
      link->narrow_to(of_cell);
    else
      link = of_cell;
  });
  return link;
}

LinkLimits::OfCell LinkLimits::granted_everywhere() const {
  OfCell least = classes_.front();
  for (const OfCell& cell : classes_)
    for (std::size_t a = 0; a < 3; ++a)
      least[a].narrow_to(cell[a]);
  return least;
}

std::int64_t LinkLimits::bytes() const {
  return static_cast<std::int64_t>(classes_.capacity() * sizeof(OfCell) +
                                   cell_class_.capacity() * sizeof(std::int32_t));
}

} // namespace maille
