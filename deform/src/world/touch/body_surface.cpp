#include "maille/deform/probe/touch.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/cell_walk.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille::deform {

namespace {

/// Largest number of boxes that faces are sorted into: 16 MB. With fewer, a path tests more faces.
constexpr double most_boxes = 1 << 22;

bool is_within(const Index3& box, const Index3& size) {
  for (std::size_t a = 0; a < 3; ++a)
    if (box[a] < 0 || box[a] >= size[a])
      return false;
  return true;
}

} // namespace

BodySurface::BodySurface(const Scene& scene, const Displacement& displacement, const Pose& pose)
    : pose_(pose) {
  if (scene.dimension() != 3)
    throw std::invalid_argument("BodySurface: a body of three dimensions");
  const Vec3& spacing = scene.specimen.grid.spacing();
  skin_ = negligible * *std::ranges::min_element(spacing);
  add_faces(scene);
  place_corners(scene, displacement);
  sort_into_boxes();
}

void BodySurface::add_faces(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  std::vector<std::int32_t> corner_of(grid.n_nodes(), -1);
  const auto corner = [&](const Index3& node) {
    std::int32_t& number = corner_of[grid.node(node)];
    if (number < 0) {
      number = static_cast<std::int32_t>(nodes_.size());
      nodes_.push_back(grid.node(node));
    }
    return number;
  };
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a)
      for (const bool upper : {false, true}) {
        Index3 beside = at;
        beside[a] += upper ? 1 : -1;
        if (grid.has_cell(beside) && body.is_matter(grid.cell(beside)))
          continue;
        const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
        Index3 first = at;
        first[a] += upper;
        Index3 along = first, across = first, opposite = first;
        ++along[b], ++across[c], ++opposite[b], ++opposite[c];
        Face face{cell, static_cast<int>(a), upper, {}};
        face.corners = {corner(first), corner(upper ? along : across), corner(opposite),
                        corner(upper ? across : along)};
        faces_.push_back(face);
      }
  }
}

void BodySurface::place_corners(const Scene& scene, const Displacement& displacement) {
  positions_.reserve(nodes_.size());
  for (const std::int64_t node : nodes_) {
    const Vec3 rest = scene.specimen.position(scene.specimen.grid.node_at(node));
    Eigen::Vector3d at = Eigen::Vector3d::Map(rest.data());
    if (!displacement.empty())
      for (int a = 0; a < 3; ++a)
        at[a] += displacement(a, node);
    positions_.emplace_back(pose_.position + pose_.rotation * at);
    if (!positions_.back().allFinite())
      throw std::invalid_argument("BodySurface: a body that is finite");
  }
}

void BodySurface::sort_into_boxes() {
  if (positions_.empty())
    throw std::invalid_argument("BodySurface: a body with matter");
  low_ = high_ = positions_.front();
  for (const Eigen::Vector3d& at : positions_)
    low_ = low_.cwiseMin(at), high_ = high_.cwiseMax(at);
  double longest = 0; // largest diagonal of a face
  for (const Face& face : faces_)
    longest = std::max(longest, (position(face.corners[2]) - position(face.corners[0])).norm());
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(longest);
  low_ -= margin;
  high_ += margin;
  const Eigen::Vector3d size = high_ - low_;
  edge_ = std::max(longest, std::cbrt(size.prod() / most_boxes));
  for (std::size_t a = 0; a < 3; ++a)
    n_boxes_[a] = static_cast<int>(size[static_cast<Eigen::Index>(a)] / edge_) + 1;
  begins_.assign(number_of({0, 0, n_boxes_[2]}) + 2, 0);
  const auto for_each_box = [&](std::int32_t face, auto&& visit) {
    Eigen::Vector3d least = Eigen::Vector3d::Constant(std::numeric_limits<double>::max()), most = -least;
    for (const std::int32_t corner : faces_[face].corners)
      least = least.cwiseMin(position(corner)), most = most.cwiseMax(position(corner));
    const Index3 first = box_of(least - 8 * Eigen::Vector3d::Constant(skin_)),
                 last = box_of(most + 8 * Eigen::Vector3d::Constant(skin_));
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          visit(number_of({x, y, z}));
  };
  const auto n_faces = static_cast<std::int32_t>(faces_.size());
  for (std::int32_t face = 0; face < n_faces; ++face)
    for_each_box(face, [&](std::size_t box) { ++begins_[box + 2]; });
  for (std::size_t box = 2; box < begins_.size(); ++box)
    begins_[box] += begins_[box - 1];
  sorted_.resize(begins_.back());
  for (std::int32_t face = 0; face < n_faces; ++face)
    for_each_box(face, [&](std::size_t box) { sorted_[begins_[box + 1]++] = face; });
}

