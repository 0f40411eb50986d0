#include "world/occupancy/self_contact.hpp"

#include "lattice/binned_boxes.hpp"
#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// In two dimensions; touching counts.
bool do_segments_cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d) {
  const auto side = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  };
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

/// True if a segment crosses a triangle. Source  Moeller and Trumbore 1997.
bool does_segment_cross(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& a,
                        const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d way = to - from, ab = b - a, ac = c - a, across = way.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) < std::numeric_limits<double>::min())
    return false;
  const Eigen::Vector3d off = from - a, turned = off.cross(ab);
  const double u = off.dot(across) / determinant, v = way.dot(turned) / determinant,
               t = ac.dot(turned) / determinant;
  return u >= -tolerance && v >= -tolerance && u + v <= 1 + tolerance && t >= 0 && t <= 1;
}

constexpr int bisections = 8;
/// Wider gaps at rest count as this width [cells]; no cell at this distance is a near one.
constexpr int gap_looked_at = near_steps + 1;

/// True if limits prevent a full box from folding: the symmetric part of every cell's deformation gradient is
/// diagonally dominant, hence positive, and no path between two points of a convex body is reversed.
bool keep_a_box_in_order(const Specimen& specimen, const LinkLimits& limits) {
  const Grid& grid = specimen.grid;
  const auto d = static_cast<std::size_t>(grid.dimension());
  if (specimen.n_matter_cells() != grid.n_cells())
    return false;
  return std::ranges::all_of(limits.kinds(), [&](const LinkLimits::OfCell& cell) {
    for (std::size_t a = 0; a < d; ++a) {
      double least = 1 + cell[a].low[a] / grid.spacing()[a];
      for (std::size_t b = 0; b < d; ++b)
        if (b != a)
          for (const auto& [along, of] : {std::pair(a, b), std::pair(b, a)})
            least -= 0.5 * std::max(std::abs(cell[along].low[of]), std::abs(cell[along].high[of])) /
                     grid.spacing()[along];
      if (!(least > 0))
        return false;
    }
    return true;
  });
}

/// True if a body is a full box that is not slender: its sides can meet only if the matter between is
/// inverted.
bool is_compact(const Specimen& specimen, int dimension) {
  constexpr double slender = 4; // longest side over shortest
  const Grid& grid = specimen.grid;
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a) {
    const double side = grid.cells()[a] * grid.spacing()[a];
    least = std::min(least, side);
    most = std::max(most, side);
  }
  return specimen.n_matter_cells() == grid.n_cells() && most <= slender * least;
}

/// Range of nodal values, combined over components.
template<class Value>
double range_of(int dimension, std::int32_t n_nodes, Value&& value) {
  double sum = 0;
  for (int component = 0; component < dimension; ++component) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::int32_t node = 0; node < n_nodes; ++node) {
      low = std::min(low, value(component, node));
      high = std::max(high, value(component, node));
    }
    sum = std::hypot(sum, high - low);
  }
  return sum;
}

/// Numbers of cells of matter in the order of the grid, -1 elsewhere.
std::vector<std::int32_t> numbers_of_matter(const Specimen& specimen) {
  std::vector<std::int32_t> number(specimen.grid.n_cells(), -1);
  std::int32_t n = 0;
  for (std::int64_t cell = 0; cell < specimen.grid.n_cells(); ++cell)
    if (specimen.is_matter(cell))
      number[cell] = n++;
  return number;
}

} // namespace

