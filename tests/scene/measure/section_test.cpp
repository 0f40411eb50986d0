/// Forces across planes.
#include "measure/section.hpp"

#include "maille/deform/solve.hpp"
#include "support/dice.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace maille {
namespace {

// Truth: counting points on a fine grid.
TEST(SectionOracle, ShareOfABoxBeyondAPlane) {
  std::mt19937 random(11);
  tests::Dice dice{random};
  for (int round = 0; round < 60; ++round) {
    const std::array<double, 3> size{dice.between(0.5, 2), dice.between(0.5, 2), dice.between(0.5, 2)},
        normal{dice.between(-1, 1), round % 3 == 0 ? 0 : dice.between(-1, 1), dice.between(-1, 1)};
    const double offset = dice.between(-1, 1);
    constexpr int n = 60;
    int beyond = 0;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          beyond += normal[0] * size[0] * (i + 0.5) / n + normal[1] * size[1] * (j + 0.5) / n +
                                normal[2] * size[2] * (k + 0.5) / n >
                            offset
                        ? 1
                        : 0;
    EXPECT_NEAR(share_beyond(size, normal, offset), beyond / double(n * n * n), 0.01) << round;
  }
}

// Truth: halves, quarters and corners of a cube by hand; nearly degenerate normals change little.
TEST(SectionAnalytic, SharesByHand) {
  const std::array<double, 3> cube{1, 1, 1};
  const auto share = [&](std::array<double, 3> normal, double offset) {
    return share_beyond(cube, normal, offset);
  };
  EXPECT_NEAR(share({1, 0, 0}, 0.25), 0.75, 1e-15);
  EXPECT_NEAR(share({-1, 0, 0}, -0.25), 0.25, 1e-15);
  EXPECT_NEAR(share({1, 1, 0}, 1), 0.5, 1e-15);
  EXPECT_NEAR(share({1, 1, 1}, 0.5), 1 - 0.125 / 6, 1e-15);
  EXPECT_NEAR(share({1, 1, 1}, 1.5), 0.5, 1e-15);
  EXPECT_EQ(share({1, 1, 1}, 3), 0);
  EXPECT_EQ(share({1, 1, 1}, 0), 1);
  for (const double tilt : {1e-3, 1e-4, 1.1e-5, 9e-6, 1e-6, 1e-9, 0.0})
    EXPECT_NEAR(share({1, tilt, -tilt}, 0.3), 0.7, 1e-9) << tilt;
  EXPECT_EQ(share_beyond({}, {}, -1), 1);
  EXPECT_EQ(share_beyond({}, {}, 0), 0);
}

struct Bar {
  SceneAndMeasures read;
  std::vector<MeasuredValue> values;
  Answer answer;

  Bar(const std::string& conditions, const std::vector<double>& places_mm, const std::string& component,
      const char* normal = "[1, 0, 0]", const char* shape = "box") {
    std::string text = fmt::format("[specimen]\nshape = \"{}\"\ncells = [10, 4, 4]\nspacing = \"1 "
                                   "mm\"\nmaterial = {{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, "
                                   "density = 1200 }}\n[relaxation]\ntolerance = 1e-10\n{}",
                                   shape, conditions);
    for (std::size_t i = 0; i < places_mm.size(); ++i)
      text +=
          fmt::format("[[measure]]\nname = \"s{}\"\nforce = {{ section = {{ point = [\"{} mm\", \"2 mm\", "
                      "\"2 mm\"], normal = {} }} }}\n{}",
                      i, places_mm[i], normal, component);
    read = parse_scene_and_measures(text);
    answer = deform::solve(read.scene, "coupled");
    EXPECT_EQ(answer.status, Status::done) << answer.message;
    values = measured(read.scene, read.measures, answer);
  }
};

// Truth: a bar is pulled by the same force across every plane, oblique ones too: the move's.
TEST(SectionAnalytic, APulledBarHasOneForceAtEveryPlace) {
  for (const char* normal : {"[1, 0, 0]", "[1, 0.2, -0.1]", "[3, 1, 1]"}) {
    const Bar bar("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"0.5 mm\", \"0.2 mm\", 0]\n",
                  {2.5, 3, 4.2, 5, 7.5}, "", normal);
    Vec3 pull{};
    for (std::size_t i = 0; i < bar.answer.reaction.size(); ++i)
      if (const Prescribed& p = bar.read.scene.prescribed[i]; !p.held)
        pull[static_cast<std::size_t>(p.component)] += bar.answer.reaction[i];
    EXPECT_GT(pull[0], 1e-3);
    for (const MeasuredValue& value : bar.values)
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_NEAR((*value.vector)[a], pull[a], 1e-9 * pull[0]) << normal;
  }
}

// Truth: the weight of what hangs below the plane; a part of a cell weighs its part.
TEST(SectionAnalytic, AHangingBarCarriesTheWeightBeyond) {
  const std::vector<double> places{0.3, 1, 2.5, 4, 6.75, 9.9};
  const Bar bar("[[hold]]\nwhere = \"x-\"\n[[load]]\ngravity = [9.81, 0, 0]\n", places,
                "component = \"normal\"\n");
  const double weight = 1200 * 9.81 * 160e-9;
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_NEAR(*bar.values[i].value, weight * (10 - places[i]) / 10, 1e-9 * weight) << places[i];
}

// Truth: equilibrium from the other side: what lies before the plane is in balance, too, so that the normal
// turned round gives the opposite force. Both sums share no node and no cell but those that are cut.
TEST(SectionIndependent, BothSidesOfAPlaneAgree) {
  const std::string conditions =
      "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [0, 0, \"1 mm\"]\n[[load]]\ngravity = [0, "
      "-9.81, 4]\n[[load]]\nwhere = \"y+\"\ntraction = [\"10 Pa\", \"-30 Pa\", \"5 Pa\"]\n";
  const std::vector<double> places{2.4, 5.3, 7.1};
  const Bar one(conditions, places, "", "[2, 1, -1]"), other(conditions, places, "", "[-2, -1, 1]");
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR((*one.values[i].vector)[a], -(*other.values[i].vector)[a], 1e-8 * *one.values[i].value);
}

// Truth: held ends of a contracting bar carry the force of its fibres, across every plane.
TEST(SectionAnalytic, AContractingBarPullsAcrossEveryPlane) {
  const Bar bar("[[hold]]\nwhere = \"x-\"\n[[hold]]\nwhere = \"x+\"\n[[load]]\ncontraction = \"1 kPa\"\n",
                {2.5, 4, 6.1}, "component = \"x\"\n");
  double end = 0;
  for (std::size_t i = 0; i < bar.answer.reaction.size(); ++i)
    if (const Prescribed& p = bar.read.scene.prescribed[i];
        p.component == 0 && bar.read.scene.specimen.grid.node_at(p.node)[0] == 10)
      end += bar.answer.reaction[i];
  EXPECT_GT(end, 1e-3);
  for (const MeasuredValue& value : bar.values)
    EXPECT_NEAR(*value.value, end, 1e-8 * end);
}

} // namespace
} // namespace maille
