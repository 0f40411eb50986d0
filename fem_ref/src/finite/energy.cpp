#include "finite/energy.hpp"

#include <Eigen/LU>
#include <Sacado.hpp>

#include <algorithm>
#include <cmath>

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

/// Kinematic quantities of the laws, from F and the fibre.
struct Deformed {
  Dual J, log_J;
  Dual3 C;
  Dual I1, I2, I4, I5; ///< invariants of C, and f.C f, f.C^2 f
  Dual shape;          ///< J^(-2/3), which makes C isochoric
  Eigen::Vector3d fibre;

  Deformed(const Dual3& F, const Eigen::Vector3d& f)
      : J(F.determinant()), log_J(log(J)), C(F.transpose() * F), I1(C.trace()),
        I2(0.5 * (I1 * I1 - Dual(C.squaredNorm()))), shape(exp(Dual(log_J * (-2. / 3)))), fibre(f) {
    const Eigen::Matrix<Dual, 3, 1> Cf = C * f.cast<Dual>();
    I4 = Cf.dot(f.cast<Dual>());
    I5 = Cf.squaredNorm();
  }
};

Dual square(const Dual& x) {
  return x * x;
}

Dual energy(const NeoHookean& law, const Deformed& at) {
  return law.mu / 2 * (at.I1 - 3.) - law.mu * at.log_J + law.lambda / 2 * square(at.log_J);
}

Dual energy(const MooneyRivlin& law, const Deformed& at) {
  return law.c1 * (at.shape * at.I1 - 3.) + law.c2 * (square(at.shape) * at.I2 - 3.) +
         law.k / 2 * square(at.log_J);
}

/// Uses strain components in a frame of the fibre.
Dual energy(const Guccione& law, const Deformed& at) {
  Eigen::Matrix3d axes;
  axes.col(0) = at.fibre;
  axes.col(1) = at.fibre.unitOrthogonal();
  axes.col(2) = at.fibre.cross(axes.col(1));
  const Dual3 C = axes.transpose().cast<Dual>() * at.C * axes.cast<Dual>();
  const Dual Q =
      law.bf * square(0.5 * (C(0, 0) - 1.)) +
      law.bt * (square(0.5 * (C(1, 1) - 1.)) + square(0.5 * (C(2, 2) - 1.)) + 2. * square(0.5 * C(1, 2))) +
      2. * law.bfs * (square(0.5 * C(0, 1)) + square(0.5 * C(0, 2)));
  return law.C / 2 * (exp(Q) - 1.) + law.k / 2 * square(at.log_J);
}

Dual energy(const HolzapfelGasserOgden& law, const Deformed& at) {
  const Dual I1 = at.shape * at.I1 - 3.;
  Dual A = law.kappa * I1 + (1 - 3 * law.kappa) * (at.shape * at.I4 - 1.);
  if (value_of(A) < 0) // fibres carry no compression
    A = 0.;
  return law.c / 2 * I1 + law.k1 / (2 * law.k2) * (exp(Dual(law.k2 * square(A))) - 1.) +
         law.k / 2 * ((square(at.J) - 1.) / 2. - at.log_J);
}

/// (arcosh(1 + e))^2, by its series near e = 0, where arcosh is not differentiable.
Dual squared_arcosh(const Dual& e) {
  constexpr double near = 0.1; // the series' 14th term is 1e-18 there
  if (value_of(e) > near)
    return square(log(Dual(1. + e + sqrt(Dual(e * (e + 2.))))));
  Dual sum = 0., power = -1.;
  double binomial = 1; // binomial coefficient 2 n over n
  for (int n = 1; n < 14; ++n) {
    binomial *= 2. * (2 * n - 1) / n;
    power *= -2. * e;
    sum += 2 / (n * n * binomial) * power;
  }
  return sum;
}

/// Integrals of a fibre's passive and active force, starting at r = 1.
Dual fibre_work(const Muscle& law, const Dual& r) {
  const Dual v = r - 1., a = value_of(v) < 0 ? Dual(-v) : v;
  Dual active = a - 4. / 3 * a * a * a;
  if (value_of(a) > 0.4)
    active = 0.4 - 4. / 3 * 0.064 + 3 * 0.008 + 3. * pow(Dual(a - 0.6), 3);
  if (value_of(a) > 0.6)
    active = 0.4 - 4. / 3 * 0.064 + 3 * 0.008;
  Dual work = (value_of(v) < 0 ? -law.activation : law.activation) * active;
  if (value_of(v) <= 0)
    return work;
  const double bend = law.lam_max / law.Lofl - 1, steep = law.p1 * std::exp(law.p2 * bend);
  if (value_of(v) < bend)
    return work + law.p1 / law.p2 * (exp(Dual(law.p2 * v)) - 1.) - law.p1 * v;
  work += (steep - law.p1) / law.p2 - law.p1 * bend;
  return work + (steep - law.p1) * (v - bend) + 0.5 * law.p2 * steep * square(v - bend);
}

Dual energy(const Muscle& law, const Deformed& at) {
  const Dual stretch = sqrt(Dual(at.shape * at.I4)), along = at.I5 / square(at.I4) - 1.,
             cosh = square(at.shape) * (at.I1 * at.I4 - at.I5) / (2. * stretch);
  return law.g1 * along + law.g2 * squared_arcosh(cosh - 1.) + 9. / 4 * law.g3 * square(log(stretch)) +
         law.smax * fibre_work(law, stretch / law.Lofl) + law.k / 2 * square(at.log_J);
}

/// Rotation of F = R U. Newton's iteration doubles the number of correct digits of values and derivatives.
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

/// Shear modulus of the average over all rotations. Source  Voigt 1889 (Ann. Phys. 274)
double shear_modulus(const Matrix6& C) {
  const auto normal = C.topLeftCorner<3, 3>();
  return (3 * normal.trace() - normal.sum() + 6 * C.bottomRightCorner<3, 3>().trace()) / 30;
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
    matter.shear = shear_modulus(stiffness(material.elasticity));
  } else { // it includes the ratio of stiffness
    matter.stiffness = scene.object_stiffness(cell);
    matter.weight = body.tissue_of(cell);
    matter.shear = shear_modulus(matter.stiffness);
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
  Dual W = 0.;
  if (theta) {
    const Dual ratio = input(9, *theta) / F.determinant();
    strained *= Dual(cbrt(ratio));
    W = matter.shear / 2 * square(log(ratio));
  }
  W += matter.law ? std::visit([&](const auto& law) { return energy(law, Deformed(strained, matter.fibre)); },
                               *matter.law)
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
