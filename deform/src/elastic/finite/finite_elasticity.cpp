#include "elastic/finite/finite_elasticity.hpp"

#include "maille/scene/block_frames.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace maille::deform {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

/// Smaller eigenvalues of a stiffness, over the largest entry, are rounding in float32 [1].
const double least_eigenvalue = std::numeric_limits<float>::epsilon();

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

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

Vector9 as_vector(const Matrix3d& A) {
  return A.reshaped();
}
Matrix3d as_matrix(const Vector9& v) {
  return v.reshaped(3, 3);
}

/// Adds a pressure to stress and tangent: C^-1 and its derivative by E.
void shift_pressure(double shift, const Matrix3d& F, LawResponse& response) {
  if (shift == 0)
    return;
  const Matrix3d inverse = (F.transpose() * F).inverse();
  response.stress += shift * stress_of(inverse);
  for (int q = 0; q < 6; ++q)
    response.tangent.col(q) -= 2 * shift * stress_of(inverse * as_strain(Vector6::Unit(q)) * inverse);
}

/// dP/dF of P = F S(E): dP = dF S + F dS.
Matrix9d tangent_of_gradient(const Matrix3d& F, const LawResponse& response) {
  Eigen::Matrix<double, 6, 9> strain;
  Matrix9d A;
  const Matrix3d S = as_stress(response.stress);
  for (int k = 0; k < 9; ++k) {
    const Matrix3d dF = as_matrix(Vector9::Unit(k));
    strain.col(k) = strain_of(F.transpose() * dF);
    A.col(k) = as_vector(dF * S);
  }
  return A + strain.transpose() * response.tangent * strain;
}

/// Replaces eigenvalues by their size where one is below `least_part` of the largest entry, and smaller ones
/// by that part.
template<int n>
void make_positive(double least_part, Eigen::Matrix<double, n, n>& A) {
  using Matrix = Eigen::Matrix<double, n, n>;
  const double least = least_part * A.diagonal().cwiseAbs().maxCoeff();
  if ((A - least * Matrix::Identity()).llt().info() == Eigen::Success)
    return;
  const Eigen::SelfAdjointEigenSolver<Matrix> principal(A);
  A = principal.eigenvectors() * principal.eigenvalues().cwiseAbs().cwiseMax(least).asDiagonal() *
      principal.eigenvectors().transpose();
}

} // namespace

FiniteElasticity::FiniteElasticity(const Scene& scene, const LatticeElasticity& linear)
    : scene_(scene), grid_(scene.specimen.grid), linear_(linear),
      frame_(static_cast<std::size_t>(grid_.n_cells()), Quaterniond::Identity()),
      active_stress_(scene.active_stress), energies_(frame_.size(), 0) {
  for (int a = 0; a < grid_.dimension(); ++a)
    volume_ *= grid_.spacing()[a];
  has_free_strains_ =
      grid_.dimension() == 1 || (grid_.dimension() == 2 && scene.plane == PlaneAssumption::stress);
  of_layer_.resize(grid_.cells()[grid_.dimension() - 1]);
  for (std::size_t corner = 0; corner < offset_.size(); ++corner)
    for (int a = 0; a < grid_.dimension(); ++a)
      if (corner & std::size_t{1} << a)
        offset_[corner] += grid_.stride(a);
  matter_.resize(linear.kinds().size());
  std::vector<bool> is_known(matter_.size(), false);
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell) && !is_known[linear.kind_number(cell)]) {
      const std::size_t kind = linear.kind_number(cell);
      is_known[kind] = true;
      if (grid_.dimension() == 1)
        find_matter<1>(cell, matter_[kind]);
      else if (grid_.dimension() == 2)
        find_matter<2>(cell, matter_[kind]);
      else
        find_matter<3>(cell, matter_[kind]);
    }
}

/// The part of K beyond the mean gradient by what pulls at the corners in every mode.
template<int dimension>
void FiniteElasticity::find_matter(std::int64_t cell, Matter& matter) const {
  using OfCell = CellModes<dimension>;
  constexpr std::array<int, 3> rows_in_plane{0, 1, 5};
  matter.stiffness = scene_.object_stiffness(cell);
  const Eigen::MatrixXd reduced = scene_.cell_stiffness(cell);
  for (Eigen::Index p = 0; p < reduced.rows(); ++p)
    for (Eigen::Index q = 0; q < reduced.cols(); ++q)
      matter.in_scene(dimension == 3 ? p : rows_in_plane[p], dimension == 3 ? q : rows_in_plane[q]) =
          reduced(p, q);
  for (int k = 0; k < OfCell::n_beyond; ++k)
    for (int b = 0; b < dimension; ++b) {
      typename OfCell::Modes u = OfCell::Modes::Zero();
      const auto sign = [&](int corner, int mode) {
        return std::popcount(static_cast<unsigned>(OfCell::beyond_modes[mode] & ~corner)) % 2 != 0 ? -1 : 1;
      };
      for (int corner = 0; corner < OfCell::n; ++corner)
        u(b, corner) = sign(corner, k);
      const typename OfCell::Modes f = linear_.cell_forces<dimension>(cell, u) / linear_.weight(cell);
      for (int l = 0; l < OfCell::n_beyond; ++l)
        for (int c = 0; c < dimension; ++c)
          for (int corner = 0; corner < OfCell::n; ++corner)
            matter.beyond(3 * l + c, 3 * k + b) += static_cast<float>(sign(corner, l) * f(c, corner));
    }
  matter.beyond = (0.5F * (matter.beyond + matter.beyond.transpose())).eval();
}

