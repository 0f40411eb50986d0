// Geometric multigrid against a factor, and what is kept from one scene to the next.
#include "fem_ref/bodies.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using fem_ref::LinearSolver;
using test::options_of;

/// A box of slanted fibres, held below, moved in a patch and at single nodes, pulled and weighed down.
Scene fibrous_box(int dimension, const Index3& cells) {
  Scene scene = test::box_scene(dimension, cells, {1e-3, 1.2e-3, 0.8e-3});
  scene.materials = {test::material_of(test::fibrous())};
  scene.specimen.fibre = test::slanted_fibre(dimension);
  test::hold_face(scene, 0, false);
  const Grid& grid = scene.specimen.grid;
  const int top = dimension == 3 ? cells[2] : 0;
  for (int c = 0; c < dimension; ++c)
    for (const Index3& at : {Index3{cells[0], cells[1], top}, Index3{cells[0] - 1, cells[1], top},
                             Index3{cells[0] / 2, 1, top / 2}})
      scene.prescribed.push_back({grid.node(at), c, 1e-4 * (c + 1), false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  test::pull_face(scene, 1, true, {20, 30, -10});
  scene.gravity = {0, -9.81, 0};
  return scene;
}

// Truth: the same equations by a Cholesky factor.
TEST(MultigridOracle, GivesTheFactorsAnswer) {
  const std::pair<int, Index3> bodies[] = {{2, {24, 16, 1}}, {3, {12, 8, 8}}, {3, {20, 4, 12}}};
  for (const auto& [dimension, cells] : bodies)
    for (const int degree : {1, 2}) {
      const Scene scene = fibrous_box(dimension, cells);
      const Answer truth = fem_ref::solve(scene, options_of(degree, LinearSolver::cholmod)).answer;
      ASSERT_EQ(truth.status, Status::done) << truth.message;
      SCOPED_TRACE(fmt::format("{}D Q{}", dimension, degree));
      const Answer answer = fem_ref::solve(scene, options_of(degree, LinearSolver::gmg)).answer;
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      EXPECT_LT(test::largest_difference(truth.displacement, answer.displacement),
                1e-8 * test::largest(truth.displacement));
      EXPECT_LT(answer.residual, 1e-10);
      // Fibres ten times stiffer and slanted take 47 with quadratic elements; CG alone takes hundreds.
      EXPECT_LT(answer.iterations, 60);
      EXPECT_NEAR(*answer.strain_energy, *truth.strain_energy, 1e-8 * *truth.strain_energy);
    }
}

TEST(MultigridContract, RefusesBodiesWithoutHierarchy) {
  const auto message = [](const Scene& scene) {
    const Answer answer = fem_ref::solve(scene, options_of(1, LinearSolver::gmg)).answer;
    EXPECT_EQ(answer.status, Status::refused);
    return answer.message;
  };
  EXPECT_EQ(message(fibrous_box(2, {8, 7, 1})),
            "no geometric multigrid: an odd number of cells cannot be halved");
  Scene carved = fibrous_box(2, {8, 8, 1});
  carved.specimen.material_id.assign(64, 0);
  carved.specimen.material_id[40] = no_material;
  EXPECT_EQ(message(carved), "no geometric multigrid: the body is not a box");
  carved.specimen.material_id[40] = 1;
  carved.materials.push_back(carved.materials.front());
  EXPECT_EQ(message(carved), "no geometric multigrid: the body is of more than one material");
}

// Oracle: every scene solved by itself. What iterates goes on with the vectors that it has, which shows in
// its last bits.
TEST(KeptSolverOracle, OtherLoadsAndValuesGetTheirOwnAnswers) {
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg, LinearSolver::gmg}) {
    const bool iterates = solver == LinearSolver::cg_amg || solver == LinearSolver::gmg;
    fem_ref::Solver kept(options_of(1, solver));
    Scene scene = fibrous_box(3, {8, 4, 4});
    const auto compare = [&](const char* what) {
      SCOPED_TRACE(fmt::format("solver {}, {}", static_cast<int>(solver), what));
      const Answer answer = kept.solve(scene).answer,
                   alone = fem_ref::solve(scene, options_of(1, solver)).answer;
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      const double least = iterates ? 1e-9 : 0;
      EXPECT_LE(test::largest_difference(answer.displacement, alone.displacement),
                least * test::largest(alone.displacement));
      EXPECT_NEAR(*answer.strain_energy, *alone.strain_energy, least * *alone.strain_energy);
      EXPECT_TRUE(answer.reaction == alone.reaction || iterates);
    };
    compare("the first");
    for (Prescribed& p : scene.prescribed)
      p.value *= 1.5;
    scene.gravity[2] += 3;
    compare("other values and loads");
    compare("the same again");
    scene.prescribed.erase(scene.prescribed.begin() + 2);
    compare("another matrix");
    scene.materials = {test::material_of(ElasticConstants::isotropic(5e3, 0.4))};
    compare("another material");
  }
}

// What is kept is seen in the progress that is reported: a second scene assembles nothing.
TEST(KeptSolverContract, TheSecondSceneSetsNothingUp) {
  fem_ref::Solver kept(options_of(1, LinearSolver::cholmod));
  Scene scene = fibrous_box(3, {8, 4, 4});
  std::vector<std::string> reported;
  Control control;
  control.progress = [&](double, std::string_view what) { reported.emplace_back(what); };
  kept.solve(scene, control);
  EXPECT_EQ(std::ranges::count(reported, "factorising"), 1);
  scene.gravity[0] = 4;
  reported.clear();
  kept.solve(scene, control);
  EXPECT_EQ(reported, std::vector<std::string>{"done"});
}

} // namespace
} // namespace maille
