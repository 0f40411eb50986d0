#include "elastic/corotated/corotated_elasticity.hpp"

#include "maille/scene/block_frames.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace maille::deform {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

/// R - I, with all its digits where the turn is small.
Matrix3d turn_beyond_identity(const Quaterniond& q) {
  const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
  Matrix3d T;
  T << -(y * y + z * z), x * y - w * z, x * z + w * y, //
      x * y + w * z, -(x * x + z * z), y * z - w * x,  //
      x * z - w * y, y * z + w * x, -(x * x + y * y);
  return 2 * T;
}

/// (tr(U) - U)^-1 m; of a plane's turn only that about its normal counts.
template<int dimension>
Vector3d turn_by_moment(const Matrix3d& U, const Vector3d& m) {
  if constexpr (dimension == 2)
    return {0, 0, m[2] / std::max(U(0, 0) + U(1, 1), 1e-9)};
  const Matrix3d H = U.trace() * Matrix3d::Identity() - U;
  const double size = std::abs(H.trace());
  // Where it is singular the frame is about to jump, and has no derivative.
  if (!(std::abs(H.determinant()) > 1e-12 * size * size * size))
    return Vector3d::Zero();
  return H.inverse() * m;
}

} // namespace

/// The displacements of a cell's corners, and what pulls at them: one column each, rows beyond the dimension
/// are zero.
template<int dimension>
struct CorotatedElasticity::Cell {
  static constexpr int corners = corners_of_cell<dimension>;
  using Corners = Eigen::Matrix<double, 3, corners>;

  Corners u, force;
  Corners place;    ///< of corners at rest, from the middle [m]
  Corners gradient; ///< g_i [1/m]
  bool is_inside_out = false;
  double active_energy = 0; ///< [J]

  /// force -= (Z moment) x g_i, in the frame R, where F = I + du/dx.
  void add_moment(const Matrix3d& R, const Matrix3d& F, const Vector3d& moment) {
    const Matrix3d A = R.transpose() * F;
    const Vector3d turn = turn_by_moment<dimension>(0.5 * (A + A.transpose()), moment);
    for (int i = 0; i < corners; ++i)
      force.col(i) -= turn.cross(Vector3d(gradient.col(i)));
  }
  explicit Cell(const Vec3& spacing) {
    place.setZero();
    gradient.setZero();
    for (int corner = 0; corner < corners; ++corner)
      for (int a = 0; a < dimension; ++a) {
        const double side = corner & 1 << a ? 1 : -1, h = spacing[a];
        place(a, corner) = 0.5 * side * h;
        gradient(a, corner) = side / (corners / 2 * h);
      }
  }
  void gather(const Displacement& of_all, std::size_t node, const std::array<std::int64_t, 8>& offset) {
    u.setZero();
    for (int b = 0; b < dimension; ++b)
      for (int corner = 0; corner < corners; ++corner)
        u(b, corner) = of_all(b, node + static_cast<std::size_t>(offset[corner]));
  }
  void scatter(Displacement& of_all, std::size_t node, const std::array<std::int64_t, 8>& offset) const {
    for (int b = 0; b < dimension; ++b)
      for (int corner = 0; corner < corners; ++corner)
        of_all(b, node + static_cast<std::size_t>(offset[corner])) += force(b, corner);
  }
};

CorotatedElasticity::CorotatedElasticity(const Scene& scene, const LatticeElasticity& linear)
    : scene_(scene), grid_(scene.specimen.grid), linear_(linear),
      frame_(static_cast<std::size_t>(grid_.n_cells()), Quaterniond::Identity()) {
  const auto layers = static_cast<std::size_t>(grid_.cells()[grid_.dimension() - 1]);
  energy_.resize(layers);
  active_energy_.resize(layers);
  inverted_.resize(layers);
  for (std::size_t corner = 0; corner < offset_.size(); ++corner)
    for (int a = 0; a < grid_.dimension(); ++a)
      if (corner & std::size_t{1} << a)
        offset_[corner] += grid_.stride(a);
}

template<class Work>
void CorotatedElasticity::for_each_layer(ThreadTeam& team, Work&& work) const {
  const int d = grid_.dimension(), layers = grid_.cells()[d - 1];
  run_slabs(team, layers, [&](int layer) {
    if (d == 2)
      work.template operator()<2>(layer);
    else
      work.template operator()<3>(layer);
  });
}

template<class Visit>
void CorotatedElasticity::for_each_cell(int layer, Visit&& visit) const {
  const Index3& cells = grid_.cells();
  const std::int64_t in_layer = grid_.n_cells() / cells[grid_.dimension() - 1], first = layer * in_layer;
  for (std::int64_t row = first; row < first + in_layer; row += cells[0]) {
    const auto node = static_cast<std::size_t>(grid_.corner(grid_.cell_at(row), 0));
    for (std::int64_t x = 0; x < cells[0]; ++x)
      if (scene_.specimen.is_matter(row + x))
        visit(row + x, node + static_cast<std::size_t>(x));
  }
}

