#include "world/surface/skin.hpp"

#include "lattice/binned_boxes.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Cosine of 40 degrees: faces at smaller angles share a normal at their common edge.
constexpr double least_smooth_cosine = 0.766;
/// Distance from an edge, as a part of the reach, below which a point is on the edge [1].
constexpr double edge_over_reach = 1e-3;
/// The smooth normal is used if the point is further along it than this part of its distance [1].
constexpr double least_part = 0.5;

/// Barycentric coordinates of the point of a triangle nearest to a point.
/// Source  Ericson, Real-Time Collision Detection (2005), 5.1.5
std::array<double, 3> nearest_in_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                          const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0)
    return {1, 0, 0};
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3)
    return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0)
    return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6)
    return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0)
    return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

} // namespace

Skin::Skin(const Specimen& specimen) : dimension_(specimen.grid.dimension()) {
  const Grid& grid = specimen.grid;
  std::vector<std::int32_t> number(grid.n_cells(), -1);
  std::int32_t n = 0;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (specimen.is_matter(cell))
      number[cell] = n++;
  beside_.assign(n, {-1, -1, -1, -1, -1, -1});
  add_faces(specimen, number);
  at_node_.resize(nodes_.size());
  for (std::size_t face = 0; face < faces_.size(); ++face)
    for (const std::int32_t node : faces_[face].node)
      if (node >= 0)
        at_node_[node].push_back(static_cast<std::int32_t>(face));
}

void Skin::add_faces(const Specimen& specimen, const std::vector<std::int32_t>& cell_number) {
  const Grid& grid = specimen.grid;
  const auto d = static_cast<std::size_t>(dimension_);
  std::vector<std::int32_t> number_of(grid.n_nodes(), -1);
  const auto number = [&](const Index3& node) {
    std::int32_t& known = number_of[grid.node(node)];
    if (known < 0) {
      known = n_nodes();
      nodes_.push_back(grid.node(node));
    }
    return known;
  };
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const std::int32_t own = cell_number[cell];
    if (own < 0)
      continue;
    const Index3 at = grid.cell_at(cell);
    for (std::size_t side = 0; side < 2 * d; ++side) {
      const std::size_t a = side / 2, b = (a + 1) % d, c = (a + 2) % d;
      const bool is_upper = side % 2 == 1;
      Index3 beside = at;
      beside[a] += is_upper ? 1 : -1;
      if (const std::int32_t next = grid.has_cell(beside) ? cell_number[grid.cell(beside)] : -1; next >= 0) {
        beside_[own][side] = next;
        continue;
      }
      Index3 first = at;
      first[a] += is_upper;
      Index3 second = first, third = first, fourth = first;
      ++second[b], ++third[b];
      if (dimension_ == 3)
        ++third[c], ++fourth[c];
      Face face{{-1, -1, -1, -1}, own};
      if (dimension_ == 2) {
        // The outside is to the right of the direction from the first node to the second: along y at the
        // upper side along x.
        const bool is_along = is_upper == (a == 0);
        face.node = {number(is_along ? first : second), number(is_along ? second : first), -1, -1};
      } else {
        face.node = {number(first), number(is_upper ? second : fourth), number(third),
                     number(is_upper ? fourth : second)};
      }
      faces_.push_back(face);
    }
  }
}

void Skin::mark_near(std::int32_t node, std::int32_t mark, std::vector<std::int32_t>& marks) const {
  std::vector<std::int32_t> known;
  const auto add = [&](std::int32_t cell) {
    if (cell >= 0 && std::exchange(marks[cell], mark) != mark)
      known.push_back(cell);
  };
  for (const std::int32_t face : faces_at(node))
    add(faces_[face].cell);
  std::size_t begin = 0;
  for (int step = 0; step < near_steps; ++step)
    for (const std::size_t end = known.size(); begin < end; ++begin)
      for (const std::int32_t next : beside_[known[begin]])
        add(next);
}

