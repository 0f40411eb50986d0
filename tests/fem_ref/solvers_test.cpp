// The linear solvers, and what a caller may ask of a running one.

#include "fem_ref/bodies.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "support/kit.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

namespace maille {
namespace {

using fem_ref::LinearSolver;
using test::options_of;

/// A carved block of two kinds of matter with slanted fibres, held, moved, pulled and weighed down.
Scene rich_scene(int dimension) {
  const Index3 cells = dimension == 1   ? Index3{40, 1, 1}
                       : dimension == 2 ? Index3{20, 12, 1}
                                        : Index3{10, 6, 5};
  Scene scene = test::box_scene(dimension, cells, {1e-3, 1.2e-3, 0.8e-3});
  scene.materials = {test::material_of(test::fibrous()),
                     test::material_of(ElasticConstants::isotropic(5e3, 0.4))};
  scene.specimen.fibre = test::slanted_fibre(dimension);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const Index3 at = scene.specimen.grid.cell_at(cell);
    if (at[0] >= 5)
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = 1;
    if (dimension > 1 && at[0] >= 3 && at[0] < 6 && at[1] >= 2 && at[1] < 4) // a hole
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-3, -5e-4, 2e-4});
  if (dimension > 1)
    test::pull_face(scene, 1, true, {20, 30, -10});
  scene.gravity = {0, -9.81, 0};
  return scene;
}

// Truth: the same equations solved three ways. CG at 1e-12, the condition number is below 1e4.
TEST(SolversOracle, Agree) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const int degree : {1, 2}) {
      SCOPED_TRACE(fmt::format("{}D Q{}", dimension, degree));
      const Scene scene = rich_scene(dimension);
      const Answer cholmod = test::solved(scene, options_of(degree, LinearSolver::cholmod)).answer;
      const Answer cg = test::solved(scene, options_of(degree, LinearSolver::cg_amg)).answer;
      const double size = test::largest(cholmod.displacement);
      EXPECT_LT(test::largest_difference(cholmod.displacement, cg.displacement), 1e-8 * size);
    }
}

TEST(SolversContract, WhoAsksForLessIsAnsweredToo) {
  fem_ref::Options options = options_of(1, LinearSolver::cg_amg);
  const Answer exact = fem_ref::solve(rich_scene(3), options).answer;
  options.tolerance = 1e-3;
  const Answer loose = test::solved(rich_scene(3), options).answer;
  EXPECT_GT(loose.residual, 1e-6) << "else nothing was tried";
  EXPECT_LE(loose.residual, 2e-3);
  EXPECT_LT(loose.iterations, exact.iterations);
}

TEST(SolversContract, AnswerIsFilledIn) {
  Scene scene = test::box_scene(3, {4, 2, 2});
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {10, 0, 0});
  const std::pair<LinearSolver, std::string> cases[] = {
      {LinearSolver::cholmod, "Q1, CHOLMOD "}, // supernodal or not is CHOLMOD's choice
      {LinearSolver::cg_amg, "Q1, CG with smoothed-aggregation AMG, "}};
  for (const auto& [solver, algorithm] : cases) {
    const fem_ref::Result result = fem_ref::solve(scene, options_of(1, solver));
    EXPECT_EQ(result.answer.method, "fem_q1");
    // Four of five layers of nine nodes are free: 108 unknowns of 135.
    const std::string found = result.answer.algorithm;
    EXPECT_EQ(found.substr(0, algorithm.size()), algorithm);
    EXPECT_EQ(found.substr(found.rfind(',')), ", 108 unknowns");
    EXPECT_EQ(result.degrees_of_freedom, 135);
    EXPECT_EQ(result.answer.iterations > 0, solver == LinearSolver::cg_amg);
    EXPECT_GT(result.answer.residual, 0);
    EXPECT_LT(result.answer.residual, 1e-10);
    EXPECT_GT(result.answer.bytes, 135 * 81); // at least part of a matrix
    EXPECT_GT(result.answer.seconds.setup, 0);
    EXPECT_GT(result.answer.seconds.solve, 0);
  }
  EXPECT_EQ(fem_ref::solve(scene, options_of(2)).answer.method, "fem_q2");
}