SelfContact::SelfContact(const Specimen& specimen, const PosedLattice& lattice, const BodyMatter& matter,
                         const LinkLimits* limits)
    : dimension_(lattice.dimension()) {
  const Vec3& spacing = specimen.grid.spacing();
  const double least = *std::min_element(spacing.begin(), spacing.begin() + dimension_),
               most = *std::max_element(spacing.begin(), spacing.begin() + dimension_);
  step_ = step_over_cell * least;
  bin_ = 1.5 * most;
  is_never_ = dimension_ == 1 || is_compact(specimen, dimension_) ||
              (limits != nullptr && keep_a_box_in_order(specimen, *limits));
  if (is_never_)
    return;
  for (const BodyMatter::Face& face : matter.faces())
    faces_.push_back({face.node, face.cell, 1});
  Places rest;
  for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel)
    rest.push_back(lattice.rest(voxel));
  for (Face& face : faces_) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    const auto corners = matter.corners(face.cell);
    for (const std::int32_t corner : corners)
      middle += rest[corner] / static_cast<double>(corners.size());
    face.outwards = normal(face, rest).dot(rest[face.node[0]] - middle) > 0 ? 1 : -1;
  }
  find_neighbours(specimen);
  find_edges();
  find_clearance(specimen);
}

void SelfContact::find_neighbours(const Specimen& specimen) {
  const Grid& grid = specimen.grid;
  const std::vector<std::int32_t> number = numbers_of_matter(specimen);
  beside_.assign(specimen.n_matter_cells(), {-1, -1, -1, -1, -1, -1});
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const std::int32_t own = number[cell];
    for (std::size_t side = 0; own >= 0 && side < 6; ++side) {
      Index3 next = grid.cell_at(cell);
      next[side / 2] += side % 2 == 0 ? -1 : 1;
      if (grid.has_cell(next))
        beside_[own][side] = number[grid.cell(next)];
    }
  }
}

void SelfContact::find_edges() {
  const auto add = [&](const Face& face, std::size_t i, std::size_t j) {
    const auto [low, high] = std::minmax(face.node[i], face.node[j]);
    edges_.push_back({{low, high}, face.cell});
  };
  for (const Face& face : faces_) {
    add(face, 0, 1);
    if (dimension_ == 2)
      continue;
    add(face, 2, 3);
    add(face, 0, 2);
    add(face, 1, 3);
    add(face, 0, 3); // between its two triangles
  }
  std::ranges::stable_sort(edges_, {}, &Edge::node);
  const auto same = std::ranges::unique(edges_, {}, &Edge::node);
  edges_.erase(same.begin(), same.end());
}

/// Cells within a few steps of a cell, including it, sorted.
std::vector<std::int32_t> SelfContact::near(std::int32_t cell) const {
  std::vector<std::int32_t> known{cell};
  std::size_t begin = 0;
  for (int step = 0; step < near_steps; ++step)
    for (const std::size_t end = known.size(); begin < end; ++begin)
      for (const std::int32_t next : beside_[known[begin]])
        if (next >= 0 && std::ranges::find(known, next) == known.end())
          known.push_back(next);
  std::ranges::sort(known);
  return known;
}

bool SelfContact::is_near(std::int32_t one, std::int32_t other) const {
  return std::ranges::binary_search(near(one), other);
}

/// Sets the smallest distance at rest between cells of the surface that are far from each other in the body.
void SelfContact::find_clearance(const Specimen& specimen) {
  const Grid& grid = specimen.grid;
  const std::vector<std::int32_t> number = numbers_of_matter(specimen);
  std::vector<Index3> at;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (specimen.is_matter(cell))
      at.push_back(grid.cell_at(cell));
  double least = gap_looked_at;
  std::int32_t last = -1;
  for (const Face& face : faces_) {
    if (face.cell == last)
      continue;
    last = face.cell;
    const std::vector<std::int32_t> known = near(face.cell);
    const Index3 here = at[face.cell];
    const int reach = gap_looked_at;
    const int reach_z = dimension_ == 3 ? reach : 0;
    for (int z = -reach_z; z <= reach_z; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const Index3 there{here[0] + x, here[1] + y, here[2] + z};
          if (!grid.has_cell(there))
            continue;
          const std::int32_t other = number[grid.cell(there)];
          if (other < 0 || std::ranges::binary_search(known, other))
            continue;
          const double gap = std::max({std::abs(x), std::abs(y), std::abs(z)}) - 1.0;
          least = std::min(least, gap);
        }
  }
  clearance_ = least * step_ / step_over_cell;
}