template<int dimension, CorotatedElasticity::Frames frames>
double CorotatedElasticity::evaluate_cell(std::int64_t cell, Cell<dimension>& at) {
  using Corners = typename Cell<dimension>::Corners;
  at.u.colwise() -= Vector3d(at.u.col(0)); // a body carried far away keeps its digits
  Quaterniond& frame = frame_[cell];
  const Matrix3d H = at.u * at.gradient.transpose(), F = Matrix3d::Identity() + H;
  if constexpr (frames == Frames::turn)
    frame = nearest_rotation(dimension, F, frame);
  const Matrix3d T = turn_beyond_identity(frame), R = Matrix3d::Identity() + T;
  const Corners w = R.transpose() * at.u + T.transpose() * at.place;
  Corners f = linear_.cell_forces<dimension>(cell, w);
  const double elastic = 0.5 * w.cwiseProduct(f).sum();
  if (!active_stress_.empty()) {
    const Corners pull = active_stress<dimension>(cell) * at.gradient;
    at.active_energy = w.cwiseProduct(pull).sum();
    f += pull;
  }
  at.force = f;
  if constexpr (frames == Frames::turn) {
    Vector3d moment = Vector3d::Zero();
    for (int i = 0; i < Cell<dimension>::corners; ++i)
      moment += Vector3d(w.col(i)).cross(Vector3d(f.col(i)));
    at.add_moment(R, F, moment);
    at.is_inside_out = !(F.determinant() > 0);
  }
  at.force = R * at.force;
  return elastic;
}

/// Times the cell's volume [N m].
template<int dimension>
Matrix3d CorotatedElasticity::active_stress(std::int64_t cell) const {
  Matrix3d sigma = Matrix3d::Zero();
  const double strength = active_stress_[cell];
  if (strength == 0)
    return sigma;
  const Eigen::VectorXd s = scene_.reduced_active_stress(cell, strength);
  if constexpr (dimension == 2)
    sigma << s(0), s(2), 0, s(2), s(1), 0, 0, 0, 0;
  else
    sigma << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
  double volume = scene_.specimen.tissue_of(cell);
  for (std::size_t a = 0; a < dimension; ++a)
    volume *= grid_.spacing()[a];
  return volume * sigma;
}

double CorotatedElasticity::active_energy() const {
  return std::accumulate(active_energy_.begin(), active_energy_.end(), 0.0);
}

template<CorotatedElasticity::Frames frames>
double CorotatedElasticity::evaluate_all(const Displacement& u, Displacement& forces, ThreadTeam& team) {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    Cell<dimension> at(grid_.spacing());
    double energy = 0, active = 0;
    std::int64_t inverted = 0;
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(u, node, offset_);
      energy += evaluate_cell<dimension, frames>(cell, at);
      active += at.active_energy;
      at.scatter(forces, node, offset_);
      inverted += at.is_inside_out ? 1 : 0;
    });
    energy_[layer] = energy;
    active_energy_[layer] = active;
    inverted_[layer] = inverted;
  });
  return std::accumulate(energy_.begin(), energy_.end(), 0.0);
}

double CorotatedElasticity::evaluate(const Displacement& u, Displacement& forces, ThreadTeam& team) {
  return evaluate_all<Frames::turn>(u, forces, team);
}

double CorotatedElasticity::evaluate_in_fixed_frames(const Displacement& u, Displacement& forces,
                                                     ThreadTeam& team) {
  return evaluate_all<Frames::stay>(u, forces, team);
}

void CorotatedElasticity::apply_in_fixed_frames(const Displacement& p, Displacement& forces,
                                                ThreadTeam& team) const {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    Cell<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(p, node, offset_);
      const Matrix3d R = frame_[cell].toRotationMatrix();
      at.force = R * linear_.cell_forces<dimension>(cell, R.transpose() * at.u);
      at.scatter(forces, node, offset_);
    });
  });
  for (const NodalSpring& spring : linear_.springs()) {
    const Vec3 pull = pull_of(spring, p);
    for (int b = 0; b < grid_.dimension(); ++b)
      forces(b, spring.node) -= pull[b];
  }
}

void CorotatedElasticity::add_moments(const Displacement& u, const List<Vector3d>& moments,
                                      Displacement& forces, ThreadTeam& team) const {
  for_each_layer(team, [&]<int dimension>(int layer) {
    Cell<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      const Vector3d& moment = moments[cell];
      if (moment.isZero(0))
        return;
      at.gather(u, node, offset_);
      at.u.colwise() -= Vector3d(at.u.col(0));
      const Matrix3d F = Matrix3d::Identity() + at.u * at.gradient.transpose(),
                     R = frame_[cell].toRotationMatrix();
      at.force.setZero();
      at.add_moment(R, F, -(R.transpose() * moment));
      at.force = R * at.force;
      at.scatter(forces, node, offset_);
    });
  });
}

void CorotatedElasticity::warp_frames(const Displacement& d) {
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell) {
    if (!scene_.specimen.is_matter(cell))
      continue;
    Quaterniond& frame = frame_[cell];
    const Matrix3d G =
        displacement_gradient(grid_, d, grid_.cell_at(cell)) * frame.toRotationMatrix().transpose();
    const Vector3d turn = 0.5 * Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
    const double angle = turn.norm();
    if (angle > 0)
      frame = (Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * frame).normalized();
  }
}

std::int64_t CorotatedElasticity::n_inverted() const {
  return std::accumulate(inverted_.begin(), inverted_.end(), std::int64_t{0});
}

} // namespace maille::deform