namespace {

/// Marks points that have moved further than `much`, and updates their reference positions.
std::vector<char> moved(std::span<const Eigen::Vector3d> now, std::vector<Eigen::Vector3d>& then,
                        double much) {
  std::vector<char> is_moved(now.size(), 1);
  if (then.size() != now.size()) {
    then.assign(now.begin(), now.end());
    return is_moved;
  }
  for (std::size_t i = 0; i < now.size(); ++i) {
    is_moved[i] = (now[i] - then[i]).norm() > much;
    if (is_moved[i] != 0)
      then[i] = now[i];
  }
  return is_moved;
}

} // namespace

void NearFaces::update(const Skin& of_nodes, std::span<const Eigen::Vector3d> nodes, const Skin& of_faces,
                       std::span<const Eigen::Vector3d> faces, double reach, double margin) {
  // The nodes of either skin may have moved by a quarter since the last search.
  const std::vector<char> is_moved = moved(nodes, nodes_then_, margin / 4),
                          corner_is_moved = moved(faces, faces_then_, margin / 4);
  std::vector<std::int32_t> moved_nodes, other_nodes, moved_faces, all_faces;
  for (std::int32_t node = 0; node < of_nodes.n_nodes(); ++node)
    (is_moved[node] != 0 ? moved_nodes : other_nodes).push_back(node);
  std::vector<char> face_is_moved;
  for (const Skin::Face& face : of_faces.faces()) {
    const auto number = static_cast<std::int32_t>(all_faces.size());
    face_is_moved.push_back(std::ranges::any_of(
        face.node, [&](std::int32_t node) { return node >= 0 && corner_is_moved[node] != 0; }));
    if (face_is_moved.back() != 0)
      moved_faces.push_back(number);
    all_faces.push_back(number);
  }
  if (moved_nodes.empty() && moved_faces.empty())
    return;
  std::vector<Pair> pairs;
  for (const OfNode& one : nodes_)
    for (const std::int32_t face : this->faces(one))
      if (is_moved[one.node] == 0 && face_is_moved[face] == 0)
        pairs.emplace_back(one.node, face);
  find(of_nodes, moved_nodes, of_faces, all_faces, reach + margin, pairs);
  find(of_nodes, other_nodes, of_faces, moved_faces, reach + margin, pairs);
  std::ranges::sort(pairs);
  nodes_.clear();
  faces_.clear();
  for (const auto& [node, face] : pairs) {
    if (nodes_.empty() || nodes_.back().node != node)
      nodes_.push_back({node, faces_.size(), 0});
    faces_.push_back(face);
    nodes_.back().end = faces_.size();
  }
}

/// Adds all near pairs of the given nodes and faces.
void NearFaces::find(const Skin& of_nodes, std::span<const std::int32_t> nodes, const Skin& of_faces,
                     std::span<const std::int32_t> faces, double reach, std::vector<Pair>& pairs) const {
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(reach);
  Eigen::AlignedBox3d of_all_nodes, of_all_faces;
  for (const std::int32_t node : nodes)
    of_all_nodes.extend(nodes_then_[node]);
  std::vector<std::pair<std::int32_t, Eigen::AlignedBox3d>> boxes;
  double edge = 0;
  for (const std::int32_t face : faces) {
    Eigen::AlignedBox3d box;
    for (const std::int32_t node : of_faces.face(face).node)
      if (node >= 0)
        box.extend(faces_then_[node]);
    box = Eigen::AlignedBox3d(box.min() - around, box.max() + around);
    if (!box.intersects(of_all_nodes))
      continue;
    edge = std::max(edge, box.sizes().maxCoeff());
    of_all_faces.extend(box);
    boxes.emplace_back(face, box);
  }
  BinnedBoxes bins(edge);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    bins.add(static_cast<std::int32_t>(i), boxes[i].second);
  bins.sort();
  const bool is_itself = &of_nodes == &of_faces;
  std::vector<std::int32_t> marks(is_itself ? of_faces.n_cells() : 0, -1);
  for (const std::int32_t node : nodes) {
    const Eigen::Vector3d& point = nodes_then_[node];
    if (!of_all_faces.contains(point))
      continue;
    bool is_marked = !is_itself;
    bins.visit({point, point}, [&](std::int32_t i) {
      const auto& [face, box] = boxes[i];
      if (!box.contains(point))
        return;
      if (!std::exchange(is_marked, true))
        of_faces.mark_near(node, node, marks);
      const std::int32_t cell = of_faces.face(face).cell;
      if (!is_itself || marks[cell] != node)
        pairs.emplace_back(node, face);
    });
  }
}