template<class Work>
void FiniteElasticity::for_each_layer(ThreadTeam& team, Work&& work) const {
  const int d = grid_.dimension(), layers = grid_.cells()[d - 1];
  run_slabs(team, layers, [&](int layer) {
    if (d == 1)
      work.template operator()<1>(layer);
    else if (d == 2)
      work.template operator()<2>(layer);
    else
      work.template operator()<3>(layer);
  });
}

template<class Visit>
void FiniteElasticity::for_each_cell(int layer, Visit&& visit) const {
  const Index3& cells = grid_.cells();
  const std::int64_t in_layer = grid_.n_cells() / cells[grid_.dimension() - 1], first = layer * in_layer,
                     in_row = std::min(in_layer, std::int64_t{cells[0]}); // in 1D layers are cells
  for (std::int64_t row = first; row < first + in_layer; row += in_row) {
    const auto node = static_cast<std::size_t>(grid_.corner(grid_.cell_at(row), 0));
    for (std::int64_t x = 0; x < in_row; ++x)
      if (scene_.specimen.is_matter(row + x))
        visit(row + x, node + static_cast<std::size_t>(x));
  }
}

LawResponse FiniteElasticity::respond(std::int64_t cell, Matrix3d& E, double& active) const {
  const Specimen& body = scene_.specimen;
  const Vec3 fibre = body.fibre_of(cell);
  const double tension =
      active_stress_.empty() ? 0 : active_stress_[cell] / body.stiffness_ratio_of(cell); // per weight
  return maille::respond({scene_.materials[body.material(cell)], matter_of(cell).stiffness,
                          Vector3d(fibre[0], fibre[1], fibre[2]), tension},
                         scene_.dimension(), scene_.plane, E, active);
}

double FiniteElasticity::evaluate(const Displacement& u, Displacement& forces, ThreadTeam& team) {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    OfLayer sum;
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(u, node, offset_);
      const Matrix3d H = at.mean_gradient(), F = Matrix3d::Identity() + H;
      if (!(F.determinant() > 0)) {
        ++sum.inverted;
        return;
      }
      Matrix3d E = 0.5 * (H + H.transpose() + H.transpose() * H);
      double active = 0;
      const LawResponse response = respond(cell, E, active);
      const double V = volume(cell), weight = linear_.weight(cell);
      const typename CellModes<dimension>::Beyond h = at.beyond(), w = F.transpose() * h,
                                                  f = weight * at.pull(matter_of(cell).beyond, w);
      energies_[cell] = V * response.energy + 0.5 * w.cwiseProduct(f).sum();
      sum.energy += energies_[cell];
      sum.active += V * active;
      at.set_force(V * F * as_stress(response.stress) + h * f.transpose(), F * f);
      at.scatter(forces, node, offset_);
    });
    of_layer_[layer] = sum;
  });
  OfLayer all;
  for (const OfLayer& layer : of_layer_)
    all.energy += layer.energy + layer.active;
  return n_inverted() > 0 || std::isnan(all.energy) ? std::numeric_limits<double>::infinity() : all.energy;
}

double FiniteElasticity::active_energy() const {
  return std::accumulate(of_layer_.begin(), of_layer_.end(), 0.0,
                         [](double sum, const OfLayer& layer) { return sum + layer.active; });
}

std::int64_t FiniteElasticity::n_inverted() const {
  return std::accumulate(of_layer_.begin(), of_layer_.end(), std::int64_t{0},
                         [](std::int64_t sum, const OfLayer& layer) { return sum + layer.inverted; });
}

void FiniteElasticity::linearise(const Displacement& u, Convexity convexity, ThreadTeam& team) {
  tangent_.resize(frame_.size());
  pressure_.resize(frame_.size());
  convexity_ = convexity;
  turn_frames(u, team);
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(u, node, offset_);
      const Matrix3d H = at.mean_gradient(), F = Matrix3d::Identity() + H;
      Matrix3d E = 0.5 * (H + H.transpose() + H.transpose() * H);
      double active = 0;
      LawResponse response = respond(cell, E, active);
      const double pressure = bulk(cell) * std::log(F.determinant());
      if (!has_pressures_ || has_free_strains_)
        pressure_[cell] = pressure;
      shift_pressure(pressure_[cell] - pressure, F, response);
      Matrix9d A = tangent_of_gradient(F, response);
      if (convexity == Convexity::positive)
        make_positive(-least_eigenvalue, A); // turns cost nothing
      tangent_[cell] = {F, A.cast<float>(), pressure};
    });
  });
}