Index3 BodySurface::box_of(const Eigen::Vector3d& point) const {
  Index3 box;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    box[a] = std::clamp(static_cast<int>(std::floor((point[i] - low_[i]) / edge_)), 0, n_boxes_[a] - 1);
  }
  return box;
}

std::span<const std::int32_t> BodySurface::faces_in(const Index3& box) const {
  for (std::size_t a = 0; a < 3; ++a)
    if (box[a] < 0 || box[a] >= n_boxes_[a])
      return {};
  const std::size_t number = number_of(box);
  return std::span(sorted_).subspan(begins_[number],
                                    static_cast<std::size_t>(begins_[number + 1] - begins_[number]));
}

BodySurface::Triangle BodySurface::triangle(std::int32_t face, int half) const {
  const auto& corners = faces_[face].corners;
  return half == 0 ? Triangle{&position(corners[0]), &position(corners[1]), &position(corners[2])}
                   : Triangle{&position(corners[0]), &position(corners[2]), &position(corners[3])};
}

void BodySurface::ask(std::int32_t face, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                      std::optional<Hit>& hit) const {
  const Eigen::Vector3d path = to - from;
  for (const int half : {0, 1}) {
    const auto [a, b, c] = triangle(face, half);
    const Eigen::Vector3d ab = *b - *a, ac = *c - *a, across = ab.cross(ac);
    const double towards = -across.dot(path), distance = across.dot(from - *a);
    if (!(towards > 0) || distance < 0 || distance > towards)
      continue; // leaves the body, begins behind the face, or ends before it
    const double time = distance / towards;
    if (hit && (time > hit->time || (time == hit->time && face >= hit->face)))
      continue;
    const Eigen::Vector3d at = from + time * path - *a;
    const double area = across.squaredNorm();
    const double v = across.dot(at.cross(ac)) / area, w = across.dot(ab.cross(at)) / area;
    if (v < -tolerance || w < -tolerance || v + w > 1 + tolerance)
      continue;
    const double length = std::sqrt(area);
    hit = Hit{time, face, across / length, distance / length, towards / length};
  }
}

