#include "maille/fem_ref/solve.hpp"
#include "verify/problems.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

namespace maille::lab {

namespace {

/// A settled answer of finite elements on a grid that is bent into shape; on failure a row without a number.
std::optional<Answer> bent(Verification& verification, const Scene& scene, int degree,
                           const std::function<Vec3(const Vec3&)>& shape, VerificationRow row) {
  fem_ref::Options options;
  options.degree = degree;
  options.shape = shape;
  options.recover_stress = true;
  Answer answer = fem_ref::solve(scene, options).answer;
  if (is_converged(answer.status))
    return answer;
  row.method = answer.method;
  row.quantity += ": " + answer.message;
  row.computed = std::numeric_limits<double>::quiet_NaN();
  verification.add(std::move(row));
  return std::nullopt;
}

void verify_membrane(Verification& verification) {
  const auto shape = [](const Vec3& x) { return Vec3{48 * x[0], 44 * x[0] + x[1] * (44 - 28 * x[0]), 0}; };
  VerificationRow row;
  row.problem = "Cook's membrane";
  row.quantity = "rise of the middle of the right edge [m]";
  row.expected = 23.97;
  row.source =
      "Cook 1974, plane stress, E = 1, nu = 1/3, shear of 1 along the edge; converged value at (48, 52) by "
      "elements of high order, 23.968 +- 0.001. The singular corner at the clamp lets linear elements come "
      "near as h "
      "does: 0.2 % with 64 x 64";
  for (const int degree : {1, 2}) {
    const int n = degree == 1 ? 64 : 32;
    const Scene scene = Verification::scene(fmt::format(
        "[specimen]\nshape = \"box\"\ncells = [{0}, {0}]\nspacing = {1}\nplane = \"stress\"\n"
        "material = {{ youngs_modulus = 1, poisson_ratio = 0.333333333333333 }}\n[[hold]]\nwhere = \"x-\"\n"
        "[[load]]\nwhere = \"x+\"\ntraction = [0, 0.0625]\n",
        n, 1.0 / n));
    if (const auto answer = bent(verification, scene, degree, shape, row)) {
      row.method = answer->method;
      row.tolerance = degree == 2 ? 0.0008 : 0.003;
      row.computed = answer->displacement(1, scene.specimen.grid.node({n, n / 2, 0}));
      verification.add(row);
    }
  }
}

/// A quarter of an elliptic plate with an elliptic hole, 0.6 m thick: x from the inner to the outer ellipse,
/// y around.
Vec3 plate(const Vec3& x) {
  const double angle = x[1] * std::numbers::pi / 2;
  return {(2 + 1.25 * x[0]) * std::cos(angle), (1 + 1.75 * x[0]) * std::sin(angle), x[2]};
}

void verify_thick_plate(Verification& verification) {
  VerificationRow row;
  row.problem = "thick elliptic plate under pressure (LE10)";
  row.quantity = "stress yy at D [Pa]";
  row.expected = -5.38e6;
  row.source = "NAFEMS 1990, LE10, 1 MPa on the upper face, E = 210 GPa, nu = 0.3; stress as recovered at "
               "the node. The outer "
               "face is held along one line only, which makes values depend on the mesh: 3 %";
  const int radial = verification.is_quick() ? 8 : 12;
  const Scene scene = Verification::scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{0}, {0}, 4]\nspacing = [{1}, {1}, 0.15]\n"
                  "material = {{ youngs_modulus = \"210 GPa\", poisson_ratio = 0.3 }}\n"
                  "[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n[[hold]]\nwhere = \"y+\"\naxes = \"x\"\n"
                  "[[hold]]\nwhere = \"x+\"\naxes = \"xy\"\n[[hold]]\nwhere = {{ box = [[1, 0, 0.3], [1, 1, "
                  "0.3]] }}\naxes = \"z\"\n"
                  "[[load]]\nwhere = \"z+\"\ntraction = [0, 0, \"-1 MPa\"]\n",
                  radial, 1.0 / radial));
  if (const auto answer = bent(verification, scene, 2, plate, row)) {
    row.method = answer->method;
    row.tolerance = 0.03;
    row.computed = answer->nodal_stress[static_cast<std::size_t>(scene.specimen.grid.node({0, 0, 4}))][1];
    verification.add(row);
  }
}

} // namespace

void verify_curved(Verification& verification) {
  verify_membrane(verification);
  verify_thick_plate(verification);
}

} // namespace maille::lab
