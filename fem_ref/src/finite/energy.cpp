#include "finite/energy.hpp"

#include <Eigen/LU>
#include <Sacado.hpp>

#include <algorithm>

namespace {

using Inner = Sacado::Fad::SFad<double, maille::fem_ref::n_point_inputs>;
using Dual = Sacado::Fad::SFad<Inner, maille::fem_ref::n_point_inputs>;

} // namespace

template<>
struct Eigen::NumTraits<Dual> : Eigen::GenericNumTraits<Dual> {
  using Real = Dual;
  using NonInteger = Dual;
  using Nested = Dual;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
};

namespace maille::fem_ref {

namespace {

using Dual3 = Eigen::Matrix<Dual, 3, 3>;

double value_of(const Dual& x) {
  return x.val().val();
}

Dual energy(const NeoHookean& law, const Dual3& F, const Eigen::Vector3d&) {
  const Dual log_J = log(Dual(F.determinant())), I1 = F.squaredNorm();
  return law.mu / 2 * (I1 - 3.) - law.mu * log_J + law.lambda / 2 * log_J * log_J;
}

/// The rotation of F = R U. Newton's iteration doubles the digits of values and derivatives alike.
/// Source  Higham 1986 (SIAM J. Sci. Stat. Comput. 7)
Dual3 rotation_of(const Dual3& F) {
  constexpr double half_of_the_digits = 1e-9;
  Dual3 R = F;
  for (double change = 1; change > half_of_the_digits;) {
    const Dual3 next = (R + Dual3(R.inverse().transpose())) * Dual(0.5);
    change = 0;
    for (int i = 0; i < 9; ++i)
      change = std::max(change, std::abs(value_of(next(i)) - value_of(R(i))));
    R = next;
  }
  return R;
}

Dual corotated_energy(const Matrix6& stiffness, const Dual3& F) {
  const Dual3 U = rotation_of(F).transpose() * F;
  const std::array<Dual, 6> e{U(0, 0) - 1., U(1, 1) - 1., U(2, 2) - 1.,
                              2. * U(1, 2), 2. * U(0, 2), 2. * U(0, 1)};
  Dual W = 0.;
  for (int p = 0; p < 6; ++p)
    for (int q = 0; q < 6; ++q)
      W += 0.5 * stiffness(p, q) * e[p] * e[q];
  return W;
}

} // namespace

Matter matter_of(const Scene& scene, std::int64_t cell) {
  const Specimen& body = scene.specimen;
  const Material& material = scene.materials[body.material(cell)];
  const Vec3 f = body.fibre_of(cell);
  Matter matter;
  matter.fibre = {f[0], f[1], f[2]};
  if (material.law) {
    matter.law = &*material.law;
    matter.weight = body.weight_of(cell);
  } else { // which has the ratio of stiffness in it
    matter.stiffness = scene.object_stiffness(cell);
    matter.weight = body.tissue_of(cell);
  }
  if (scene.contracts())
    matter.tension = body.tissue_of(cell) * scene.active_stress[cell];
  return matter;
}

PointResponse respond_at(const Matter& matter, const Eigen::Matrix3d& at, std::optional<double> theta) {
  const auto input = [](int i, double value) {
    return Dual(n_point_inputs, i, Inner(n_point_inputs, i, value));
  };
  Dual3 F;
  for (int i = 0; i < 9; ++i)
    F(i / 3, i % 3) = input(i, at(i / 3, i % 3));
  Dual3 strained = F;
  if (theta)
    strained *= Dual(cbrt(Dual(input(9, *theta) / F.determinant())));
  Dual W = matter.law
               ? std::visit([&](const auto& law) { return energy(law, strained, matter.fibre); }, *matter.law)
               : corotated_energy(matter.stiffness, strained);
  W *= matter.weight;
  PointResponse response;
  response.strain_energy = value_of(W);
  if (matter.tension != 0)
    W += matter.tension * (sqrt(Dual((F * matter.fibre.cast<Dual>()).squaredNorm())) - 1.);
  for (int i = 0; i < n_point_inputs; ++i) {
    response.gradient(i) = W.dx(i).val();
    for (int j = 0; j < n_point_inputs; ++j)
      response.hessian(i, j) = W.dx(i).dx(j);
  }
  return response;
}

} // namespace maille::fem_ref
