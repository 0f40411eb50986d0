// What a question asks for, in proportion to its body.
#include "maille/scene/plausibility.hpp"

#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

/// A strip of 60 x 20 x 20 mm, held at x-.
std::string strip(const std::string& rest, const std::string& spacing = "5 mm",
                  const std::string& material = "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }") {
  return "[specimen]\nshape = \"box\"\ncells = [12, 4, 4]\nspacing = \"" + spacing +
         "\"\nmaterial = " + material + "\n[[hold]]\nwhere = \"x-\"\n" + rest;
}

std::string pulled(const std::string& by) {
  return "[[move]]\nwhere = \"x+\"\nby = [\"" + by + "\", 0, 0]\n";
}

Plausibility of(const std::string& text) {
  return plausibility(parse_scene(text));
}

// Truth: lengths and quotients of the numbers in the texts.
TEST(PlausibilityAnalytic, SizesMovesAndStrainsAreThoseOfTheText) {
  const Scene scene = parse_scene(strip(pulled("3 mm")));
  const Plausibility found = plausibility(scene);
  EXPECT_DOUBLE_EQ(found.size[0], 60e-3);
  EXPECT_NEAR(found.largest_move, 3e-3, 1e-15);
  EXPECT_NEAR(found.move_over_length, 0.05, 1e-12);
  EXPECT_NEAR(found.mean_strain.value(), 0.05, 1e-12);
  EXPECT_FALSE(found.strain_of_loads);
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  EXPECT_EQ(in_words(scene, found),
            "size 60 x 20 x 20 mm; largest move 3 mm, 5 % of the length; mean strain 5 %");

  // A poke of 2 mm from the side, 20 mm above the nearest held node.
  const Plausibility poke =
      of("[specimen]\nshape = \"box\"\ncells = [12, 4, 4]\nspacing = \"5 mm\"\nmaterial = \"muscle/soleus\"\n"
         "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = { box = [[\"30 mm\", \"10 mm\", \"20 mm\"], [\"30 "
         "mm\", \"10 mm\", "
         "\"20 mm\"]] }\nby = [0, 0, \"-2 mm\"]\n");
  EXPECT_NEAR(poke.mean_strain.value(), 0.1, 1e-12);

  // A plane of symmetry along the pull holds nothing against it.
  const Plausibility symmetric = of(strip(pulled("3 mm") + "[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n"));
  EXPECT_NEAR(symmetric.mean_strain.value(), 0.05, 1e-12);

  // Nothing is held: both ends go apart by 2 mm.
  const Plausibility apart =
      of("[specimen]\nshape = \"box\"\ncells = [10]\nspacing = \"2 mm\"\nmaterial = \"muscle/soleus\"\n"
         "[[move]]\nwhere = \"x-\"\nby = \"-1 mm\"\n[[move]]\nwhere = \"x+\"\nby = \"1 mm\"\n");
  EXPECT_NEAR(apart.mean_strain.value(), 0.1, 1e-12);
}

TEST(PlausibilityContract, WhatIsOutOfProportionIsSaid) {
  const auto warns = [](const std::string& text, const std::string& of_what) {
    for (const std::string& warning : of(text).warnings)
      if (warning.find(of_what) != std::string::npos)
        return true;
    return false;
  };
  EXPECT_TRUE(warns(strip(pulled("60 mm")), "mean strain of 100 %"));
  EXPECT_TRUE(warns(strip(pulled("6 m")), "is it in the unit that was meant"));
  EXPECT_TRUE(warns(strip("", "2 m"), "cells of 2 m"));
  EXPECT_TRUE(warns(strip("", "2 m"), "a body of 24 m"));
  EXPECT_TRUE(warns(strip("[[load]]\ncontraction = \"20 kPa\"\n"), "contraction is 200 %"));
  EXPECT_TRUE(warns(strip("[[load]]\nwhere = \"x+\"\ntraction = [\"2 kPa\", 0, 0]\n"), "traction is 20 %"));
  EXPECT_TRUE(warns(strip(pulled("30 mm"), "5 mm", "\"liver/parenchyma\""), "fails at a stretch"));
  EXPECT_FALSE(warns(strip(pulled("30 mm") + "[relaxation]\nframe = \"blocks\"\n"), "mean strain"))
      << "strains are measured otherwise there";
}