std::vector<PlacedSkin::Near> PlacedSkin::near(const Eigen::Vector3d& point,
                                               std::span<const std::int32_t> faces, const PlacedSkin* own,
                                               std::int32_t node) const {
  std::vector<Closest> found;
  const double far = reach_ * (1 + tolerance);
  for (const std::int32_t face : faces) {
    Eigen::AlignedBox3d box;
    for (const std::int32_t corner : skin_.face(face).node)
      if (corner >= 0)
        box.extend(at(corner));
    if (box.squaredExteriorDistance(point) > far * far)
      continue;
    if (const Closest one = closest(face, point); one.distance <= reach_)
      found.push_back(one);
  }
  if (const auto one = own != nullptr ? faced(point, found, *own, node) : std::nullopt)
    return {*one};
  return nearest(point, found);
}

/// For a point on a sharp edge: the face that the node's own skin faces.
std::optional<PlacedSkin::Near> PlacedSkin::faced(const Eigen::Vector3d& point,
                                                  std::span<const Closest> found, const PlacedSkin& own,
                                                  std::int32_t node) const {
  const double near = edge_over_reach * reach_;
  if (found.size() < 2 ||
      std::ranges::none_of(found, [&](const Closest& one) { return one.distance <= near; }))
    return std::nullopt;
  std::optional<Near> best;
  bool is_sharp = false, is_alone = true;
  for (const Closest& one : found) {
    const Eigen::Vector3d normal = normal_of(one.face), off = point - one.place;
    const double gap = normal.dot(off);
    if (gap > near || (off - gap * normal).norm() > near)
      continue;
    is_sharp = is_sharp || std::ranges::any_of(found, [&](const Closest& other) {
                 return other.distance <= near && is_edge(one.face, other.face);
               });
    if (std::ranges::none_of(own.skin_.faces_at(node), [&](std::int32_t face) {
          return own.normal_of(face).dot(normal) < -least_smooth_cosine;
        }))
      continue;
    is_alone = is_alone &&
               (!best || std::min(gap, best->gap) < -near || best->normal.dot(normal) > least_smooth_cosine);
    if (!best || gap > best->gap)
      best = Near{skin_.face(one.face).node, one.weight, one.face, normal, gap};
  }
  return is_sharp && is_alone ? best : std::nullopt;
}

namespace {

Eigen::Vector3d normal_at(const Skin& skin, std::int32_t number, std::span<const Eigen::Vector3d> places) {
  const auto at = [&](std::size_t i) { return places.begin()[skin.face(number).node[i]]; };
  if (skin.dimension() == 2) {
    const Eigen::Vector3d along = at(1) - at(0);
    return Eigen::Vector3d(along[1], -along[0], 0).normalized();
  }
  return (at(2) - at(0)).cross(at(3) - at(1)).normalized();
}

} // namespace

Eigen::Vector3d PlacedSkin::normal_of(std::int32_t face) const {
  return normal_at(skin_, face, places_);
}

bool PlacedSkin::is_edge(std::int32_t face, std::int32_t other) const {
  return normal_at(skin_, face, rest_).dot(normal_at(skin_, other, rest_)) <= least_smooth_cosine;
}

