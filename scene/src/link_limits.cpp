#include "maille/scene/link_limits.hpp"

#include "maille/scene/frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace maille {

namespace {

/// The search for one component.
class ComponentScale {
public:
  ComponentScale(const Scene& scene, const LinkLimits& unit, int component,
                 const std::vector<Prescribed>& prescribed)
      : scene_(scene), unit_(unit), component_(component) {
    for (const Prescribed& p : prescribed)
      if (p.component == component)
        ends_.push_back({p.node, p.value});
  }

  double find() const {
    if (ends_.empty())
      return 0;
    const PathEnd& lowest = *std::ranges::min_element(ends_, {}, &PathEnd::potential);
    double found = largest_ratio_at(lowest);
    // Below any ratio that there can be, where the lowest is joined to none that differs.
    double scale = found > 0 ? found : smallest_difference() / longest_path();
    while (scale > 0) {
      const std::optional<PathEnd> end = farthest_apart(scale);
      const double ratio = end ? largest_ratio_at(*end) : 0;
      if (!(ratio > scale)) // none is apart, or by rounding alone
        break;
      found = scale = ratio;
    }
    return found;
  }

private:
  /// Over the other ends: the largest |difference of values| / length of the path.
  double largest_ratio_at(const PathEnd& from) const {
    const PathEnd start{from.node, 0};
    const List<double> length =
        shortest_paths(scene_, unit_, component_, {&start, 1}, PathDirection::from_ends);
    double ratio = 0;
    for (const PathEnd& end : ends_)
      if (end.potential != from.potential)
        ratio = std::max(ratio, std::abs(end.potential - from.potential) /
                                    length[static_cast<std::size_t>(end.node)]);
    return ratio;
  }

  /// The end whose value lies highest above what paths from the others let it have at that scale.
  std::optional<PathEnd> farthest_apart(double scale) const {
    std::vector<PathEnd> scaled = ends_;
    for (PathEnd& end : scaled)
      end.potential /= scale;
    const List<double> reach = shortest_paths(scene_, unit_, component_, scaled, PathDirection::from_ends);
    std::optional<PathEnd> farthest;
    double most = 0;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const double above = scaled[i].potential - reach[static_cast<std::size_t>(ends_[i].node)];
      if (above > most) {
        most = above;
        farthest = ends_[i];
      }
    }
    return farthest;
  }

  /// Between neighbours among the sorted values; 0 where all are the same.
  double smallest_difference() const {
    std::vector<double> values;
    for (const PathEnd& end : ends_)
      values.push_back(end.potential);
    std::ranges::sort(values);
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < values.size(); ++i)
      if (values[i] > values[i - 1])
        smallest = std::min(smallest, values[i] - values[i - 1]);
    return std::isfinite(smallest) ? smallest : 0;
  }

  /// No shortest path is longer.
  double longest_path() const {
    const Grid& grid = scene_.specimen.grid;
    double longest_link = 0;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int axis = 0; axis < grid.dimension(); ++axis) {
        const Index3 at = grid.node_at(node);
        if (at[static_cast<std::size_t>(axis)] + 1 >= grid.nodes()[static_cast<std::size_t>(axis)])
          continue;
        if (const auto link = unit_.intervals(at, axis))
          longest_link = std::max(longest_link, link->high[static_cast<std::size_t>(component_)]);
      }
    return longest_link * static_cast<double>(grid.n_nodes());
  }

  const Scene& scene_;
  const LinkLimits& unit_;
  int component_;
  std::vector<PathEnd> ends_; ///< with the prescribed values
};

/// The largest |difference of prescribed values| / shortest path, over all pairs of prescribed nodes that are
/// joined: the scale at which the scene's moves just use the slack up. 0 where no joined pair differs.
///
/// Newton's method for largest ratios: at a trial scale one search from all nodes at once finds the pair that
/// is farthest from joined, whose ratio (the best of that node's) is the next scale, until no pair is apart.
/// Scales only grow; two to six pairs of searches, whereas a search from every value that is prescribed takes
/// thousands where a handle turns.
///
/// Source  Dinkelbach, On nonlinear fractional programming (1967), Management Science 13, 492
/// @param unit  links whose slack, alike in both directions, is that of a scale of 1
double taut_scale(const Scene& scene, const LinkLimits& unit) {
  const std::vector<Prescribed> prescribed = prescribed_in_object(scene, object_frame(scene));
  double scale = 0;
  for (int component = 0; component < scene.dimension(); ++component)
    scale = std::max(scale, ComponentScale(scene, unit, component, prescribed).find());
  return scale;
}

/// Limits, given or of the matter in a cell, along the object's axes.
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

/// What tells cells apart: material and fibre.
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
  cell_class_.assign(static_cast<std::size_t>(body.grid.n_cells()), -1);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      cell_class_[static_cast<std::size_t>(cell)] =
          class_of.try_emplace(kind_in(body, cell), static_cast<std::int32_t>(class_of.size())).first->second;
  classes_.reserve(class_of.size());
  // Classes are numbered as they come.
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (cell_class_[static_cast<std::size_t>(cell)] == static_cast<std::int32_t>(classes_.size()))
      add_class(cell);
}

std::int64_t LinkLimits::bytes_at_most(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (is_of_one_kind(scene))
    return sizeof(OfCell);
  // A few thousand are counted; where there are more, every cell is taken for one of its own.
  constexpr std::size_t most_counted = 4096;
  std::set<CellKind> kinds;
  if (!body.fibres.empty())
    for (std::int64_t cell = 0; cell < body.grid.n_cells() && kinds.size() <= most_counted; ++cell)
      if (body.is_matter(cell))
        kinds.insert(kind_in(body, cell));
  const std::int64_t n = body.fibres.empty()            ? std::ssize(scene.materials)
                         : kinds.size() <= most_counted ? std::ssize(kinds)
                                                        : body.n_matter_cells();
  // While they are told apart, every kind stands in a tree, too: its key and number, and three pointers and a
  // colour.
  constexpr std::int64_t in_a_tree = 64;
  return body.grid.n_cells() * std::int64_t{sizeof(std::int32_t)} +
         n * (std::int64_t{sizeof(OfCell)} + in_a_tree);
}

std::optional<LinkIntervals<double>> LinkLimits::intervals(const Index3& node, int axis) const {
  std::optional<LinkIntervals<double>> link;
  specimen_->for_each_cell_at_link(node, axis, [&](std::int64_t cell) {
    const auto& of_cell = classes_[static_cast<std::size_t>(kind_of(cell))][static_cast<std::size_t>(axis)];
    if (link)
      link->narrow_to(of_cell);
    else
      link = of_cell;
  });
  return link;
}

std::int64_t LinkLimits::bytes() const {
  return static_cast<std::int64_t>(classes_.capacity() * sizeof(OfCell) +
                                   cell_class_.capacity() * sizeof(std::int32_t));
}

} // namespace maille
