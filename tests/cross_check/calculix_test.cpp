/// fem_q1 against CalculiX, which shares no code with deal.II or with us. Its C3D8 (ccx 2.20) is the same
/// mathematics as Q1, so what may differ is what it prints: seven digits of each displacement.

#include "export/calculix/calculix.hpp"
#include "fem_ref/bodies.hpp"
#include "maille/scene/read_scene.hpp"

#include "support/kit.hpp"

#include <chrono>

namespace maille::studies {
namespace {

struct Case {
  const char* name;
  std::string text;
};

void PrintTo(const Case& question, std::ostream* out) {
  *out << question.name;
}

/// A box with one face held, whose other end is moved or loaded.
std::string box(const std::string& specimen, const std::string& conditions) {
  return "[specimen]\nshape = \"box\"\nspacing = [\"1 mm\", \"0.8 mm\", \"1.1 mm\"]\n" + specimen +
         "\n[[hold]]\nwhere = \"x-\"\n" + conditions;
}

const std::string isotropic =
    "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.45, density = 1050 }\n";
const std::string transverse =
    "material = { E_fibre = \"100 kPa\", E_cross = \"10 kPa\", G_fibre = \"7 kPa\", nu_fibre = "
    "0.3, nu_cross = 0.4 }\n";
const std::string orthotropic =
    "material = { E = [\"50 kPa\", \"20 kPa\", \"10 kPa\"], nu = [0.3, 0.25, 0.35], "
    "G = [\"12 kPa\", \"9 kPa\", \"5 kPa\"] }\n";
const std::string cells_3d = "cells = [6, 4, 3]\n", cells_2d = "cells = [8, 5]\n";
const std::string skew = "fibre = [0.8, 0.5, 0.3]\n";
const std::string moved = "[[move]]\nwhere = \"x+\"\nby = [\"0.4 mm\", \"0.2 mm\", \"-0.1 mm\"]\n";
const std::string moved_in_plane = "[[move]]\nwhere = \"x+\"\nby = [\"0.4 mm\", \"0.2 mm\"]\n";
const std::string pulled = "[[load]]\nwhere = \"x+\"\ntraction = [\"1 kPa\", \"0.3 kPa\", \"-0.2 kPa\"]\n";
const std::string pulled_in_plane = "[[load]]\nwhere = \"x+\"\ntraction = [\"1 kPa\", \"0.3 kPa\"]\n";
const std::string contracting = "[[load]]\ncontraction = \"1 kPa\"\n";
const std::string heavy = "[[load]]\ngravity = [0, 0, -9.81]\n";

std::vector<Case> cases() {
  return {{"isotropic_moved", box(cells_3d + isotropic, moved)},
          {"isotropic_pulled", box(cells_3d + isotropic, pulled)},
          {"isotropic_heavy", box(cells_3d + isotropic, heavy)},
          {"transverse_along_the_grid", box(cells_3d + transverse, moved)},
          {"transverse_turned", box(cells_3d + transverse + skew, pulled)},
          {"orthotropic", box(cells_3d + orthotropic, moved)},
          {"orthotropic_turned", box(cells_3d + orthotropic + skew, pulled)},
          {"nearly_incompressible",
           box(cells_3d + "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.499 }\n", pulled)},
          {"plane_strain", box(cells_2d + isotropic, pulled_in_plane)},
          {"plane_strain_turned", box(cells_2d + transverse + "fibre = [0.8, 0.6, 0]\n", moved_in_plane)},
          {"plane_stress", box(cells_2d + isotropic + "plane = \"stress\"\n", pulled_in_plane)},
          {"plane_stress_turned",
           box(cells_2d + transverse + "plane = \"stress\"\nfibre = [0.8, 0.6, 0]\n", moved_in_plane)},
          {"contraction", box(cells_3d + transverse + skew, contracting)},
          {"contraction_in_plane_stress",
           box(cells_2d + transverse + "plane = \"stress\"\nfibre = [0.6, 0.48, 0.64]\n", contracting)},
          {"bar", box("cells = [9]\n" + transverse, "[[load]]\nwhere = \"x+\"\ntraction = [\"1 kPa\"]\n")},
          // Several materials, fibres that turn from cell to cell, and a body that does not fill its grid.
          {"muscle_belly", "[specimen]\nshape = \"muscle\"\ncells = [16, 8, 8]\nspacing = \"2 mm\"\n"
                           "material = \"muscle/vastus_lateralis\"\n"
                           "tendon = { material = \"tendon/tibialis_anterior\", fraction = 0.15 }\n"
                           "fibre = { angle = \"20 deg\", plane = \"xz\" }\n"
                           "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n"}};
}

class CalculixIndependent : public testing::TestWithParam<Case> {};

TEST_P(CalculixIndependent, AgreesWithLinearElementsNodeByNode) {
  if (!has_calculix())
    GTEST_SKIP() << "there is no ccx on this machine: install calculix-ccx";
  const Scene scene = parse_scene(GetParam().text, "scene.toml");
  const Answer theirs = solve_by_calculix(scene);
  ASSERT_EQ(theirs.status, Status::done) << theirs.message;
  fem_ref::Options options;
  options.solver = fem_ref::LinearSolver::cholmod;
  const Answer ours = test::solved(scene, options).answer;
  // Half a unit in the seventh digit is 5e-7 of a displacement at most; sums of its solver the same again.
  EXPECT_LE(test::largest_difference(theirs.displacement, ours.displacement),
            1e-6 * test::largest(ours.displacement));
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, CalculixIndependent, testing::ValuesIn(cases()),
                         [](const auto& question) { return std::string(question.param.name); });

// Truth: fem_q1, by laws that differ in their energy of volume alone: by (J - 1)^3 where J is near 1. A deck
// of small strain is off by a quarter.
TEST(CalculixFiniteIndependent, TwistsBySixtyDegrees) {
  if (!has_calculix())
    GTEST_SKIP() << "there is no ccx on this machine: install calculix-ccx";
  for (const std::string law : {"neo_hookean\", E = 1e4, nu = 0.3 }\n",
                                "mooney_rivlin\", parameters = { c1 = 2e3, c2 = 1e3, k = 1e4 } }\n"}) {
    const Scene scene =
        parse_scene("strain = \"finite\"\n" +
                        box("cells = [12, 4, 4]\nmaterial = { law = \"" + law,
                            "[[move]]\nwhere = \"x+\"\nturn = { angle = \"60 deg\", axis = [1, 0, 0] }\n"),
                    "scene.toml");
    const Answer theirs = solve_by_calculix(scene), ours = test::solved(scene, test::options_of(1)).answer;
    ASSERT_EQ(theirs.status, Status::done) << theirs.message;
    EXPECT_LE(compare(scene, theirs.displacement, ours.displacement).relative_l2, 5e-3);
  }
}

TEST(CalculixDeckContract, FieldsAreShortEnoughToBeReadWhole) {
  for (const Case& question : cases()) {
    std::istringstream deck(calculix_deck(parse_scene(question.text, "scene.toml")));
    for (std::string line; std::getline(deck, line);) {
      if (line.starts_with("*"))
        continue;
      std::istringstream fields(line);
      for (std::string field; std::getline(fields, field, ',');)
        ASSERT_LE(field.size(), 20u) << question.name << ": " << line;
    }
  }
}

TEST(CalculixResultContract, AMissingNodeIsSaid) {
  const Scene scene = parse_scene(cases()[0].text, "scene.toml");
  std::istringstream printed(" displacements (vx,vy,vz) for set BODY and time  0.1E+01\n\n 1 0.1E-3 0 0\n");
  try {
    read_calculix_displacement(scene, printed);
    FAIL() << "nothing was said";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "CalculiX printed no displacement of node 2");
  }
}

/// Puts a folder before all others on PATH, or makes it the only one, for as long as it lives.
class PathInstead {
public:
  PathInstead(const std::string& folder, bool is_only) : before_(std::getenv("PATH")) {
    setenv("PATH", is_only ? folder.c_str() : (folder + ":" + before_).c_str(), 1);
  }
  ~PathInstead() { setenv("PATH", before_.c_str(), 1); }
  PathInstead(const PathInstead&) = delete;
  PathInstead& operator=(const PathInstead&) = delete;

private:
  std::string before_;
};

TEST(CalculixContract, AnErrorIsAFailureInItsWordsThoughItEndsWithZero) {
  const test::TemporaryFolder folder;
  const auto script =
      folder.write("ccx", "#!/bin/sh\necho ' *ERROR in linstatic: the matrix is odd'\nexit 0\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const PathInstead path(folder.path().string(), false);
  const Answer answer = solve_by_calculix(parse_scene(cases()[0].text, "scene.toml"));
  EXPECT_EQ(answer.status, Status::failed);
  EXPECT_TRUE(test::has(answer.message, "the matrix is odd"));
}

TEST(CalculixContract, WithoutTheProgramItIsRefused) {
  const test::TemporaryFolder folder;
  const PathInstead path(folder.path().string(), true);
  const Answer answer = solve_by_calculix(parse_scene(cases()[0].text, "scene.toml"));
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_TRUE(test::has(answer.message, "calculix-ccx"));
}

TEST(CalculixContract, CellsTooSmallForItAreRefused) {
  if (!has_calculix())
    GTEST_SKIP() << "no ccx";
  Scene scene = test::box_scene(3, {2, 2, 2}, {1e-9, 1e-9, 1e-9});
  test::hold_face(scene, 0, false);
  test::prescribe_face(scene, 0, true, 0, 1e-10, false);
  const Answer answer = solve_by_calculix(scene);
  EXPECT_EQ(answer.status, Status::refused) << answer.message;
  EXPECT_TRUE(test::has(answer.message, "micrometre"));
}

TEST(CalculixContract, ItIsEndedOnDemand) {
  if (!has_calculix())
    GTEST_SKIP() << "no ccx";
  Scene scene = test::box_scene(3, {24, 24, 24});
  test::hold_face(scene, 0, false);
  test::prescribe_face(scene, 0, true, 0, 1e-4, false);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  Control control;
  control.stop_requested = [&] { return seconds() > 0.5; };
  const Answer answer = solve_by_calculix(scene, control);
  EXPECT_EQ(answer.status, Status::interrupted) << answer.message;
  EXPECT_LT(seconds(), 0.5 + 1);
}

} // namespace
} // namespace maille::studies