std::optional<BodySurface::Hit> BodySurface::first_hit(const Eigen::Vector3d& from,
                                                       const Eigen::Vector3d& to) const {
  const Eigen::Vector3d path = to - from;
  double begin = 0, end = 1; // of the part inside the boxes
  for (int a = 0; a < 3; ++a) {
    if (path[a] == 0) {
      if (from[a] < low_[a] || from[a] > high_[a])
        return std::nullopt;
      continue;
    }
    const double t0 = (low_[a] - from[a]) / path[a], t1 = (high_[a] - from[a]) / path[a];
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  if (begin > end)
    return std::nullopt;
  // The path enters and leaves through the margin, which has no faces.
  const Eigen::Vector3d entry = from + begin * path;
  CellWalk walk((entry - low_) / edge_, (1 - begin) * path / edge_, box_of(entry));
  std::optional<Hit> hit;
  for (;;) {
    for (const std::int32_t face : faces_in(walk.cell()))
      ask(face, from, to, hit);
    const double left = begin < 1 ? (end - begin) / (1 - begin) : 0;
    const auto step = walk.next(hit ? std::min((hit->time - begin) / (1 - begin), left) : left);
    if (!step)
      return hit;
  }
}

std::optional<int> BodySurface::n_crossings(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const Eigen::Vector3d way = to - from;
  CellWalk walk((from - low_) / edge_, way / edge_, box_of(from));
  std::vector<std::int32_t> crossed; // 2 face + half; faces lie in several boxes
  do {
    for (const std::int32_t face : faces_in(walk.cell()))
      for (const int half : {0, 1}) {
        const auto corners = triangle(face, half);
        const Eigen::Vector3d ab = *corners[1] - *corners[0], ac = *corners[2] - *corners[0];
        const Eigen::Vector3d across = way.cross(ac);
        const double determinant = ab.dot(across), size = ab.norm() * ac.norm() * way.norm();
        if (!(size > 0))
          continue; // degenerate triangle
        const Eigen::Vector3d off = from - *corners[0], turned = off.cross(ab);
        if (std::abs(determinant) < tolerance * size) { // parallel to the triangle
          if (std::abs(off.dot(ab.cross(ac))) < tolerance * size / way.norm() * (ab.norm() + ac.norm()))
            return std::nullopt;
          continue;
        }
        // Moeller and Trumbore 1997
        const double u = off.dot(across) / determinant, v = way.dot(turned) / determinant,
                     t = ac.dot(turned) / determinant;
        const double within = std::min({u, v, 1 - u - v});
        if (within < -tolerance || t < 0 || t > 1)
          continue;
        if (within < tolerance)
          return std::nullopt;
        crossed.push_back(2 * face + half);
      }
  } while (walk.next(1) && is_within(walk.cell(), n_boxes_));
  std::ranges::sort(crossed);
  return static_cast<int>(std::ranges::unique(crossed).begin() - crossed.begin());
}

bool BodySurface::is_inside(const Eigen::Vector3d& point) const {
  if (!((point.array() >= low_.array()).all() && (point.array() <= high_.array()).all()))
    return false;
  // Directions oblique to the axes, each towards a different side.
  static const std::array<Eigen::Vector3d, 4> ways{
      Eigen::Vector3d(0.0871557, 0.0523360, 0.9948), Eigen::Vector3d(-0.0610485, 0.9961, -0.0640),
      Eigen::Vector3d(-0.9957, 0.0436194, 0.0816), Eigen::Vector3d(0.5130, -0.6130, -0.6008)};
  const double length = 2 * (high_ - low_).norm();
  for (const Eigen::Vector3d& way : ways)
    if (const auto n = n_crossings(point, point + length * way))
      return *n % 2 == 1;
  return is_inside_of_every_triangle(point);
}

bool BodySurface::is_inside_of_every_triangle(const Eigen::Vector3d& point) const {
  if ((point.array() < low_.array()).any() || (point.array() > high_.array()).any())
    return false;
  // Solid angle of the whole boundary over 4 pi: 1 inside, 0 outside; edges and corners need no special case.
  double sum = 0;
  for (std::int32_t face = 0; face < static_cast<std::int32_t>(faces_.size()); ++face)
    for (const int half : {0, 1}) {
      const auto corners = triangle(face, half);
      const Eigen::Vector3d a = *corners[0] - point, b = *corners[1] - point, c = *corners[2] - point;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      // van Oosterom and Strackee 1983, equation 8
      sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
  return sum > 2 * 3.14159265358979323846;
}

std::int64_t BodySurface::bytes() const {
  const auto bytes_of = [](const auto& list) {
    return static_cast<std::int64_t>(list.capacity() * sizeof(list[0]));
  };
  return bytes_of(faces_) + bytes_of(nodes_) + bytes_of(positions_) + bytes_of(begins_) + bytes_of(sorted_);
}

} // namespace maille::deform
