// A scene's [test], answered: apparent constants of homogeneous bodies are the material's own.
#include "maille/deform/solve.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

constexpr double E = 10e3, nu = 0.3;

Scene tested(const std::string& test, const std::string& cells = "[8, 4, 4]", double poisson_ratio = nu,
             const std::string& more = "") {
  return parse_scene(fmt::format("[specimen]\nshape = \"box\"\ncells = {}\nspacing = \"1 mm\"\n{}"
                                 "material = {{ youngs_modulus = {}, poisson_ratio = {} }}\n"
                                 "[relaxation]\ntolerance = 1e-7\n[test]\n{}\n",
                                 cells, more, E, poisson_ratio, test));
}

TestResult result_of(const Scene& scene, const std::string& method = "coupled") {
  const Answer answer = deform::solve(scene, method);
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  const auto result = test_result(scene, answer);
  EXPECT_TRUE(result.has_value());
  return result.value_or(TestResult{});
}

std::string faults_of(const std::string& text, const std::string& more = "") {
  const std::vector<Fault> faults = test::faults_found_by([&] { tested(text, "[8, 4, 4]", nu, more); });
  return faults.empty() ? "" : InputError(faults).what();
}

// Truth: uniaxial stress, E strain, in every direction, either sense, and in two dimensions and one.
TEST(StandardTestAnalytic, BetweenSlidingPlatesABodyHasItsYoungsModulus) {
  for (const char* const axis : {"x", "y", "z"})
    for (const double strain : {0.05, -0.01}) {
      const Scene scene = tested(
          fmt::format("kind = \"axial\"\naxis = \"{}\"\nstrain = {}\nends = \"sliding\"", axis, strain));
      const TestResult found = result_of(scene);
      EXPECT_NEAR(found.apparent_modulus.value(), E, 1e-4 * E) << axis;
      EXPECT_NEAR(found.reaction, E * strain * scene.test->area,
                  1e-4 * E * std::abs(strain) * scene.test->area);
      EXPECT_NEAR(found.stiffness, E * scene.test->area / scene.test->length, 1e-4 * found.stiffness);
    }
  const std::string sliding = "kind = \"axial\"\naxis = \"x\"\nstrain = \"5 %\"\nends = \"sliding\"";
  EXPECT_NEAR(result_of(tested(sliding, "[8, 4]", nu, "plane = \"stress\"\n")).apparent_modulus.value(), E,
              1e-4 * E);
  EXPECT_NEAR(result_of(tested(sliding, "[8]")).apparent_modulus.value(), E, 1e-4 * E);
}

// Truth: no lateral strain: E (1 - nu) / ((1 + nu) (1 - 2 nu)).
TEST(StandardTestAnalytic, AConfinedBodyHasItsConfinedModulus) {
  const double confined = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  EXPECT_NEAR(
      result_of(tested("kind = \"confined\"\naxis = \"z\"\nstrain = \"-2 %\"")).apparent_modulus.value(),
      confined, 1e-4 * confined);
}

// Truth: beam theory without lateral contraction; the lattice's own error is of the order of 1 over the
// square of the cells through the thickness.
TEST(StandardTestAnalytic, ABentBeamHasItsYoungsModulus) {
  const Scene scene =
      tested("kind = \"bend\"\naxis = \"x\"\nalong = \"z\"\nstrain = \"0.1 %\"", "[32, 2, 8]", 0.0);
  const TestResult found = result_of(scene);
  EXPECT_NEAR(found.apparent_modulus.value(), E, 0.03 * E);
  EXPECT_NEAR(scene.test->angle(), 2 * 1e-3 * 32 / 8, 1e-12);
  EXPECT_GT(found.reaction, 0);
}

// Truth: the same beam, bent to a radian in frames of its cells, in one step and in the first of two.
TEST(StandardTestAnalytic, ABeamThatIsBentFarHasItsYoungsModulus) {
  const auto bent = [](const std::string& strain) {
    return parse_scene(
        "[specimen]\nshape = \"box\"\ncells = [40, 8]\nspacing = \"1 mm\"\nplane = \"stress\"\n"
        "material = { youngs_modulus = 10000, poisson_ratio = 0 }\n[relaxation]\nframe = "
        "\"blocks\"\ntolerance = 1e-5\n[test]\nkind = \"bend\"\naxis = \"x\"\nstrain = " +
        strain);
  };
  EXPECT_NEAR(bent("0.1").test->angle(), 1, 1e-12);
  EXPECT_NEAR(result_of(bent("0.1")).apparent_modulus.value(), E, 0.05 * E);
  const Scene half = scaled(bent("0.1"), 0.5), whole = bent("0.05");
  ASSERT_EQ(half.prescribed.size(), whole.prescribed.size());
  for (std::size_t i = 0; i < half.prescribed.size(); ++i)
    EXPECT_NEAR(half.prescribed[i].value, whole.prescribed[i].value, 1e-12);
}