// Truth: an image that is stored superior, right, anterior-reversed.
TEST(PlausibilityOracle, FibresAndGravityPointInThePatient) {
  const auto words = [](const std::string& fibre, const std::string& load, WorldAxes world) {
    const Affine affine{{{0, 1e-3, 0, 0}, {0, 0, -1e-3, 0}, {1e-3, 0, 0, 0}, {0, 0, 0, 1}}};
    const Scene scene =
        SceneBuilder()
            .labels(std::vector<std::uint8_t>(27, 1), ArrayLayout::x_fastest({3, 3, 3}), affine)
            .world(world)
            .keys("[specimen]\nmaterial = \"muscle/soleus\"\n" + fibre +
                  "\n[[hold]]\nwhere = \"x-\"\n[[load]]\n" + load)
            .build();
    return in_words(scene, plausibility(scene));
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
  };
  const std::string plain = words("", "gravity = [9.81, 0, 0]", WorldAxes::ras);
  has(plain, "\nfibres along x of the grid: inferior-superior");
  has(plain, "\ngravity points to superior (x of the grid)");
  const std::string asked = words("fibre = { direction = [0, 3, 0], frame = \"lps\" }",
                                  "gravity = [0, 1, 0]\nframe = \"lps\"", WorldAxes::ras);
  has(asked, "fibres along z of the grid: anterior-posterior");
  has(asked, "gravity points to posterior (z of the grid)");
  has(words("fibre = { angle = \"30 deg\", plane = \"zx\", frame = \"world\" }", "gravity = [0, -1, 0]",
            WorldAxes::lps),
      "inferior-superior, 30 deg off");
  has(words("", "gravity = [0, -1, 0]", WorldAxes::lps), "gravity points to right (-y of the grid)");
  has(words("", "gravity = [0, -1, 0]", WorldAxes::unknown), "gravity points along -y of the grid");
  EXPECT_THROW(
      words("fibre = { direction = [0, 3, 0], frame = \"ras\" }", "gravity = [1, 0, 0]", WorldAxes::unknown),
      InputError);
  EXPECT_THROW(
      words("fibre = { direction = [0, 0, 0], frame = \"ras\" }", "gravity = [1, 0, 0]", WorldAxes::ras),
      InputError);
}

PartMechanics strained_by(double percentile_5, double percentile_95) {
  PartMechanics body;
  body.von_mises = Spread{};
  body.smallest_strain = Spread{.percentile_5 = percentile_5};
  body.largest_strain = Spread{.percentile_95 = percentile_95};
  return body;
}

// Truth: small strains end at 10 %, and a fifth of 60 mm is 12 mm.
TEST(PlausibilityContract, AnswersThatSmallStrainsDoNotAllowAreSaid) {
  const Scene loaded = parse_scene(strip("[[load]]\ngravity = [0, 0, \"-9.81 m/s^2\"]\n", "5 mm",
                                         "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, density = "
                                         "\"1000 kg/m^3\" }"));
  const auto warnings = [&](double displacement, const PartMechanics& body) {
    return implausible_answer(loaded, plausibility(loaded), "coupled", displacement, body).size();
  };
  EXPECT_EQ(warnings(11.9e-3, strained_by(-0.09, 0.09)), 0U);
  EXPECT_EQ(warnings(12.1e-3, strained_by(-0.09, 0.09)), 1U) << "far";
  EXPECT_EQ(warnings(1e-3, strained_by(-0.11, 0.01)), 1U) << "pressed";
  EXPECT_EQ(warnings(1e-3, strained_by(-0.01, 0.11)), 1U) << "stretched";
  EXPECT_EQ(warnings(30e-3, strained_by(-0.3, 0.3)), 2U);
  PartMechanics without_stress = strained_by(-0.3, 0.3);
  without_stress.von_mises.reset();
  EXPECT_EQ(warnings(30e-3, without_stress), 0U) << "limits know no small strains";

  const auto warnings_of = [](const std::string& text, double displacement) {
    return implausible_answer(parse_scene(text), of(text), "coupled", displacement, strained_by(-0.3, 0.3))
        .size();
  };
  EXPECT_EQ(warnings_of(strip(pulled("20 mm")), 20e-3), 0U) << "the question is warned of already";
  EXPECT_EQ(warnings_of(strip(pulled("3 mm")), 3e-3), 1U);
  EXPECT_EQ(warnings_of(strip(pulled("3 mm") + "[relaxation]\nframe = \"blocks\"\n"), 3e-3), 0U);
}

} // namespace
} // namespace maille
