#include "elastic/finite/finite_elasticity.hpp"

#include "elastic/finite/cell_tangent.hpp"
#include "elastic/model/lattice_kernel.hpp"

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

/// Eigenvalues of a stiffness below this share of its largest entry are float32 rounding [1].
const double least_eigenvalue = std::numeric_limits<float>::epsilon();

/// R - I, without cancellation at small rotations.
Matrix3d turn_beyond_identity(const Quaterniond& q) {
  const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
  Matrix3d T;
  T << -(y * y + z * z), x * y - w * z, x * z + w * y, //
      x * y + w * z, -(x * x + z * z), y * z - w * x,  //
      x * z - w * y, y * z + w * x, -(x * x + y * y);
  return 2 * T;
}

/// (tr(U) - U)^-1 m; in the plane only the rotation about its normal counts.
template<int dimension>
Vector3d turn_by_moment(const Matrix3d& U, const Vector3d& m) {
  if constexpr (dimension == 2)
    return {0, 0, m[2] / std::max(U(0, 0) + U(1, 1), 1e-9)};
  const Matrix3d H = U.trace() * Matrix3d::Identity() - U;
  const double size = std::abs(H.trace());
  // At a singularity the frame is discontinuous and has no derivative.
  if (!(std::abs(H.determinant()) > 1e-12 * size * size * size))
    return Vector3d::Zero();
  return H.inverse() * m;
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
  n_in_row_ = grid_.dimension() == 1 ? 1 : grid_.cells()[0]; // in 1D layers are cells
  if (grid_.dimension() == 1)
    find_matter<1>();
  else if (grid_.dimension() == 2)
    find_matter<2>();
  else
    find_matter<3>();
}

/// Entries of K beyond the mean gradient, from the forces at the corners in each mode.
template<int dimension>
void FiniteElasticity::find_matter() {
  using OfCell = CellModes<dimension>;
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  constexpr std::array<int, 3> rows_in_plane{0, 1, 5};
  const auto sign = [](int corner, int k) {
    return std::popcount(static_cast<unsigned>(OfCell::beyond_modes[k] & ~corner)) % 2 != 0 ? -1 : 1;
  };
  matter_.resize(linear_.kinds().size());
  std::vector<Matrix12> beyond(matter_.size(), Matrix12::Zero());
  std::vector<bool> is_known(matter_.size(), false);
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell) {
    if (!scene_.specimen.is_matter(cell) || is_known[linear_.kind_number(cell)])
      continue;
    const std::size_t kind = linear_.kind_number(cell);
    is_known[kind] = true;
    Matter& matter = matter_[kind];
    matter.stiffness = scene_.object_stiffness(cell);
    const Material& material = scene_.materials[scene_.specimen.material(cell)];
    const auto* const neo_hookean = material.law ? std::get_if<NeoHookean>(&*material.law) : nullptr;
    matter.is_corotated = !material.law;
    matter.is_in_vectors = dimension == 3 && (neo_hookean != nullptr ||
                                              (matter.is_corotated && material.elasticity.is_isotropic()));
    matter.mu = neo_hookean != nullptr ? neo_hookean->mu : matter.stiffness(3, 3);
    matter.lambda = neo_hookean != nullptr ? neo_hookean->lambda : matter.stiffness(0, 1);
    const Eigen::MatrixXd reduced = scene_.cell_stiffness(cell);
    for (Eigen::Index p = 0; p < reduced.rows(); ++p)
      for (Eigen::Index q = 0; q < reduced.cols(); ++q)
        matter.in_scene(dimension == 3 ? p : rows_in_plane[p], dimension == 3 ? q : rows_in_plane[q]) =
            reduced(p, q);
    for (int k = 0; k < (dimension > 1 ? OfCell::n_beyond : 0); ++k)
      for (int b = 0; b < dimension; ++b) {
        typename OfCell::Modes u = OfCell::Modes::Zero();
        for (int corner = 0; corner < OfCell::n; ++corner)
          u(b, corner) = sign(corner, k);
        const typename OfCell::Modes f = linear_.cell_forces<dimension>(cell, u) / linear_.weight(cell);
        for (int l = 0; l < OfCell::n_beyond; ++l)
          for (int c = 0; c < dimension; ++c)
            for (int corner = 0; corner < OfCell::n; ++corner)
              beyond[kind](3 * l + c, 3 * k + b) += sign(corner, l) * f(c, corner);
      }
  }
  for (std::uint8_t i = 0; i < 12; ++i)
    for (std::uint8_t j = i; j < 12; ++j)
      if (std::ranges::any_of(beyond, [&](const Matrix12& K) {
            return std::abs(K(i, j)) > least_eigenvalue * K.diagonal().maxCoeff();
          }))
        pairs_.push_back({i, j});
  for (std::size_t kind = 0; kind < matter_.size(); ++kind)
    for (const auto& [i, j] : pairs_) // in float32: energy and tangent have the same numbers
      matter_[kind].beyond.push_back(static_cast<float>(0.5 * (beyond[kind](i, j) + beyond[kind](j, i))));
  n_numbers_ = TangentNumbers<dimension>::K + static_cast<std::int64_t>(pairs_.size());
}

