#include "maille/materials/toml_reader.hpp"
#include "materials/read_helpers.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::faults_of;
using Messages = std::vector<std::string>;

std::optional<ElasticConstants> read(std::string_view text) {
  const toml::table document = parse_toml(text, "scene.toml");
  FaultList faults("scene.toml");
  TableReader table(document, "", faults);
  const auto constants = read_elastic_constants(table);
  table.finish();
  EXPECT_TRUE(faults.empty()) << text;
  return constants;
}

Messages faults(std::string_view text) {
  return faults_of(text, [](TableReader& table) { EXPECT_EQ(read_elastic_constants(table), std::nullopt); });
}

bool has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

} // namespace

TEST(ReadConstantsContract, ThreeForms) {
  const auto isotropic = read("youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3");
  ASSERT_TRUE(isotropic);
  EXPECT_TRUE(isotropic->is_isotropic());
  EXPECT_EQ(isotropic->youngs_modulus[2], 10e3);

  const auto fibrous =
      read("E_fibre = \"40 kPa\"\nE_cross = 8000\nG_fibre = \"5 kPa\"\nnu_fibre = 0.4\nnu_cross = 0.5");
  ASSERT_TRUE(fibrous);
  EXPECT_EQ(fibrous->youngs_modulus, (std::array{40e3, 8e3, 8e3}));
  EXPECT_EQ(fibrous->nu13, 0.4);
  EXPECT_EQ(fibrous->G12, 5e3);
  EXPECT_EQ(fibrous->G23, 8e3 / 3); // truth: E_cross / (2 (1 + nu_cross))

  const auto orthotropic =
      read("E = [\"20 kPa\", \"9 kPa\", 5000]\nnu = [0.3, 0.2, 0.25]\nG = [4e3, 3e3, 2e3]");
  ASSERT_TRUE(orthotropic);
  EXPECT_EQ(orthotropic->youngs_modulus, (std::array{20e3, 9e3, 5e3}));
  EXPECT_EQ(orthotropic->nu12, 0.3); // truth: the order nu12, nu13, nu23 and G12, G13, G23 of docs/scene.md
  EXPECT_EQ(orthotropic->nu13, 0.2);
  EXPECT_EQ(orthotropic->nu23, 0.25);
  EXPECT_EQ(orthotropic->G12, 4e3);
  EXPECT_EQ(orthotropic->G13, 3e3);
  EXPECT_EQ(orthotropic->G23, 2e3);
}

TEST(ReadConstantsContract, OtherKeysAreLeftToTheCaller) {
  const toml::table document = parse_toml("youngs_modulus = 1\npoisson_ratio = 0\ndensity = 5", "s");
  FaultList list("s");
  TableReader table(document, "", list);
  EXPECT_TRUE(read_elastic_constants(table));
  EXPECT_TRUE(list.empty());
}

TEST(ReadConstantsContract, TwoFaultsAtOnceWithTheirLines) {
  EXPECT_EQ(faults("youngs_modulus = \"-1 kPa\"\n\npoisson_ratio = 0.6\n"),
            (Messages{"scene.toml:1: youngs_modulus: expected youngs_modulus > 0, found \"-1 kPa\"",
                      "scene.toml:3: poisson_ratio: expected -1 < poisson_ratio < 0.5, found 0.6"}));
}

TEST(ReadConstantsContract, AWrongUnitNamesTheRightOnes) {
  EXPECT_EQ(
      faults("youngs_modulus = \"3 mm\"\npoisson_ratio = 0.3"),
      (Messages{
          "scene.toml:1: youngs_modulus: expected a pressure such as \"10 kPa\" (units: Pa, kPa, MPa, GPa, "
          "N/m^2, N/cm^2, N/mm^2, mmHg), found \"3 mm\""}));
}

