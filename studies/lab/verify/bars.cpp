#include "verify/problems.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr double E = 10e3, L = 0.02; // Pa, m
constexpr double traction = 250, density = 1060, g = 9.81;

/// A bar of 20 cells along x, one cell thick, held at its end; without contraction, so that the hold does not
/// matter.
std::string bar(int dimension, const std::string& more) {
  const char* cells[] = {"[20]", "[20, 1]", "[20, 1, 1]"};
  return fmt::format("[specimen]\nshape = \"box\"\ncells = {}\nspacing = \"1 mm\"\n"
                     "material = {{ youngs_modulus = {}, poisson_ratio = 0, density = {} }}\n"
                     "[[hold]]\nwhere = \"x-\"\n{}",
                     cells[dimension - 1], E, density, more);
}

std::string zeros(int dimension) {
  return dimension == 1 ? "" : dimension == 2 ? ", 0" : ", 0, 0";
}

/// Where the free end of the bar goes.
void add_tip(Verification& verification, const Scene& scene, VerificationRow row) {
  for (const std::string& method : verification.methods()) {
    const auto answer = verification.answer(scene, method, row);
    if (!answer)
      continue;
    row.method = method;
    row.tolerance = method == "calculix" ? 1e-6 : 1e-9; // it prints seven digits
    row.computed = answer->displacement(0, scene.specimen.grid.node({20, 0, 0}));
    verification.add(row);
  }
}

} // namespace

void verify_bars(Verification& verification) {
  for (int d = 1; d <= 3; ++d) {
    const std::string in = fmt::format(", {}D", d);
    const std::string load = fmt::format("[[load]]\nwhere = \"x+\"\ntraction = [{}{}]\n", traction, zeros(d));
    VerificationRow row;
    row.quantity = "displacement of the end [m]";
    row.problem = "bar, end load" + in;
    row.expected = traction * L / E;
    row.source = "t L / E";
    add_tip(verification, Verification::scene(bar(d, load)), row);

    row.problem = "bar, own weight" + in;
    row.expected = density * g * L * L / (2 * E);
    row.source = "rho g L^2 / (2 E)";
    add_tip(verification,
            Verification::scene(bar(d, fmt::format("[[load]]\ngravity = [{}{}]\n", g, zeros(d)))), row);

    // Eight of its twenty cells of the one matter, twelve of another that is five times as stiff.
    Scene series = Verification::scene(bar(d, load));
    series.materials.push_back(series.materials[0]);
    series.materials[1].elasticity = ElasticConstants::isotropic(5 * E, 0);
    series.specimen.material_id.assign(20, 1);
    std::fill_n(series.specimen.material_id.begin(), 8, std::uint8_t{0});
    row.problem = "bar, two materials in series" + in;
    row.expected = traction * (0.4 * L / E + 0.6 * L / (5 * E));
    row.source = "t (L_1 / E_1 + L_2 / E_2)";
    add_tip(verification, series, row);
  }
}

} // namespace maille::lab