/// Upper bound of the change of distance between two nodes [m].
double SelfContact::spread(const PosedLattice& lattice, const Displacement& at) const {
  return range_of(dimension_, lattice.n_voxels(),
                  [&](int component, std::int32_t voxel) { return at(component, lattice.node(voxel)); });
}

bool SelfContact::may_meet(std::span<const double> displacement, double margin) const {
  if (is_never_)
    return false;
  const auto n = static_cast<std::int32_t>(displacement.size()) / dimension_;
  return range_of(
             dimension_, n,
             [&](int component, std::int32_t node) { return displacement[dimension_ * node + component]; }) +
             margin >=
         clearance_;
}

bool SelfContact::do_cross(const Edge& edge, const Face& face, const Places& at) const {
  for (const std::int32_t node : face.node)
    if (node == edge.node[0] || node == edge.node[1])
      return false;
  const auto place = [&](std::int32_t node) -> const Eigen::Vector3d& { return at[node]; };
  const Eigen::Vector3d &a = place(edge.node[0]), &b = place(edge.node[1]);
  if (dimension_ == 2)
    return do_segments_cross(a, b, place(face.node[0]), place(face.node[1]));
  return does_segment_cross(a, b, place(face.node[0]), place(face.node[1]), place(face.node[3])) ||
         does_segment_cross(a, b, place(face.node[0]), place(face.node[3]), place(face.node[2]));
}

std::vector<SelfContact::Crossing> SelfContact::crossings(const Places& at) const {
  BinnedBoxes bins(bin_);
  const auto box_of = [&](std::span<const std::int32_t> nodes) {
    Eigen::AlignedBox3d box;
    for (const std::int32_t node : nodes)
      if (node >= 0)
        box.extend(at[node]);
    return box;
  };
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Face& face : faces_) {
    boxes.push_back(box_of(face.node));
    bins.add(static_cast<std::int32_t>(boxes.size()) - 1, boxes.back());
  }
  bins.sort();
  std::vector<Crossing> list;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const Edge& edge = edges_[i];
    const Eigen::AlignedBox3d box = box_of(edge.node);
    const std::size_t n_before = list.size();
    bins.visit(box, [&](std::int32_t number) {
      const Face& face = faces_[number];
      if (!boxes[number].intersects(box) || !do_cross(edge, face, at))
        return;
      const bool is_known = std::any_of(list.begin() + static_cast<std::ptrdiff_t>(n_before), list.end(),
                                        [&](const Crossing& known) { return known.face == number; });
      if (!is_known && !is_near(edge.cell, face.cell))
        list.push_back({static_cast<std::int32_t>(i), number});
    });
  }
  return list;
}

Eigen::Vector3d SelfContact::normal(const Face& face, const Places& at) const {
  const auto place = [&](std::size_t i) -> const Eigen::Vector3d& { return at[face.node[i]]; };
  if (dimension_ == 2) {
    const Eigen::Vector3d along = place(1) - place(0);
    return face.outwards * Eigen::Vector3d(along[1], -along[0], 0);
  }
  return face.outwards * (place(3) - place(0)).cross(place(2) - place(1));
}

Eigen::Vector3d SelfContact::from_face_to_edge(const Crossing& crossing, const Places& at) const {
  const Edge& edge = edges_[crossing.edge];
  const Face& face = faces_[crossing.face];
  Eigen::Vector3d off = Eigen::Vector3d::Zero();
  const std::size_t n = dimension_ == 3 ? 4 : 2;
  for (const std::int32_t node : edge.node)
    off += 0.5 * at[node];
  for (std::size_t i = 0; i < n; ++i)
    off -= at[face.node[i]] / static_cast<double>(n);
  return off;
}