// Truth: a layer that is wide for its height is sheared evenly but at its ends: G (1 - O(height / width)).
TEST(StandardTestAnalytic, AWideLayerHasItsShearModulus) {
  const double G = E / (2 * (1 + nu));
  const double found =
      result_of(tested("kind = \"shear\"\naxis = \"z\"\nalong = \"x\"\nstrain = \"1 %\"", "[48, 48, 2]"))
          .apparent_modulus.value();
  EXPECT_LT(found, G * (1 + 1e-6));
  EXPECT_GT(found, 0.95 * G);
}

// Truth: F / (2 R d) of the reactions themselves; twice the depth takes twice the force.
TEST(StandardTestOracle, AnIndenterFeelsTheForceOfItsPatch) {
  const std::string indent = "kind = \"indent\"\naxis = \"z\"\nradius = \"2 mm\"\nstrain = ";
  const Scene scene = tested(indent + "0.01", "[12, 12, 8]");
  const Answer answer = deform::solve(scene, "coupled");
  double force = 0;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (!scene.prescribed[i].held && scene.prescribed[i].component == 2) {
      force -= answer.reaction[i];
      ++moved;
    }
  EXPECT_EQ(moved, 13u); // nodes of a 1 mm grid within 2 mm of one of them
  const double radius = 1e-3 * (std::sqrt(13 / std::numbers::pi) - 0.25);
  EXPECT_NEAR(scene.test->radius, radius, 1e-9);
  EXPECT_TRUE(test::has(plausibility(scene).warnings.at(0), "a radius of 1.8 cells"));
  const TestResult found = test_result(scene, answer).value();
  EXPECT_GT(found.reaction, 0);
  EXPECT_NEAR(found.reaction, force, 1e-12);
  EXPECT_NEAR(found.apparent_modulus.value(), force / (2 * radius * 0.08e-3), 1e-6 * E);
  EXPECT_NEAR(result_of(tested(indent + "0.02", "[12, 12, 8]")).reaction, 2 * force, 1e-4 * force);
}

// Truth: Hayes et al. 1972, J. Biomech. 5:541, table 1: F / (2 R d) of a bonded layer is kappa E / (1 -
// nu^2).
TEST(StandardTestAnalytic, AnIndentedLayerIsThatOfHayes) {
  struct Layer {
    int cells, height; ///< to a radius, and high
    double kappa, within;
  };
  for (const Layer& layer : {Layer{4, 4, 2.480, 0.05}, Layer{6, 6, 2.480, 0.03}, Layer{8, 8, 2.480, 0.03},
                             Layer{6, 15, 1.472, 0.03}}) {
    const TestResult found = result_of(
        tested(fmt::format("kind = \"indent\"\naxis = \"z\"\nradius = \"{} mm\"\nstrain = 0.01", layer.cells),
               fmt::format("[{0}, {0}, {1}]", 8 * layer.cells, layer.height)));
    EXPECT_NEAR(found.apparent_modulus.value() / (layer.kappa * E / (1 - nu * nu)), 1, layer.within)
        << layer.cells << " " << layer.height;
  }
}

// Truth: statics: a force of 6 mN on an arm of 12 mm is 72 uN m at the hold.
TEST(ForceCheckAnalytic, LimitsHoldABeamAgainstBending) {
  const auto checked = [](const std::string& more) {
    const Scene scene = parse_scene(test::box_text("[6, 6, 12]") + test::hold_text("z-") +
                                    "[[load]]\nwhere = \"z+\"\nforce = [\"6 mN\", 0, 0]\n" + more);
    return check_forces(scene, deform::solve(scene, "coupled")).value();
  };
  const ForceCheck free = checked("");
  EXPECT_TRUE(free.caveats.empty());
  EXPECT_LT(free.moment_share, 1e-4);
  const ForceCheck bound =
      checked("[limits]\nfrom = \"given\"\nstretch = 1.02\ncompress = 0.98\nshear = 0.02\n");
  EXPECT_LT(bound.force_share, 1e-4);
  EXPECT_NEAR(std::abs(bound.missing.moment[1]), bound.moment_share * 72e-6, 1e-9);
  EXPECT_GT(bound.moment_share, 0.5);
  ASSERT_EQ(bound.caveats.size(), 1u);
  EXPECT_TRUE(test::has(bound.caveats[0], "moments are not in balance"));
}