template<class Beyond>
Beyond FiniteElasticity::pull(const Matter& matter, const Beyond& w) const {
  Beyond f = Beyond::Zero();
  for (std::size_t at = 0; at < pairs_.size(); ++at) {
    const auto& [i, j] = pairs_[at];
    f.data()[i] += matter.beyond[at] * w.data()[j];
    if (i != j)
      f.data()[j] += matter.beyond[at] * w.data()[i];
  }
  return f;
}

void FiniteElasticity::fill(TangentRun& run, int n, std::int64_t node, const Displacement& u,
                            Displacement* forces) const {
  run.dimension = grid_.dimension();
  run.cells = n;
  run.row = n_in_row_;
  run.pairs = pairs_.data();
  run.n_pairs = static_cast<int>(pairs_.size());
  std::ranges::copy(offset_, run.corner);
  for (int b = 0; b < run.dimension; ++b) {
    run.per_length[b] = 1 / grid_.spacing()[b];
    run.u[b] = u.component(b).data() + node;
    run.forces[b] = forces != nullptr ? forces->component(b).data() + node : nullptr;
  }
}

template<class VisitRun, class Visit>
void FiniteElasticity::for_each_law(int layer, const Displacement& u, VisitRun&& visit_run,
                                    Visit&& visit) const {
  std::array<double, most_cells> weight, determinant;
  for_each_run(layer, [&](std::int64_t first, std::int64_t n, std::int64_t node) {
    for (std::int64_t x = 0; x < n;) {
      const Matter& matter = matter_of(first + x);
      if (!matter.is_in_vectors || !active_stress_.empty()) {
        visit(first + x, node + x);
        ++x;
        continue;
      }
      const std::int64_t begin = x;
      for (; x < n && x - begin < most_cells && &matter_of(first + x) == &matter; ++x)
        weight[x - begin] = linear_.weight(first + x);
      LawRun run;
      fill(run, static_cast<int>(x - begin), node + begin, u, nullptr);
      run.is_corotated = matter.is_corotated;
      run.mu = matter.mu;
      run.lambda = matter.lambda;
      run.kappa = bulk(first + begin);
      run.volume = volume_;
      run.weight = weight.data();
      run.beyond = matter.beyond.data();
      run.determinant = determinant.data();
      visit_run(run, first + begin, node + begin);
    }
  });
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
    const auto of_run = [&](LawRun& run, std::int64_t first, std::int64_t node) {
      run.energy = energies_.data() + first;
      for (int b = 0; b < dimension; ++b)
        run.forces[b] = forces.component(b).data() + node;
      evaluate_law(run);
      for (int i = 0; i < run.cells; ++i)
        run.determinant[i] > 0 ? void(sum.energy += run.energy[i]) : void(++sum.inverted);
    };
    for_each_law(layer, u, of_run, [&](std::int64_t cell, std::int64_t node) {
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
                                                  f = weight * pull(matter_of(cell), w);
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

void FiniteElasticity::make_tangent() {
  numbers_.resize(n_numbers_ * grid_.n_cells());
  volume_pressure_.resize(frame_.size());
  pressure_.resize(frame_.size());
}

void FiniteElasticity::linearise(const Displacement& u, Convexity convexity, ThreadTeam& team) {
  make_tangent();
  turn_frames(u, team);
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    const auto of_cell = [&](std::int64_t cell, std::int64_t node) {
      at.gather(u, node, offset_);
      linearise_cell(cell, at, convexity);
    };
    const auto of_run = [&](LawRun& run, std::int64_t first, std::int64_t node) {
      run.found = numbers_.data() + numbers_of(first);
      run.pressure = pressure_.data() + first;
      run.volume_pressure = volume_pressure_.data() + first;
      run.has_pressures = has_pressures_;
      run.is_exact = convexity == Convexity::exact;
      run.least_part = least_eigenvalue;
      linearise_law(run);
      for (int i = 0; i < run.cells && !run.is_exact; ++i)
        if (!(run.determinant[i] > 0))
          of_cell(first + i, node + i);
    };
    for_each_law(layer, u, of_run, of_cell);
  });
}

template<int dimension>
void FiniteElasticity::linearise_cell(std::int64_t cell, const CellModes<dimension>& at,
                                      Convexity convexity) {
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
    make_positive(-least_eigenvalue, A); // rotations have energy 0
  volume_pressure_[cell] = pressure;
  using Beyond = typename CellModes<dimension>::Beyond;
  store_tangent<dimension>(cell, F, A, convexity == Convexity::exact ? at.beyond() : Beyond(Beyond::Zero()));
}

void FiniteElasticity::linearise_in_frames(Displacement& at_rest, ThreadTeam& team) {
  make_tangent();
  std::ranges::fill(at_rest.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    using Beyond = typename CellModes<dimension>::Beyond;
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::int64_t node) {
      const Matrix3d T = turn_beyond_identity(frame_[cell]), R = Matrix3d::Identity() + T;
      const LawResponse linear{0, Vector6::Zero(), matter_of(cell).in_scene};
      store_tangent<dimension>(cell, R, tangent_of_gradient(R, linear), Beyond::Zero());
      volume_pressure_[cell] = bulk(cell) * T.trace();
      at.set_force(volume(cell) * R * as_stress(linear.tangent * strain_of(T)), Beyond::Zero());
      at.scatter(at_rest, node, offset_);
    });
  });
}

