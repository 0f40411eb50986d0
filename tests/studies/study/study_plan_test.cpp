/// How many cases a plan has, and where they are.

#include "studies/study/study_scenes.hpp"
#include "study/plan/sampling.hpp"
#include "study/plan/study.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace maille::studies {
namespace {

using test::parameter;

const std::string moves = parameter("move.0.by.0", "values = [\"1 mm\", \"2 mm\", \"3 mm\"]");

std::vector<StudyCase> cases_of(const std::string& text) {
  const test::StudyFolder folder;
  folder.write("strip_two.toml", test::small_strip);
  return cases(parse_study(text, folder / "study.toml"));
}

double shown(const StudyCase& one, std::size_t parameter) {
  return std::get<double>(one.values[parameter].shown);
}

TEST(StudyPlanAnalytic, GridsAreProductsWithTheLastParameterFastest) {
  const auto all = cases_of("scene = [\"strip.toml\", \"strip_two.toml\"]\nmethods = [\"limits\"]\n" + moves +
                            parameter("specimen.fibre.angle", "range = [\"0 deg\", \"45 deg\"]\ncount = 4"));
  ASSERT_EQ(all.size(), 2u * 3 * 4);
  EXPECT_EQ(shown(all[0], 1), 0);
  EXPECT_EQ(shown(all[1], 1), 15);
  EXPECT_EQ(shown(all[3], 1), 45);
  EXPECT_EQ(shown(all[4], 0), 2);
  EXPECT_EQ(all[12].scene, 1u);
  EXPECT_EQ(all[12].number, 13);
  EXPECT_EQ(cases_of(test::small_head).size(), 1u) << "nothing varies";
}

TEST(StudyPlanAnalytic, ZippedParametersGoTogether) {
  const auto all =
      cases_of(test::small_head + "combine = \"zip\"\n" + moves +
               parameter("specimen.material.E_fibre", "log_range = [\"1 kPa\", \"100 kPa\"]\ncount = 3"));
  ASSERT_EQ(all.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(shown(all[i], 0), static_cast<double>(i) + 1);
    EXPECT_EQ(shown(all[i], 1), std::pow(10.0, static_cast<double>(i))); // equal factors, twelve digits
  }
}

TEST(StudyPlanAnalytic, LatinHypercubesHaveOnePointInEverySlice) {
  for (const int n : {1, 7, 49, 200}) {
    const UnitPoints points = latin_hypercube(n, 3, 5);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(n));
    for (std::size_t d = 0; d < 3; ++d) {
      std::set<int> slices;
      for (const auto& point : points)
        slices.insert(static_cast<int>(std::floor(point[d] * n)));
      EXPECT_EQ(slices.size(), static_cast<std::size_t>(n));
      EXPECT_EQ(*slices.begin(), 0);
      EXPECT_EQ(*slices.rbegin(), n - 1);
    }
  }
  EXPECT_EQ(latin_hypercube(9, 2, 5), latin_hypercube(9, 2, 5));
  EXPECT_NE(latin_hypercube(9, 2, 5), latin_hypercube(9, 2, 6));
}

TEST(StudyPlanAnalytic, SobolPointsAreThoseOfJoeAndKuo) {
  // The first ten points in three dimensions that Joe and Kuo 2008 print beside their directions.
  const UnitPoints expected{{0, 0, 0},
                            {0.5, 0.5, 0.5},
                            {0.75, 0.25, 0.25},
                            {0.25, 0.75, 0.75},
                            {0.375, 0.375, 0.625},
                            {0.875, 0.875, 0.125},
                            {0.625, 0.125, 0.875},
                            {0.125, 0.625, 0.375},
                            {0.1875, 0.3125, 0.9375},
                            {0.6875, 0.8125, 0.4375}};
  EXPECT_EQ(sobol_points(10, 3), expected);
}

TEST(StudyPlanAnalytic, DrawnPlansUseRangesAndLists) {
  const auto all = cases_of(test::small_head + "combine = \"sobol\"\nsamples = 8\n" +
                            parameter("specimen.material.E_fibre", "log_range = [\"1 kPa\", \"10000 kPa\"]") +
                            parameter("move.0.by.0", "values = [\"1 mm\", \"2 mm\"]"));
  ASSERT_EQ(all.size(), 8u);
  EXPECT_EQ(shown(all[0], 0), 1);    // u = 0
  EXPECT_EQ(shown(all[1], 0), 100);  // u = 1/2
  EXPECT_EQ(shown(all[2], 0), 1000); // u = 3/4
  int ones = 0;
  for (const StudyCase& one : all)
    ones += shown(one, 1) == 1;
  EXPECT_EQ(ones, 4) << "2^3 points are spread evenly over two values";
}

} // namespace
} // namespace maille::studies