TEST(SolversContract, AutomaticTakesTheFactorWhereItIsSmallAndSaysSo) {
  for (const auto& [cells, algorithm] : {std::pair{Index3{8, 4, 4}, "Q1, CHOLMOD"},
                                         {{24, 24, 24}, "Q1, CG with geometric multigrid, matrix-free"},
                                         {{27, 27, 27}, "Q1, CG with smoothed-aggregation AMG ("}}) {
    Scene scene = test::box_scene(3, cells);
    test::hold_face(scene, 0, false);
    test::move_face(scene, 0, true, {1e-4, 0, 0});
    const Answer answer = test::solved(scene, options_of(1)).answer;
    EXPECT_TRUE(answer.algorithm.starts_with(algorithm)) << answer.algorithm;
  }
}

TEST(SolversContract, StopIsHeard) {
  const Scene scene = rich_scene(3);
  Control at_once;
  at_once.stop_requested = [] { return true; };
  const Answer early = fem_ref::solve(scene, options_of(1), at_once).answer;
  EXPECT_EQ(early.status, Status::interrupted);
  ASSERT_EQ(early.displacement.n_components(), 3u);
  // What is prescribed stands, nothing else has moved.
  EXPECT_DOUBLE_EQ(test::largest(early.displacement), 1e-3);

  Control while_iterating;
  int iterations = 0;
  while_iterating.progress = [&](double, std::string_view what) { iterations += what == "iterating"; };
  while_iterating.stop_requested = [&] { return iterations >= 3; };
  const Answer late = fem_ref::solve(scene, options_of(1, LinearSolver::cg_amg), while_iterating).answer;
  EXPECT_EQ(late.status, Status::interrupted);
  EXPECT_LE(late.iterations, 3);
  EXPECT_GT(late.residual, 1e-12);

  Control no_time;
  no_time.seconds_budget = 0;
  EXPECT_EQ(fem_ref::solve(scene, options_of(1), no_time).answer.status, Status::budget_reached);
}

TEST(SolversContract, ProgressRisesToOne) {
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg}) {
    std::vector<double> fractions;
    Control control;
    control.progress = [&](double fraction, std::string_view) { fractions.push_back(fraction); };
    fem_ref::solve(rich_scene(2), options_of(1, solver), control);
    ASSERT_GE(fractions.size(), 3u);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1);
  }
}

// Truth: the same sums in another order.
TEST(SolversContract, ThreadsDoNotChangeTheAnswer) {
  const Scene scene = rich_scene(3);
  Control two;
  two.threads = 2;
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg}) {
    const Displacement one = fem_ref::solve(scene, options_of(2, solver)).answer.displacement;
    const Displacement other = fem_ref::solve(scene, options_of(2, solver), two).answer.displacement;
    EXPECT_LT(test::largest_difference(one, other), 1e-9 * test::largest(one));
  }
}

TEST(SolversContract, NothingIsPrinted) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg})
    fem_ref::solve(rich_scene(3), options_of(1, solver));
  Scene free = test::box_scene(3, {2, 2, 2});
  fem_ref::solve(free, options_of(1));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SolversContract, ImpossibleRequestsAreRefused) {
  Scene scene = rich_scene(2);
  EXPECT_EQ(fem_ref::solve(scene, options_of(3)).answer.message,
            "expected elements of degree 1 or 2, found 3");
  std::fill(scene.specimen.material_id.begin(), scene.specimen.material_id.end(), no_material);
  EXPECT_EQ(fem_ref::solve(scene, options_of(1)).answer.message, "the specimen holds no matter");

  Scene vast = test::box_scene(3, {4000, 4000, 4000}); // 6e10 nodes: petabytes
  vast.prescribed = {{0, 0, 0, true}};
  const Answer answer = fem_ref::solve(vast, options_of(1)).answer;
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.message.substr(0, 29), "matrix and solver need about ");
}

// Geometric multigrid against a factor, and what is kept from one scene to the next.

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
  test::sort_prescribed(scene);
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
      const Answer truth = test::solved(scene, options_of(degree, LinearSolver::cholmod)).answer;
      SCOPED_TRACE(fmt::format("{}D Q{}", dimension, degree));
      const Answer answer = test::solved(scene, options_of(degree, LinearSolver::gmg)).answer;
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