void FiniteElasticity::step_pressures(const Displacement& direction, double length, ThreadTeam& team) {
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::int64_t node) {
      at.gather(direction, node, offset_);
      Matrix3d F = Matrix3d::Identity();
      for (int i = 0; i < dimension * dimension; ++i)
        F(i % dimension, i / dimension) =
            numbers_[numbers_of(cell) + (TangentNumbers<dimension>::F + i) * n_in_row_];
      const double grown = F.inverse().cwiseProduct(at.mean_gradient().transpose()).sum(); // of ln J
      pressure_[cell] += length * (volume_pressure_[cell] + bulk(cell) * grown - pressure_[cell]);
      volume_pressure_[cell] += length * bulk(cell) * grown;
    });
  });
  has_pressures_ = true;
}

template<int dimension>
void FiniteElasticity::store_tangent(std::int64_t cell, const Matrix3d& F, const Matrix9d& A,
                                     const typename CellModes<dimension>::Beyond& h) {
  float* to = numbers_.data() + numbers_of(cell);
  const auto put = [&](double number) {
    *to = static_cast<float>(number);
    to += n_in_row_;
  };
  constexpr int n = dimension * dimension;
  const auto entry = [](int i) { return 3 * (i / dimension) + i % dimension; };
  const double V = volume(cell), weight = linear_.weight(cell);
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j)
      put(V * A(entry(i), entry(j)));
  for (int i = 0; i < n; ++i)
    put(F(i % dimension, i / dimension));
  const typename CellModes<dimension>::Beyond f = weight * pull(matter_of(cell), (F.transpose() * h).eval());
  for (const auto* field : {&h, &f})
    for (int k = 0; k < TangentNumbers<dimension>::n_beyond; ++k)
      for (int b = 0; b < dimension; ++b)
        put((*field)(b, k));
  for (const double K : matter_of(cell).beyond)
    put(weight * K);
}

void FiniteElasticity::apply_tangent(const Displacement& p, Displacement& forces, ThreadTeam& team) const {
  std::ranges::fill(forces.values(), 0.0);
  for_each_layer(team, [&]<int dimension>(int layer) {
    for_each_run(layer, [&](std::int64_t first, std::int64_t n, std::int64_t node) {
      TangentRun run;
      fill(run, static_cast<int>(n), node, p, &forces);
      run.numbers = numbers_.data() + numbers_of(first);
      add_tangent_forces(run);
    });
  });
  add_springs(p, forces);
}

Matrix6 FiniteElasticity::stiffness_in_frame(std::int64_t cell) const {
  const Matrix3d R = frame_[cell].toRotationMatrix();
  const int d = grid_.dimension();
  Matrix9d A = Matrix9d::Zero();
  const float* from = numbers_.data() + numbers_of(cell);
  for (int i = 0; i < d * d; ++i)
    for (int j = i; j < d * d; ++j, from += n_in_row_) {
      const int p = 3 * (i / d) + i % d, q = 3 * (j / d) + j % d;
      A(p, q) = A(q, p) = *from / volume(cell);
    }
  Matrix6 C;
  for (int q = 0; q < 6; ++q) {
    const Matrix3d change = R * as_strain(Vector6::Unit(q)),
                   stress = R.transpose() * (A * change.reshaped()).reshaped(3, 3);
    C.col(q) = stress_of(0.5 * (stress + stress.transpose()));
  }
  C = (0.5 * (C + C.transpose())).eval();
  make_positive(least_eigenvalue, C);
  return C;
}

void FiniteElasticity::turn_frames(const Displacement& u, ThreadTeam& team) {
  for_each_layer(team, [&]<int dimension>(int layer) {
    CellModes<dimension> at(grid_.spacing());
    for_each_cell(layer, [&](std::int64_t cell, std::int64_t node) {
      at.gather(u, node, offset_);
      const Matrix3d F = Matrix3d::Identity() + at.mean_gradient();
      if constexpr (dimension > 1)
        frame_[cell] = nearest_rotation(dimension, F, frame_[cell]);
    });
  });
}

double FiniteElasticity::warp_frames(const Displacement& d) {
  double squares = 0;
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell) {
    if (!scene_.specimen.is_matter(cell))
      continue;
    Quaterniond& frame = frame_[cell];
    const Matrix3d G =
        displacement_gradient(grid_, d, grid_.cell_at(cell)) * frame.toRotationMatrix().transpose();
    const Vector3d turn = 0.5 * Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
    const double angle = turn.norm();
    squares += angle * angle;
    if (angle > 0)
      frame = (Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * frame).normalized();
  }
  return std::sqrt(squares / static_cast<double>(scene_.specimen.n_matter_cells()));
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
    for_each_cell(layer, [&](std::int64_t cell, std::int64_t node) {
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