void FiniteElasticity::step_pressures(const Displacement& direction, double length, ThreadTeam& team) {
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(direction, node, offset_);
      const Tangent& of = tangent_[cell];
      const double grown = of.F.inverse().cwiseProduct(at.mean_gradient().transpose()).sum(); // of ln J
      pressure_[cell] += length * (of.pressure + bulk(cell) * grown - pressure_[cell]);
    });
  });
  has_pressures_ = true;
}

void FiniteElasticity::apply_tangent(const Displacement& u, const Displacement& p, Displacement& forces,
                                     ThreadTeam& team) const {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    using Beyond = typename CellModes<dimension>::Beyond;
    CellModes<dimension> state(grid_.spacing()), at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(p, node, offset_);
      const auto& K = matter_of(cell).beyond;
      const double weight = linear_.weight(cell);
      const Matrix3d &F = tangent_[cell].F, dH = at.mean_gradient();
      const Beyond dh = at.beyond();
      Matrix3d dP =
          volume(cell) * as_matrix(tangent_[cell].of_gradient.cast<double>().lazyProduct(as_vector(dH)));
      if (convexity_ == Convexity::exact) {
        state.gather(u, node, offset_);
        const Beyond h = state.beyond(), f = weight * at.pull(K, F.transpose() * h),
                     df = weight * at.pull(K, F.transpose() * dh + dH.transpose() * h);
        dP += dh * f.transpose() + h * df.transpose();
        at.set_force(dP, dH * f + F * df);
      } else
        at.set_force(dP, weight * F * at.pull(K, F.transpose() * dh));
      at.scatter(forces, node, offset_);
    });
  });
  add_springs(p, forces);
}

Matrix6 FiniteElasticity::stiffness_in_frame(std::int64_t cell) const {
  const Matrix3d R = frame_[cell].toRotationMatrix();
  const Matrix9d A = tangent_[cell].of_gradient.cast<double>();
  Matrix6 C;
  for (int q = 0; q < 6; ++q) {
    const Matrix3d stress = R.transpose() * as_matrix(A * as_vector(R * as_strain(Vector6::Unit(q))));
    C.col(q) = stress_of(0.5 * (stress + stress.transpose()));
  }
  C = (0.5 * (C + C.transpose())).eval();
  make_positive(least_eigenvalue, C);
  return C;
}

void FiniteElasticity::turn_frames(const Displacement& u, ThreadTeam& team) {
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(u, node, offset_);
      const Matrix3d F = Matrix3d::Identity() + at.mean_gradient();
      if constexpr (dimension > 1)
        frame_[cell] = nearest_rotation(dimension, F, frame_[cell]);
    });
  });
}

void FiniteElasticity::warp_frames(const Displacement& d) {
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

/// Linear elasticity of R^T u plus a mean gradient that is given.
template<int dimension>
void FiniteElasticity::pull_in_frame(std::int64_t cell, const Matrix3d& R, const Matrix3d& gradient,
                                     CellModes<dimension>& at) const {
  const Matter& matter = matter_of(cell);
  const Vector6 stress = matter.in_scene * strain_of(R.transpose() * at.mean_gradient() + gradient);
  const typename CellModes<dimension>::Beyond w = R.transpose() * at.beyond();
  at.set_force(volume(cell) * R * as_stress(stress), linear_.weight(cell) * R * at.pull(matter.beyond, w));
}

void FiniteElasticity::pull_in_frames(const Displacement& u, bool from_rest, Displacement& forces,
                                      ThreadTeam& team) const {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      at.gather(u, node, offset_);
      const Matrix3d T = turn_beyond_identity(frame_[cell]);
      pull_in_frame(cell, Matrix3d::Identity() + T, from_rest ? Matrix3d(T.transpose()) : Matrix3d::Zero(),
                    at);
      at.scatter(forces, node, offset_);
    });
  });
  add_springs(u, forces);
}

void FiniteElasticity::add_springs(const Displacement& u, Displacement& forces) const {
  for (const NodalSpring& spring : linear_.springs()) {
    const Vec3 pull = pull_of(spring, u);
    for (int b = 0; b < grid_.dimension(); ++b)
      forces(b, spring.node) -= pull[b];
  }
}

/// force = -R ((Z moment) x g_i), Z = (tr(U) - U)^-1: how the rotation follows the corners.
void FiniteElasticity::add_moments(const Displacement& u, const List<Vector3d>& moments, Displacement& forces,
                                   ThreadTeam& team) const {
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::size_t node) {
      const Vector3d& moment = moments[cell];
      if (moment.isZero(0))
        return;
      at.gather(u, node, offset_);
      const Matrix3d R = frame_[cell].toRotationMatrix(),
                     A = R.transpose() * (Matrix3d::Identity() + at.mean_gradient());
      const Vector3d turn =
          turn_by_moment<dimension>(0.5 * (A + A.transpose()), Vector3d(R.transpose() * moment));
      Matrix3d cross;
      cross << 0, -turn[2], turn[1], turn[2], 0, -turn[0], -turn[1], turn[0], 0;
      at.set_force(R * cross, CellModes<dimension>::Beyond::Zero());
      at.scatter(forces, node, offset_);
    });
  });
}

} // namespace maille::deform
