/// Steps that no library lets go of are left behind when the caller asks to stop.

#include "bodies.hpp"

#include "maille/fem_ref/abandoned.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

namespace maille {
namespace {

using fem_ref::LinearSolver;
using test::options_of;
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
