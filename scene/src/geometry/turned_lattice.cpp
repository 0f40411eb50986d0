#include "geometry/turned_lattice.hpp"
#include "cell_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace maille::reader {

namespace {

Eigen::Vector3d vector(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Vec3 array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// The axis of a scene nearest to the fibre, the first among equals.
std::size_t nearest_axis(const Vec3& fibre) {
  std::size_t nearest = 0;
  for (std::size_t a = 1; a < 3; ++a)
    if (std::abs(fibre[a]) > std::abs(fibre[nearest]) + TurnedLattice::rounding)
      nearest = a;
  return nearest;
}

} // namespace

// The smallest rotation of the axis nearest to the fibre: the lattice then does not depend on the order of
// the image's axes.
TurnedLattice::TurnedLattice(const Scene& scene, const Vec3& fibre)
    : scene_(scene), spacing_(scene.specimen.grid.spacing()) {
  const std::size_t nearest = nearest_axis(fibre);
  Eigen::Matrix3d renamed = Eigen::Matrix3d::Identity();
  if (const auto a = static_cast<Eigen::Index>(nearest); a > 0) {
    renamed.col(0) = std::copysign(1.0, fibre[nearest]) * Eigen::Vector3d::Unit(a);
    renamed.col(a) = -std::copysign(1.0, fibre[nearest]) * Eigen::Vector3d::Unit(0);
  }
  std::swap(spacing_[0], spacing_[nearest]);
  axes_ = renamed * axes_from_fibre(renamed.transpose() * vector(fibre));
}

Specimen TurnedLattice::turned_body() const {
  const Specimen& old = scene_.specimen;
  Specimen body = old;
  body.grid = grid(body.origin);
  body.fibre = turned_fibre(old.fibre);
  for (auto& fibre : body.fibres) {
    const Vec3 f = turned_fibre({fibre[0], fibre[1], fibre[2]});
    fibre = {static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2])};
  }
  if (body.material_id.empty())
    body.material_id.assign(old.grid.n_cells(), 0);
  carry_cells(body, [&](std::int64_t cell) { return cell_at_middle_of(body, cell); });
  Eigen::Matrix3d direction;
  for (Eigen::Index r = 0; r < 3; ++r)
    direction.row(r) = vector(old.placement.direction[r]);
  direction = (direction * axes_).eval();
  for (Eigen::Index r = 0; r < 3; ++r)
    body.placement.direction[r] = array(direction.row(r));
  return body;
}

Vec3 TurnedLattice::to_turned(const Vec3& v) const {
  return array(axes_.transpose() * vector(v));
}

std::int64_t TurnedLattice::nearest_node(const Specimen& body, std::int64_t node) const {
  const Eigen::Vector3d x = axes_ * vector(body.position(body.grid.node_at(node)));
  const Grid& grid = scene_.specimen.grid;
  Index3 at{0, 0, 0};
  for (int a = 0; a < grid.dimension(); ++a) {
    const double place = (x[static_cast<Eigen::Index>(a)] - scene_.specimen.origin[a]) / grid.spacing()[a];
    // Of two equally near nodes, takes the one nearer to the box's faces: half a spacing inside belongs to
    // them.
    const double half = place < 0.5 * grid.cells()[a] ? 0.5 - rounding : 0.5 + rounding;
    at[a] = static_cast<int>(std::clamp(std::floor(place + half), 0.0, double(grid.cells()[a])));
  }
  return grid.node(at);
}

double TurnedLattice::share(unsigned mask, int j) const {
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    if (mask >> i & 1U)
      sum += axes_(i, j) * axes_(i, j);
  return sum;
}

Grid TurnedLattice::grid(Vec3& origin) const {
  const Grid& grid = scene_.specimen.grid;
  Eigen::Vector3d half = Eigen::Vector3d::Zero(), middle = vector(scene_.specimen.origin);
  for (int a = 0; a < grid.dimension(); ++a) {
    half[a] = 0.5 * grid.cells()[a] * grid.spacing()[a];
    middle[a] += half[a];
  }
  const Eigen::Vector3d reach = axes_.transpose().cwiseAbs() * half;
  middle = (axes_.transpose() * middle).eval();
  Index3 cells{1, 1, 1};
  origin = {0, 0, 0};
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const std::size_t a = axis;
    cells[a] = std::max(1, static_cast<int>(std::ceil(2 * reach[axis] / spacing_[a] - rounding)));
    origin[a] = middle[axis] - 0.5 * cells[a] * spacing_[a];
  }
  return Grid(grid.dimension(), cells, spacing_);
}

std::int64_t TurnedLattice::cell_at_middle_of(const Specimen& body, std::int64_t cell) const {
  Eigen::Vector3d middle = vector(body.position(body.grid.cell_at(cell)));
  const Grid& grid = scene_.specimen.grid;
  for (int a = 0; a < grid.dimension(); ++a)
    middle[a] += 0.5 * body.grid.spacing()[a];
  const Eigen::Vector3d x = axes_ * middle;
  Index3 at{0, 0, 0};
  for (int a = 0; a < grid.dimension(); ++a) {
    const double place = (x[static_cast<Eigen::Index>(a)] - scene_.specimen.origin[a]) / grid.spacing()[a];
    if (!(place >= rounding && place < grid.cells()[a] + rounding))
      return -1;
    at[a] = std::min(static_cast<int>(place), grid.cells()[a] - 1);
  }
  return grid.cell(at);
}

Vec3 TurnedLattice::turned_fibre(const Vec3& fibre) const {
  Vec3 f = to_turned(fibre);
  if (std::abs(f[1]) < rounding && std::abs(f[2]) < rounding)
    f = {std::copysign(1.0, f[0]), 0, 0}; // exact, because methods test for fibres along axes
  return f;
}

} // namespace maille::reader