/// New crossings of edges that were outside of the face before; other crossings become known. As long as none
/// is known, all edges come from outside, even if the middle of the edge is behind the plane of an oblique
/// face.
std::vector<SelfContact::Crossing> SelfContact::from_outside(const Places& at, const Places& before,
                                                             std::vector<Crossing>& known) const {
  std::vector<Crossing> list;
  const bool is_apart = known.empty();
  for (const Crossing& crossing : crossings(at)) {
    const auto place = std::ranges::lower_bound(known, crossing);
    if (place != known.end() && *place == crossing)
      continue;
    const Face& face = faces_[crossing.face];
    if (normal(face, before).dot(from_face_to_edge(crossing, before)) > 0 || is_apart)
      list.push_back(crossing);
    else
      known.insert(place, crossing);
  }
  return list;
}

std::vector<SelfHit> SelfContact::hits_of(const std::vector<Crossing>& crossed, const Places& free,
                                          double time) const {
  std::vector<SelfHit> hits;
  const auto add = [&](std::int32_t node, std::int32_t partner, int axis, int direction) {
    const bool is_known =
        std::ranges::any_of(hits, [&](const SelfHit& hit) { return hit.voxel == node && hit.axis == axis; });
    if (!is_known)
      hits.push_back({node, partner, axis, direction, time});
  };
  const std::size_t n = dimension_ == 3 ? 4 : 2;
  for (const Crossing& crossing : crossed) {
    const Edge& edge = edges_[crossing.edge];
    const Face& face = faces_[crossing.face];
    const Eigen::Vector3d across = normal(face, free);
    int axis = 0;
    across.cwiseAbs().maxCoeff(&axis);
    const int direction = across[axis] > 0 ? -1 : 1; // from the edge, which comes from outside, to the face
    for (const std::int32_t node : edge.node)
      add(node, face.node[0], axis, direction);
    for (std::size_t i = 0; i < n; ++i)
      add(face.node[i], edge.node[0], axis, -direction);
  }
  return hits;
}

std::vector<SelfHit> SelfContact::find(const PosedLattice& lattice, const Displacement& from,
                                       const Displacement& to) const {
  if (is_never_ || std::max(spread(lattice, from), spread(lattice, to)) < clearance_)
    return {};
  const auto n = static_cast<std::size_t>(lattice.n_voxels());
  Places begin(n), end(n), at(n);
  double furthest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    begin[i] = lattice.position(static_cast<std::int32_t>(i), from);
    end[i] = lattice.position(static_cast<std::int32_t>(i), to);
    furthest = std::max(furthest, (end[i] - begin[i]).cwiseAbs().maxCoeff());
  }
  if (furthest == 0)
    return {};
  const auto go = [&](double time) {
    for (std::size_t i = 0; i < n; ++i)
      at[i] = begin[i] + time * (end[i] - begin[i]);
  };
  const double steps = std::clamp(std::ceil(furthest / step_), 1.0, furthest_cell);
  std::vector<Crossing> known = crossings(begin);
  std::ranges::sort(known);
  Places before = begin;
  for (double step = 1; step <= steps; ++step) {
    go(step / steps);
    const std::vector<Crossing> crossed = from_outside(at, before, known);
    if (crossed.empty()) {
      before = at;
      continue;
    }
    double free = (step - 1) / steps, blocked = step / steps;
    for (int i = 0; i < bisections; ++i) {
      const double middle = 0.5 * (free + blocked);
      go(middle);
      (from_outside(at, before, known).empty() ? free : blocked) = middle;
    }
    go(free);
    return hits_of(crossed, at, free); // all crossings of this step
  }
  return {};
}

std::int64_t SelfContact::bytes() const {
  return static_cast<std::int64_t>(faces_.capacity() * sizeof(Face) + edges_.capacity() * sizeof(Edge) +
                                   beside_.capacity() * sizeof(beside_[0]));
}

} // namespace maille::deform
