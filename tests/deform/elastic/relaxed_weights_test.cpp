// What relaxed_weights do, and to whom.
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

/// A bar of a belly between two tendons, pulled; the limits are out of the way.
Scene bar(const std::string& belly) {
  return parse_scene(R"(units = "m, rad"
[specimen]
shape = "muscle"
cells = [10]
spacing = "1 mm"
tendon = { fraction = 0.2, material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 } }
material = )" + belly +
                     R"(
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["1 mm"]
[limits]
from = "given"
stretch = 2
compress = 0
shear = 1
[relaxation]
tolerance = 1e-10
)");
}

// Springs in series: a quarter of the weight is a quarter of the modulus.
TEST(RelaxedWeightsOracle, AWeightIsAModulusOfItsOwn) {
  const Scene weighted = bar("{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, relaxed_weights = 0.25 }");
  const Scene softer = bar("{ youngs_modulus = \"2.5 kPa\", poisson_ratio = 0.3 }");
  const Scene plain = bar("{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }");
  const auto at = [](const Scene& scene, const char* method) {
    return solve(scene, method).displacement(0, 2);
  };
  EXPECT_NEAR(at(weighted, "relaxed"), at(softer, "relaxed"), 1e-12);
  EXPECT_GT(at(plain, "relaxed") - at(weighted, "relaxed"), 1e-4);
  for (const char* method : {"coupled", "limits", "sweep"})
    EXPECT_EQ(at(weighted, method), at(plain, method)) << method << " knows no weights";
}

// Weights turn as slack does: by squares, so a quarter turn moves them from one axis to the other.
TEST(RelaxedWeightsOracle, TheyTurnWithTheFibre) {
  const auto sheet = [](const std::string& fibre, const std::string& weights) {
    return parse_scene(
        "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [6, 4]\nspacing = \"1 mm\"\nfibre = " +
        fibre + "\nmaterial = { youngs_modulus = 1e4, poisson_ratio = 0.3, relaxed_weights = " + weights +
        " }\n[[hold]]\nwhere = \"y-\"\n[[move]]\nwhere = { box = [[0.002, 0.004], [0.004, 0.004]] }\nby = "
        "[1e-4, "
        "-2e-4]\n");
  };
  const Displacement along = solve(sheet("[1, 0, 0]", "[0.5, 2, 1]"), "relaxed").displacement;
  const Displacement across = solve(sheet("[0, 1, 0]", "[2, 0.5, 1]"), "relaxed").displacement;
  for (std::size_t node = 0; node < along.values().size(); ++node)
    EXPECT_NEAR(along.values()[node], across.values()[node], 1e-12);
}

} // namespace
} // namespace maille::deform