// Truth: the definition: at a Poisson ratio of 0.4999 the diagonal is 1667 times Young's modulus.
TEST(ForceCheckAnalytic, RelaxedHasNoModulusNearIncompressibility) {
  const std::string axial = "kind = \"axial\"\naxis = \"z\"\nstrain = -0.02";
  EXPECT_TRUE(result_of(tested(axial), "relaxed").apparent_modulus);
  const Scene scene = tested(axial, "[4, 4, 4]", 0.4999);
  EXPECT_FALSE(result_of(scene, "relaxed").apparent_modulus);
  EXPECT_TRUE(result_of(scene).apparent_modulus);
  EXPECT_NEAR(stiffening_of_relaxed(scene), 1667, 1);
}

// Truth: in uniaxial stress the effective strain is the strain, everywhere.
TEST(StandardTestAnalytic, AnEvenlyStrainedBodyFailsAtTheCriterionsStrain) {
  const Scene scene = tested(
      "kind = \"axial\"\naxis = \"x\"\nstrain = \"-0.1 %\"\nends = \"sliding\"\nfailure = \"pistoia\"");
  EXPECT_NEAR(result_of(scene).failure.value(), -E * 0.007 * scene.test->area,
              1e-3 * E * 0.007 * scene.test->area);
}

// Truth: the reader's rules for faulty tests (docs/scene.md).
TEST(StandardTestContract, FaultyTestsAreRefused) {
  const std::string axial = "kind = \"axial\"\naxis = \"x\"\nstrain = 0.05\n";
  EXPECT_EQ(faults_of(axial), "");
  for (const std::string text : {"kind = \"axail\"\naxis = \"w\"\nstrain = \"1 mm\"", ""})
    for (const char* const key : {"test.kind", "test.axis", "test.strain"})
      EXPECT_TRUE(test::has(faults_of(text), key));
  for (const char* const strain : {"0", "1e300", "inf", "nan", "-11"})
    EXPECT_TRUE(test::has(faults_of(std::string("kind = \"axial\"\naxis = \"x\"\nstrain = ") + strain),
                          "test.strain"))
        << strain;
  EXPECT_TRUE(test::has(faults_of(axial, "lattice = \"fibre\"\n"), "specimen.lattice"));
  for (const auto& [text, part] : std::vector<std::pair<std::string, const char*>>{
           {"axis = \"x\"\nstrain = 0.1", "test.kind"},
           {axial + "[[hold]]\nwhere = \"x-\"", "no holds and moves beside a [test]"},
           {axial + "radius = \"1 mm\"", "no such key unless kind = \"indent\""},
           {axial + "size = 3", "test.size"},
           {"kind = \"shear\"\naxis = \"x\"\nalong = \"x\"\nstrain = 0.1", "test.along"},
           {"kind = \"indent\"\naxis = \"x\"\nradius = \"-1 mm\"\nstrain = 0.1", "test.radius"},
           {"kind = \"indent\"\naxis = \"z\"\nradius = \"0.1 mm\"\nstrain = 0.1", "test.radius"},
           {"kind = \"indent\"\naxis = \"z\"\nstrain = -0.1", "a depth above 0"},
           {"kind = \"bend\"\naxis = \"x\"\nstrain = 0.3", "frame = \"blocks\""}})
    EXPECT_TRUE(test::has(faults_of(text), part));
}

// Truth: methods without forces have no result, nor have scenes without a test.
TEST(StandardTestContract, WhatHasNoForcesHasNoResult) {
  const Scene scene = tested("kind = \"axial\"\naxis = \"x\"\nstrain = 0.05");
  EXPECT_FALSE(test_result(scene, deform::solve(scene, "limits")));
  Scene plain = scene;
  plain.test.reset();
  EXPECT_FALSE(test_result(plain, deform::solve(plain, "coupled")));
}

// Truth: half of the strain is half of the reaction, and the same constants.
TEST(StandardTestContract, StepsOfASeriesAreTestsOfTheirOwn) {
  const Scene scene = tested("kind = \"shear\"\naxis = \"x\"\nstrain = 0.05");
  const TestResult whole = result_of(scene), half = result_of(scaled(scene, 0.5));
  EXPECT_NEAR(half.reaction, whole.reaction / 2, 1e-5 * std::abs(whole.reaction));
  EXPECT_NEAR(half.apparent_modulus.value(), whole.apparent_modulus.value(), 1e-4 * E);
}

} // namespace
} // namespace maille