TEST(ReadConstantsContract, FormsAreNotMixedAndAreWhole) {
  const Messages mixed = faults("youngs_modulus = 1\npoisson_ratio = 0.3\nE_fibre = 2");
  ASSERT_EQ(mixed.size(), 1U);
  EXPECT_TRUE(has(mixed[0], "expected all keys of one form: { youngs_modulus, poisson_ratio } (isotropic)"));
  EXPECT_TRUE(has(mixed[0], "found keys of 2 forms: youngs_modulus, poisson_ratio, E_fibre")) << mixed[0];

  // As many keys as the orthotropic form has, but of two forms.
  const Messages three = faults("youngs_modulus = 1\npoisson_ratio = 0.3\nE = [1, 1, 1]");
  ASSERT_EQ(three.size(), 1U);
  EXPECT_TRUE(has(three[0], "found keys of 2 forms: youngs_modulus, poisson_ratio, E")) << three[0];

  const Messages lacking = faults("E_fibre = 4\nE_cross = 2\nG_fibre = -1\nnu_fibre = 0.3");
  ASSERT_EQ(lacking.size(), 2U);
  EXPECT_TRUE(has(lacking[0], "found only E_fibre, E_cross, G_fibre, nu_fibre")) << lacking[0];
  EXPECT_TRUE(has(lacking[1], "scene.toml:3: G_fibre: expected G_fibre > 0, found -1")) << lacking[1];

  const Messages none = faults("density = 3");
  ASSERT_EQ(none.size(), 2U); // the missing form, and the key that this test does not ask for
  EXPECT_TRUE(has(none[0], "none of these keys")) << none[0];

  const Messages misspelt = faults("youngs_modulus = 1\npoisson_ration = 0.3");
  ASSERT_EQ(misspelt.size(), 2U);
  EXPECT_TRUE(has(misspelt[1],
                  "expected one of: poisson_ratio, youngs_modulus, found an unknown key (did you mean "
                  "\"poisson_ratio\"?)"))
      << misspelt[1];
}

TEST(ReadConstantsContract, EveryViolatedInequalityIsOneFault) {
  const Messages found = faults("E = [1e3, 4e3, -1]\nnu = [0.9, 0, 0]\nG = [0, 1e3, 1e3]");
  EXPECT_EQ(found, (Messages{"scene.toml:1: E: expected E3 > 0, found -1 > 0, which is false",
                             "scene.toml:3: G: expected G12 > 0, found 0 > 0, which is false"}));
  EXPECT_EQ(faults("E = [1e3, 4e3, 4e3]\nnu = [0.9, 0.8, 0]\nG = [1, 1, 1]"),
            (Messages{"scene.toml:2: nu: expected |nu12| < sqrt(E1/E2), found 0.9 < 0.5, which is false",
                      "scene.toml:2: nu: expected |nu13| < sqrt(E1/E3), found 0.8 < 0.5, which is false"}));
  // Truth: 1 - 3 * 0.9^2 - 2 * 0.9^3 = -2.888.
  EXPECT_EQ(
      faults("E = [1, 1, 1]\nnu = [0.9, 0.9, 0.9]\nG = [1, 1, 1]"),
      (Messages{
          "scene.toml:2: nu: expected 1 - nu12 nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 nu32 nu13 > 1e-09 (at 0 "
          "the stiffness is infinite: take slightly smaller Poisson ratios), found -2.888 > 1e-09, which is "
          "false"}));
}

TEST(ReadConstantsContract, TheIncompressibleLimitIsRefusedWithAdvice) {
  const Messages isotropic = faults("youngs_modulus = 1\npoisson_ratio = 0.5");
  ASSERT_EQ(isotropic.size(), 1U);
  EXPECT_TRUE(has(isotropic[0], "take a slightly smaller poisson_ratio, such as 0.49")) << isotropic[0];

  // Truth: the set 447 / 22.4 / 3.87 kPa, nu_fibre 0.5, nu_cross 1 - E_cross / (2 E_fibre) = 0.97494 is
  // singular.
  for (const char* nu_cross : {"0.974944071588367", "0.975"}) {
    const Messages fibrous =
        faults(std::string("E_fibre = \"447 kPa\"\nE_cross = \"22.4 kPa\"\nG_fibre = \"3.87 kPa\"\n"
                           "nu_fibre = 0.5\nnu_cross = ") +
               nu_cross);
    ASSERT_EQ(fibrous.size(), 1U);
    EXPECT_TRUE(has(fibrous[0],
                    "scene.toml:4: nu_fibre: expected 1 - nu_cross - 2 nu_fibre^2 E_cross / E_fibre > 0"));
    EXPECT_TRUE(has(fibrous[0], "take a slightly smaller nu_fibre or nu_cross")) << fibrous[0];
    EXPECT_TRUE(has(fibrous[0], "E_cross / E_fibre = 0.0501119")) << fibrous[0];
  }
  EXPECT_TRUE(read("youngs_modulus = 1\npoisson_ratio = 0.4999"));
}

TEST(ReadConstantsContract, AnInvalidCrossRatioIsOneFault) {
  EXPECT_EQ(faults("E_fibre = 4\nE_cross = 2\nG_fibre = 1\nnu_fibre = 0.3\nnu_cross = 1.5"),
            (Messages{"scene.toml:5: nu_cross: expected |nu_cross| < 1, found 1.5"}));
}

} // namespace maille
