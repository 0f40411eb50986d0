
#include "feasible/bounds/bound_source.hpp"

#include <algorithm>

namespace maille::deform {

void DijkstraBounds::bounds_at(Side side, int component, std::span<const PathEnd> ends,
                               std::span<const std::int64_t> nodes, std::span<double> values) {
  const List<double> all = side == Side::greatest ? upper_envelope(scene_, limits_, component, ends)
                                                  : lower_envelope(scene_, limits_, component, ends);
  std::ranges::transform(nodes, values.begin(), [&](std::int64_t node) { return all[node]; });
}

List<double> upper_envelope(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends) {
  return shortest_paths(scene, limits, component, ends, PathDirection::from_ends);
}

List<double> lower_envelope(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends) {
  // max(p - d) = -min(-p + d)
  List<PathEnd> negated(ends.begin(), ends.end());
  for (PathEnd& end : negated)
    end.potential = -end.potential;
  List<double> lowest = shortest_paths(scene, limits, component, negated, PathDirection::to_ends);
  for (double& value : lowest)
    value = 0.0 - value; // and not -value: no negative zeros
  return lowest;
}

namespace {

/// The lower corner of some cell of matter: all its links along the upper axes exist.
Index3 corner_of_matter(const Specimen& body) {
  std::int64_t cell = 0;
  while (!body.is_matter(cell))
    ++cell;
  return body.grid.cell_at(cell);
}

bool has_link(const Specimen& body, const Index3& near, std::size_t axis) {
  for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner) {
    if ((corner >> axis & 1) != 0)
      continue;
    const Index3 cell{near[0] - (corner & 1), near[1] - (corner >> 1 & 1), near[2] - (corner >> 2 & 1)};
    if (body.grid.has_cell(cell) && body.is_matter(body.grid.cell(cell)))
      return true;
  }
  return false;
}

/// Reached nodes, in the present slab and the previous one on the way from `from`.
class Frontier {
public:
  Frontier(const Specimen& body, const Index3& from)
      : body_(body), from_(from), width_(body.grid.nodes()[0]),
        now_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(body.grid.nodes()[1])),
        before_(now_.size()) {}

  /// Marks the reached nodes of slab z; false if a node of matter is not reached. Slabs are visited outward.
  bool reach_slab(int z) {
    now_.swap(before_);
    for (const bool up : {true, false})
      for (int y = from_[1] + (up ? 0 : -1); y >= 0 && y < body_.grid.nodes()[1]; y += up ? 1 : -1)
        if (!reach_row(y, z))
          return false;
    return true;
  }

private:
  bool reach_row(int y, int z) {
    for (const bool up : {true, false})
      for (int x = from_[0] + (up ? 0 : -1); x >= 0 && x < width_; x += up ? 1 : -1) {
        const Index3 at{x, y, z};
        const bool reached = at == from_ || comes_from(at, 0) || comes_from(at, 1) || comes_from(at, 2);
        now_[place(x, y)] = reached ? 1 : 0;
        if (!reached && body_.is_node(at))
          return false;
      }
    return true;
  }
  /// True if the node before `at` along the axis is reached and linked to it.
  bool comes_from(const Index3& at, std::size_t axis) {
    if (at[axis] == from_[axis])
      return false;
    Index3 before = at, near = at;
    before[axis] += at[axis] > from_[axis] ? -1 : 1;
    if (before[axis] < near[axis])
      near = before;
    const auto& slab = axis == 2 ? before_ : now_;
    return slab[place(before[0], before[1])] != 0 && has_link(body_, near, axis);
  }
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(x) + static_cast<std::size_t>(width_) * static_cast<std::size_t>(y);
  }

  const Specimen& body_;
  Index3 from_;
  int width_;
  std::vector<std::uint8_t> now_, before_;
};

} // namespace

std::array<LinkIntervals<double>, 3> intervals_by_axis(const Scene& scene, const LinkLimits& limits) {
  std::array<LinkIntervals<double>, 3> of_component{};
  const Index3 corner = corner_of_matter(scene.specimen);
  for (int axis = 0; axis < scene.dimension(); ++axis) {
    const LinkIntervals<double> link = limits.intervals(corner, axis).value();
    for (int b = 0; b < scene.dimension(); ++b) {
      of_component[b].low[axis] = link.low[b];
      of_component[b].high[axis] = link.high[b];
    }
  }
  return of_component;
}

double slack_range(const LinkIntervals<double>& by_axis, const Index3& nodes) {
  double sum = 0;
  for (std::size_t a = 0; a < 3; ++a)
    sum += (nodes[a] - 1) * (by_axis.high[a] - by_axis.low[a]);
  return sum;
}

bool reaches_all_monotonely(const Specimen& body, const Index3& from) {
  for (const bool up : {true, false}) {
    Frontier frontier(body, from);
    for (int z = from[2]; z >= 0 && z < body.grid.nodes()[2]; z += up ? 1 : -1)
      if (!frontier.reach_slab(z))
        return false;
  }
  return true;
}

} // namespace maille::deform
