#include "verify/problems.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace maille::lab {

namespace {

void verify_cantilever(Verification& verification) {
  const Scene scene = Verification::scene(
      "[specimen]\nshape = \"box\"\ncells = [90, 4, 2]\nspacing = [0.0666666666666667, 0.05, 0.05]\n"
      "material = { youngs_modulus = 1e7, poisson_ratio = 0.3 }\n[[hold]]\nwhere = \"x-\"\n"
      "[[load]]\nwhere = \"x+\"\ntraction = [0, 50, 0]\n");
  VerificationRow row;
  row.problem = "slender cantilever, unit load at the tip";
  row.quantity = "deflection of the tip [m]";
  row.expected = 0.1081;
  row.source =
      "MacNeal and Harder 1985, straight beam: P L^3 / (3 E I) + 6 P L / (5 G A). Beam theory leaves out "
      "what "
      "the clamp does over one depth, 0.2 %. Linear elements of length a in a beam of depth D also shear "
      "where "
      "they should bend, which adds G / E (a / D)^2 = 4.3 % to the stiffness, and cannot bend across, which "
      "adds nu^2 / (1 - nu^2) / 16 = 0.6 % with four through the depth: 5 % in all";
  for (const std::string& method : verification.methods())
    if (const auto answer = verification.answer(scene, method, row)) {
      row.method = method;
      row.tolerance = method == "fem_q2" ? 0.003 : method == "coupled" ? 0.01 : 0.06;
      row.computed = answer->displacement(1, scene.specimen.grid.node({90, 2, 1}));
      verification.add(row);
    }
}

/// Torsion constant of a square bar over the fourth power of its side. Timoshenko and Goodier 1951,
/// article 109.
double square_bar() {
  double sum = 0;
  for (int n = 1; n < 60; n += 2)
    sum += std::tanh(n * std::numbers::pi / 2) / std::pow(n, 5);
  return 1.0 / 3 - 64 / std::pow(std::numbers::pi, 5) * sum;
}

/// Moment about the bar's axis of the forces that turn its upper end [N m].
double torque(const Scene& scene, const Answer& answer, double middle) {
  double moment = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    const Prescribed& p = scene.prescribed[i];
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
    if (p.held || p.component == 2)
      continue;
    moment += p.component == 1 ? (x[0] - middle) * answer.reaction[i] : -(x[1] - middle) * answer.reaction[i];
  }
  return moment;
}

void verify_torsion(Verification& verification) {
  // Ends turn in their planes and warp freely, so the bar twists evenly from end to end.
  constexpr double angle = 1e-4; // rad: what a finite turn adds is 1e-4 of it
  const int n = verification.is_quick() ? 8 : 12;
  const Scene scene = Verification::scene(fmt::format(
      "[specimen]\nshape = \"box\"\ncells = [{0}, {0}, 4]\nspacing = [{1}, {1}, 0.25]\n"
      "material = {{ youngs_modulus = 26e3, poisson_ratio = 0.3 }}\n[[hold]]\nwhere = \"z-\"\naxes = \"xy\"\n"
      "[[hold]]\nwhere = {{ box = [[0, 0, 0], [0, 0, 0]] }}\naxes = \"z\"\n"
      "[[move]]\nwhere = \"z+\"\naxes = \"xy\"\nturn = {{ angle = {2}, axis = [0, 0, 1] }}\n",
      n, 1.0 / n, angle));
  VerificationRow row;
  row.problem = "square bar in torsion";
  row.quantity = "torque [N m]";
  row.expected = square_bar() * 10e3 * angle;
  row.source = fmt::format("{:.4f} G a^4 per angle and length; Timoshenko and Goodier 1951, article 109",
                           square_bar());
  for (const std::string method : {"coupled", "fem_q1", "fem_q2"})
    if (const auto answer = verification.answer(scene, method, row)) {
      row.method = method;
      row.tolerance = method == "fem_q2" ? 0.001 : 0.02;
      row.computed = torque(scene, *answer, 0.5);
      verification.add(row);
    }
}

/// Pulled with free sides the strip has one strain everywhere, which every element holds.
void verify_strip(Verification& verification) {
  constexpr double E1 = 100e3, E2 = 10e3, nu12 = 0.3, G12 = 7e3, traction = 500, length = 0.012;
  for (const int degrees : {20, 45, 90}) {
    const Scene scene = Verification::scene(fmt::format(
        "[specimen]\nshape = \"box\"\ncells = [12, 4, 3]\nspacing = \"1 mm\"\n"
        "material = {{ E_fibre = {}, E_cross = {}, G_fibre = {}, nu_fibre = {}, nu_cross = 0.4 }}\n"
        "fibre = {{ angle = \"{} deg\", plane = \"xy\" }}\n"
        "[[hold]]\nwhere = {{ box = [[0, 0, 0], [0, 0, 0]] }}\n"
        "[[hold]]\nwhere = {{ box = [[{}, 0, 0], [{}, 0, 0]] }}\naxes = \"yz\"\n"
        "[[hold]]\nwhere = {{ box = [[0, 0.004, 0], [0, 0.004, 0]] }}\naxes = \"z\"\n"
        "[[load]]\nwhere = \"x+\"\ntraction = [{}, 0, 0]\n[[load]]\nwhere = \"x-\"\ntraction = [-{}, 0, 0]\n",
        E1, E2, G12, nu12, degrees, length, length, traction, traction));
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 s = std::sin(degrees * std::numbers::pi / 180);
    const double c2 = c * c, s2 = s * s, mixed = 1 / G12 - 2 * nu12 / E1;
    VerificationRow modulus;
    modulus.problem = fmt::format("strip pulled {} degrees off its fibres", degrees);
    modulus.quantity = "modulus [Pa]";
    modulus.expected = 1 / (c2 * c2 / E1 + s2 * s2 / E2 + c2 * s2 * mixed);
    modulus.source = "1 / E_x = c^4 / E_1 + s^4 / E_2 + c^2 s^2 (1 / G_12 - 2 nu_12 / E_1); Lekhnitskii 1963";
    VerificationRow shear = modulus;
    shear.quantity = "shear strain over stress [1/Pa]";
    shear.expected = 2 * c * s * (c2 / E1 - s2 / E2 - (c2 - s2) * mixed / 2);
    shear.source =
        "S_16 = 2 c s (c^2 / E_1 - s^2 / E_2 - (c^2 - s^2) (1 / G_12 - 2 nu_12 / E_1) / 2); Lekhnitskii 1963";
    for (const std::string& method : verification.methods()) {
      const auto answer = verification.answer(scene, method, modulus);
      if (!answer)
        continue;
      const Grid& grid = scene.specimen.grid;
      modulus.method = shear.method = method;
      modulus.tolerance = shear.tolerance = method == "calculix" ? 2e-6 : 1e-9;
      modulus.computed = traction * length / answer->displacement(0, grid.node({12, 0, 0}));
      verification.add(modulus);
      // The edge along x is kept there, so what shears is the edge along y.
      shear.computed = answer->displacement(0, grid.node({0, 4, 0})) / 0.004 / traction;
      if (degrees != 90) // there it is zero
        verification.add(shear);
    }
  }
}

} // namespace

void verify_beams(Verification& verification) {
  verify_cantilever(verification);
  verify_torsion(verification);
  verify_strip(verification);
}

} // namespace maille::lab