PlacedSkin::Closest PlacedSkin::closest(std::int32_t number, const Eigen::Vector3d& point) const {
  const Skin::Face& face = skin_.face(number);
  Closest best{number, {}, Eigen::Vector3d::Zero(), std::numeric_limits<double>::infinity(), false};
  if (skin_.dimension() == 2) {
    const Eigen::Vector3d& from = at(face.node[0]);
    const Eigen::Vector3d along = at(face.node[1]) - from;
    const double t = std::clamp(along.dot(point - from) / along.squaredNorm(), 0.0, 1.0);
    best.weight = {1 - t, t, 0, 0};
    best.place = from + t * along;
    best.distance = (point - best.place).norm();
    best.is_within = t > tolerance && t < 1 - tolerance;
    return best;
  }
  for (const std::array<std::size_t, 3>& corners :
       {std::array<std::size_t, 3>{0, 1, 2}, std::array<std::size_t, 3>{0, 2, 3}}) {
    const auto weights = nearest_in_triangle(point, at(face.node[corners[0]]), at(face.node[corners[1]]),
                                             at(face.node[corners[2]]));
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      place += weights[i] * at(face.node[corners[i]]);
    const double distance = (point - place).norm();
    if (!(distance < best.distance))
      continue;
    best.distance = distance;
    best.place = place;
    best.weight = {};
    for (std::size_t i = 0; i < 3; ++i)
      best.weight[corners[i]] = weights[i];
    // The common edge of the two triangles is interior to the face. On the border of the face, two adjacent
    // corners have all the weight.
    best.is_within = true;
    for (std::size_t i = 0; i < 4; ++i)
      if (best.weight[i] + best.weight[(i + 1) % 4] > 1 - tolerance)
        best.is_within = false;
  }
  return best;
}

/// Normal at a point of a face, interpolated from those at its corners.
Eigen::Vector3d PlacedSkin::smooth_normal(const Closest& one) const {
  const auto& nodes = skin_.face(one.face).node;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < 0 || one.weight[i] == 0)
      continue;
    Eigen::Vector3d at_corner = Eigen::Vector3d::Zero();
    for (const std::int32_t face : skin_.faces_at(nodes[i]))
      if (!is_edge(one.face, face))
        at_corner += normal_of(face);
    sum += one.weight[i] * at_corner.normalized();
  }
  return sum.normalized();
}

/// Selects the local minima; a point on the border of a face counts only if no adjacent face is nearer.
std::vector<PlacedSkin::Near> PlacedSkin::nearest(const Eigen::Vector3d& point,
                                                  std::vector<Closest>& found) const {
  std::vector<Near> list;
  if (found.empty())
    return list;
  std::ranges::stable_sort(found, {}, &Closest::distance);
  const double same = tolerance * reach_;
  const auto is_of_face = [&](const Closest& one, std::int32_t face) {
    const auto& nodes = skin_.face(face).node;
    const auto& own = skin_.face(one.face).node;
    for (std::size_t i = 0; i < 4; ++i)
      if (own[i] >= 0 && one.weight[i] > tolerance && std::ranges::find(nodes, own[i]) == nodes.end())
        return false;
    return true;
  };
  /// Outward normal at a point: the mean over the faces that contain it.
  const auto outwards = [&](const Closest& one) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Closest& other : found)
      if (&other == &one || is_of_face(one, other.face))
        sum += normal_of(other.face);
    return sum;
  };
  const Closest& first = found.front();
  const bool is_inside = outwards(first).dot(point - first.place) < 0;
  std::vector<Eigen::Vector3d> places;
  for (const Closest& one : found) {
    if (is_inside && &one != &first)
      break;
    bool counts = std::ranges::none_of(
        places, [&](const Eigen::Vector3d& known) { return (known - one.place).norm() < same; });
    if (!one.is_within)
      for (const Closest& other : found) // reject if an adjacent face is nearer
        counts = counts && !(is_of_face(one, other.face) && other.distance < one.distance - 1e-12 * reach_);
    const Eigen::Vector3d off = point - one.place;
    if (!is_inside && outwards(one).dot(off) < 0)
      counts = false;
    if (!counts)
      continue;
    places.push_back(one.place);
    Near near;
    near.node = skin_.face(one.face).node;
    near.weight = one.weight;
    near.face = one.face;
    near.gap = is_inside ? -one.distance : one.distance;
    near.normal = one.distance > same ? Eigen::Vector3d(off / near.gap) : outwards(one).normalized();
    const bool is_sharp = !one.is_within && std::ranges::any_of(found, [&](const Closest& other) {
      return is_of_face(one, other.face) && is_edge(one.face, other.face);
    });
    if (!is_sharp)
      if (const Eigen::Vector3d smooth = smooth_normal(one);
          one.distance <= same || std::abs(smooth.dot(off)) > least_part * one.distance)
        near.normal = smooth;
    list.push_back(near);
  }
  return list;
}

} // namespace maille::deform