/// Steps that no library lets go of are left behind when the caller asks to stop.

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A factor of it takes many seconds, so does its analysis.
Scene large_box(int cells) {
  Scene scene = test::box_scene(3, {cells, cells, cells});
  test::hold_face(scene, 0, false);
  test::prescribe_face(scene, 0, true, 0, 1e-3, false);
  return scene;
}

class StopContract : public testing::Test {
protected:
  ~StopContract() override {
    while (fem_ref::works_left_behind() > 0) // the next test may ask for the same libraries
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
};

TEST_F(StopContract, AFactorisationIsLeftWithinASecond) {
  const Scene scene = large_box(22);
  Control control;
  std::optional<Clock::time_point> factorising;
  control.progress = [&](double, std::string_view what) {
    if (what == "factorising" && !factorising)
      factorising = Clock::now();
  };
  control.stop_requested = [&] { return factorising && seconds_since(*factorising) > 0.2; };
  const Answer answer = fem_ref::solve(scene, options_of(1, LinearSolver::cholmod), control).answer;
  ASSERT_TRUE(factorising);
  EXPECT_LT(seconds_since(*factorising), 0.2 + 1);
  EXPECT_EQ(answer.status, Status::interrupted);
  EXPECT_FALSE(answer.message.empty());
  ASSERT_EQ(answer.displacement.n_components(), 3u);
  EXPECT_DOUBLE_EQ(test::largest(answer.displacement), 1e-3) << "what is prescribed has moved, nothing else";
  EXPECT_EQ(fem_ref::works_left_behind(), 1) << "else nothing was tried";
}

TEST_F(StopContract, MeshingAndAssemblyToo) {
  const Scene scene = large_box(40);
  Control control;
  const auto start = Clock::now();
  control.stop_requested = [&] { return seconds_since(start) > 0.1; };
  const Answer answer = fem_ref::solve(scene, options_of(1, LinearSolver::cg_amg), control).answer;
  EXPECT_LT(seconds_since(start), 0.1 + 1);
  EXPECT_EQ(answer.status, Status::interrupted);
}

TEST_F(StopContract, WhoIsNotStoppedGetsTheSameBits) {
  const Scene scene = large_box(6);
  Control control;
  control.stop_requested = [] { return false; };
  fem_ref::Solver solver(options_of(1, LinearSolver::cholmod));
  const Answer alone = fem_ref::solve(scene, options_of(1, LinearSolver::cholmod)).answer;
  for (int turn = 0; turn < 2; ++turn) { // the second time by what was kept
    const Answer answer = solver.solve(scene, control).answer;
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    EXPECT_EQ(answer.displacement, alone.displacement);
  }
}

TEST_F(StopContract, ErrorsOfTheCallersFunctionsReachIt) {
  const Scene scene = large_box(20);
  Control control;
  control.stop_requested = [] { return false; };
  control.progress = [](double, std::string_view) { throw std::runtime_error("mine"); };
  EXPECT_THROW(fem_ref::solve(scene, options_of(1), control), std::runtime_error);
}

volatile std::sig_atomic_t n_heard = 0;

// METIS would take SIGTERM for itself while it orders.
TEST_F(StopContract, SigtermStaysTheProgramsWhileAMatrixIsAnalysed) {
  struct sigaction ours {};
  struct sigaction before {};
  ours.sa_handler = [](int) { n_heard = n_heard + 1; };
  sigaction(SIGTERM, &ours, &before);
  const Scene scene = large_box(16);
  int n_sent = 0, n_taken = 0;
  std::atomic<bool> is_over{false};
  std::thread sender([&] {
    for (; !is_over; std::this_thread::sleep_for(std::chrono::milliseconds(2))) {
      struct sigaction now {};
      sigaction(SIGTERM, nullptr, &now);
      n_taken += now.sa_handler != ours.sa_handler;
      if (now.sa_handler == ours.sa_handler) {
        raise(SIGTERM);
        ++n_sent;
      }
    }
  });
  const Answer answer = fem_ref::solve(scene, options_of(1, LinearSolver::cholmod)).answer;
  is_over = true;
  sender.join();
  sigaction(SIGTERM, &before, nullptr);
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  EXPECT_EQ(n_taken, 0);
  EXPECT_GT(n_sent, 0);
  EXPECT_EQ(n_heard, n_sent);
}

} // namespace
} // namespace maille
