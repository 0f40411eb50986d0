/// What a study file may say, and what it is told when it says something else.

#include "maille/scene/read_scene.hpp"
#include "studies/study/study_scenes.hpp"
#include "study/plan/formula.hpp"
#include "study/plan/sampling.hpp"
#include "study/plan/study.hpp"
#include "support/kit.hpp"

#include <sys/stat.h>

namespace maille::studies {
namespace {

using test::parameter;

class StudyFileContract : public testing::Test {
protected:
  StudyFile parse(const std::string& text) const { return parse_study(text, folder / "study.toml"); }
  /// The faults of a text, each as `line key expected found`.
  std::string faults(const std::string& text) const {
    const auto found = test::faults_found_by([&] { parse(text); });
    return found.empty() ? "none" : InputError(found).what();
  }
  void expect_fault(const std::string& text, const std::string& at, const std::string& words) const {
    const std::string found = faults(text);
    EXPECT_TRUE(test::has(found, at));
    EXPECT_TRUE(test::has(found, words));
  }
  const test::StudyFolder folder;
  const std::string head = test::small_head;
};

TEST_F(StudyFileContract, SaysWhatItIsToldTo) {
  const StudyFile study =
      parse(head + "title = \"t\"\nrepetitions = 3\nvtk = [2]\n" +
            parameter("specimen.material.E_fibre", "label = \"E\"\nvalues = [\"10 kPa\", \"20 kPa\"]") +
            parameter("move.0.by.0", "range = [\"0.1 mm\", \"0.4 mm\"]\ncount = 4"));
  EXPECT_EQ(study.title, "t");
  EXPECT_EQ(study.row_methods(), (std::vector<std::string>{"limits", "relaxed", "fem_q1"}));
  EXPECT_EQ(study.parameters[0].column(), "E [kPa]");
  EXPECT_EQ(study.parameters[1].column(), "move.0.by.0 [mm]");
  EXPECT_TRUE(study.wants_vtk(2) && !study.wants_vtk(1));
  EXPECT_EQ(study.repetitions, 3);
}

TEST_F(StudyFileContract, EveryFaultIsReportedAtOnceWithItsLine) {
  const std::string text = "scene = \"strip.toml\"\nmethods = [\"limits\", \"magic\"]\ncombin = \"grid\"\n" +
                           parameter("specimen.material.E_fiber", "values = [1]") +
                           parameter("move.0.by.0", "range = [\"1 mm\", \"2 cm\"]\ncount = 2");
  const std::string found = faults(text);
  for (const char* part :
       {"study.toml:2: methods", "\"magic\"", "study.toml:3: combin", "did you mean",
        "study.toml:5: parameter[1].key", "specimen.material.E_fiber", "study.toml:9: parameter[2].range"})
    EXPECT_TRUE(test::has(found, part));
}

TEST_F(StudyFileContract, KeysThatASceneLacksAreFaults) {
  expect_fault(head + parameter("move.1.by", "values = [0]"), "study.toml:5", "it has only move");
  expect_fault(head + parameter("nothing", "values = [0]"), "study.toml:5", "it has nothing");
  expect_fault(head + parameter("move.0.by.0", "values = [0]") + parameter("move.0.by", "values = [0]"),
               "parameter[2].key", "every key of the scene once");
  expect_fault(head + parameter("move[1].by[1]", "values = [0]") + parameter("move.0.by", "values = [0]"),
               "parameter[2].key", "every key of the scene once");
  expect_fault(head + parameter("move[0].by", "values = [0]"), "parameter[1].key", "counted from 1");
  expect_fault(head + parameter("move[1].be", "values = [0]"), "parameter[1].key", "it has only move[1]");
  EXPECT_EQ(faults(head + parameter("move[1].by[1]", "values = [0]")), "none");
}

TEST_F(StudyFileContract, WrongFormsAreFaults) {
  const std::string key = "move.0.by.0";
  expect_fault(head + parameter(key, "values = []"), "parameter[1].values", "a list of values");
  expect_fault(head + parameter(key, "values = [\"1 mm\", \"1 cm\"]"), "parameter[1].values", "one unit");
  expect_fault(head + parameter(key, "log_range = [0, 1]\ncount = 3"), "parameter[1].log_range", "> 0");
  expect_fault(head + parameter(key, "range = [0, 1]"), "parameter[1].count", "found nothing");
  expect_fault(head + parameter(key, "range = [0, 1]\nvalues = [1]"), "parameter[1].range", "one of values");
  expect_fault(head + parameter(key, ""), "parameter[1]", "one of values");
  expect_fault(head + parameter(key, "values = [0]\ncount = 2"), "parameter[1].count", "no count");
  expect_fault(head + "combine = \"sobol\"\n", "samples", "number of cases");
  expect_fault(head + "samples = 4\n", "study.toml:4: samples", "no such key unless");
  expect_fault(head + "seed = 4\n", "study.toml:4: seed", "no such key unless");
  expect_fault(head + "vtk = [1, 2]\n", "study.toml:4: vtk", "1 to 1");
  expect_fault(head + "combine = \"zip\"\n" + parameter(key, "values = [0, 1]") +
                   parameter("specimen.fibre.angle", "values = [0]"),
               "parameter", "zipped");
  expect_fault("methods = [\"limits\"]\n", "scene", "found nothing");
}

// A study of some hundred bytes must not take gigabytes.
TEST_F(StudyFileContract, ValuesAreCountedBeforeTheyAreMade) {
  const std::string million = "range = [0, 1]\ncount = 1000000";
  expect_fault(head + "combine = \"zip\"\n" + parameter("move.0.by.0", million) +
                   parameter("specimen.fibre.angle", million),
               "parameter[2].count", "from 1 to 1");
  std::string many = head + "combine = \"sobol\"\nsamples = 1000000\n";
  for (const char* key : {"E_fibre", "E_cross", "G_fibre", "nu_fibre", "nu_cross"})
    many += parameter(std::string("specimen.material.") + key, "range = [0.1, 0.2]");
  for (const char* key : {"move.0.by.0", "move.0.by.1", "specimen.fibre.angle", "specimen.spacing",
                          "hold.0.where", "move.0.where"})
    many += parameter(key, "range = [0.1, 0.2]");
  expect_fault(many, "parameter", "at most 1e+07 values");
}

// Between them are numbers that no machine has, and their rows would have no values.
TEST_F(StudyFileContract, RangesThatOverflowAreFaults) {
  const std::string key = "move.0.by.0";
  for (const char* ends : {"[1e-300, 1e300]", "[1e300, 1e-300]"})
    expect_fault(head + parameter(key, std::string("log_range = ") + ends + "\ncount = 3"),
                 "parameter[1].log_range", "ratio");
  expect_fault(head + parameter(key, "range = [-1e308, 1e308]\ncount = 3"), "parameter[1].range",
               "difference");
  EXPECT_EQ(faults(head + parameter(key, "log_range = [1e-150, 1e150]\ncount = 3")), "none");
}

TEST_F(StudyFileContract, APipeIsNoScene) {
  ASSERT_EQ(mkfifo((folder / "pipe.toml").c_str(), 0600), 0);
  expect_fault("scene = \"pipe.toml\"\nmethods = [\"limits\"]\n", "study.toml:1: scene",
               "a pipe or a device");
}

TEST_F(StudyFileContract, LabelsAreColumnsOfTheirOwn) {
  const std::string key = "move.0.by.0", values = "\nvalues = [0]";
  expect_fault(head + parameter(key, "label = \"\"" + values), "parameter[1].label", "printable");
  expect_fault(head + parameter(key, "label = \"a\\u0001b\"" + values), "parameter[1].label", "printable");
  expect_fault(head + parameter(key, "label = \"method\"" + values), "parameter[1].label",
               "no other column's");
}

// A list of two megabytes took gigabytes before it was refused: every scene of it was read.
TEST_F(StudyFileContract, NamesOfScenesAreLookedAtBeforeTheScenes) {
  folder.write("faulty.toml", "[specimen]\nshape = \"box\"\n");
  const std::string found = faults("scene = [\"faulty.toml\", \"faulty.toml\"]\nmethods = [\"limits\"]\n");
  EXPECT_TRUE(test::has(found, "faulty twice"));
  EXPECT_FALSE(test::has(found, "cells")) << "the scene is not read: " << found;
  std::string many = "methods = [\"limits\"]\nscene = [\"strip.toml\"";
  for (int i = 0; i < 20'000; ++i)
    many += ", \"strip.toml\"";
  expect_fault(many + "]\n", "study.toml:2: scene", "at most 10000 scenes");
}

TEST_F(StudyFileContract, ScenesOutsideOfTheStudysFolderAreRefusedInASandbox) {
  struct Sandbox {
    Sandbox() { set_file_scope(FileScope::sandbox); }
    ~Sandbox() { set_file_scope(FileScope::anywhere); }
  } const sandbox;
  for (const std::string name :
       {"../strip.toml", "a/../strip.toml", "/strip.toml", "$MAILLE_NONE/strip.toml"})
    expect_fault("scene = \"" + name + "\"\nmethods = [\"limits\"]\n", "study.toml:1: scene", name);
}

TEST_F(StudyFileContract, FaultsOfScenesAreReportedToo) {
  folder.write("faulty.toml", "[specimen]\nshape = \"box\"\n");
  expect_fault("scene = [\"strip.toml\", \"faulty.toml\"]\nmethods = [\"magic\"]\n", "faulty.toml:1",
               "cells");
  expect_fault("scene = \"none.toml\"\nmethods = [\"limits\"]\n", "none.toml", "can be read");
}

TEST_F(StudyFileContract, ValuesStandInTheSceneWhereTheKeysSay) {
  const StudyFile study =
      parse(head + "combine = \"zip\"\n" + parameter("move.0.by", "values = [[\"1 mm\", 0], [0, \"2 mm\"]]") +
            "[[parameter]]\nkey = [\"specimen.material.nu_fibre\", \"specimen.material.nu_cross\"]\n"
            "values = [0.1, 0.2]\n");
  const auto all = cases(study);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(std::get<double>(all[1].values[1].shown), 0.2);
  const std::string text = resolved_scene(study, all[1]);
  EXPECT_TRUE(test::has(text, "nu_fibre = 0.2"));
  EXPECT_TRUE(test::has(text, "nu_cross = 0.2"));
  EXPECT_TRUE(test::has(text, "2 mm"));
}

TEST_F(StudyFileContract, HashesTellScenesMethodsAndFilesApart) {
  folder.write("stuff.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  folder.write("named.toml", "[specimen]\nshape = \"box\"\ncells = [2, 2]\nspacing = \"1 mm\"\nmaterial = "
                             "\"stuff.toml\"\n[[hold]]\nwhere = \"x-\"\n");
  const StudyFile study = parse("scene = \"named.toml\"\nmethods = [\"limits\"]\n" +
                                parameter("specimen.spacing", "values = [\"1 mm\", \"2 mm\", \"1 mm\"]"));
  const auto all = cases(study);
  const auto hash = [&](std::size_t i, const char* method, const char* settings = "") {
    return CaseHashes(study, settings).of_case(all[i], {method}).front();
  };
  const std::set<std::string> different{hash(0, "limits"), hash(1, "limits"), hash(0, "relaxed"),
                                        hash(0, "limits", "2 threads")};
  EXPECT_EQ(different.size(), 4u);
  EXPECT_EQ(hash(0, "limits"), hash(2, "limits")) << "the same scene is the same row";
  EXPECT_EQ(hash(0, "limits").size(), 64u);
  const std::string before = hash(0, "limits");
  folder.write("stuff.toml", "youngs_modulus = \"11 kPa\"\npoisson_ratio = 0.3\n");
  EXPECT_NE(hash(0, "limits"), before) << "what a scene names counts";
}

/// How many cases a plan has, and where they are.

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

TEST(StudyPlanAnalytic, SaltellisBlocksMixTwoPoints) {
  const UnitPoints points = saltelli_points(8, 3);
  ASSERT_EQ(points.size(), 8u * 5);
  for (std::size_t first = 0; first < points.size(); first += 5)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t d = 0; d < 3; ++d)
        EXPECT_EQ(points[first + 2 + axis][d], points[first + (d == axis ? 1 : 0)][d]);
}

TEST(FormulaAnalytic, HasTheUsualPrecedence) {
  const NamedNumbers known{{"a", 2}, {"move[1].by", 3}};
  for (const auto& [formula, value] : {std::pair{"a + move[1].by * a", 8.0},
                                       {"-a ^ 2", -4.0},
                                       {"2 ^ 3 ^ a / (1 + 1)", 256.0},
                                       {" ( a-1 ) - 1e-1 ", 0.9},
                                       {"8 / a / a", 2.0},
                                       {"+a - -a", 4.0}})
    EXPECT_DOUBLE_EQ(value_of_formula(formula, known), value) << formula;
  for (const std::string& formula :
       std::vector<std::string>{"", "a +", "b", "(a", "a a", "1..2", "a)", "*", "nan", "inf",
                                std::string(200, '('), std::string(999, '-')})
    EXPECT_THROW((void)value_of_formula(formula, known), std::invalid_argument) << formula;
}

// Analytic: quartiles of a normal variable are 0.6745 deviations from its mean.
TEST_F(StudyFileContract, DistributionsAreDrawnByTheirQuantiles) {
  const auto law = [&](const std::string& text,
                       const std::string& plan = "combine = \"sobol\"\nsamples = 4\n") {
    return head + plan + parameter("specimen.material.E_fibre", "values = \"" + text + "\"");
  };
  const StudyFile normal = parse(law("normal(20 kPa, 4 kPa)")), other = parse(law("lognormal(20 kPa, 2)"));
  constexpr double quartile = 0.674489750196; // Sobol's second to fourth points: 1/2, 3/4, 1/4
  const auto all = cases(normal), logs = cases(other);
  EXPECT_EQ(all[1].values[0].toml, "\"20 kPa\"");
  EXPECT_NEAR(shown(all[2], 0), 20 + 4 * quartile, 1e-9);
  EXPECT_NEAR(shown(logs[3], 0), 20 * std::exp2(-quartile), 1e-9);
  EXPECT_GT(shown(all[0], 0), 20 - 4 * 4) << "the first point is 0, and no case is infinite";
  for (const char* text : {"normal(20 kPa, 4)", "normal(20 kPa, -4 kPa)", "normal(20 kPa)",
                           "lognormal(0 kPa, 2)", "lognormal(20 kPa, 1)", "normal(a, b)"})
    expect_fault(law(text), "parameter[1].values", "normal(mean, deviation) in one unit");
  expect_fault(law("normal(20 kPa, 4 kPa)", ""), "parameter[1].values", "alone draw distributions");
}

TEST_F(StudyFileContract, FormulasFollowFromParameters) {
  const std::string fibre = "specimen.material.E_fibre",
                    ratio = "[[parameter]]\nlabel = \"ratio\"\nvalues = [1, 4]\n",
                    cross = parameter("specimen.material.E_cross",
                                      "label = \"E\"\nvalues = [\"5 kPa\", \"8 kPa\"]");
  const StudyFile study = parse(head + cross + ratio + parameter(fibre, "values = \"E * ratio\""));
  const auto all = cases(study);
  ASSERT_EQ(all.size(), 4u) << "formulas make no cases";
  EXPECT_EQ(study.formulas[0].column(), "specimen.material.E_fibre [kPa]");
  EXPECT_EQ(all[3].values[2].toml, "\"32 kPa\"");
  EXPECT_TRUE(test::has(resolved_scene(study, all[1]), "E_fibre = '20 kPa'"));
  expect_fault(head + cross + ratio, "parameter", "a key, or a formula that names the parameter");
  expect_fault(head + parameter(fibre, "values = \"E * 2\"") + cross, "parameter[1].values",
               "\"E\", which is none");
  expect_fault(head + cross + parameter(fibre, "values = \"E *\""), "parameter[2].values",
               "the end in place of");
}

} // namespace
} // namespace maille::studies
