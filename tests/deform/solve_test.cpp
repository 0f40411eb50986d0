#include "maille/deform/solve.hpp"

#include "support/bodies/lattice_scenes.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace maille::deform {
namespace {

Scene pulled_box() {
  Scene scene = tests::lattice_box({4, 2}, tests::even_limits(1.5, 0.5, 0.25));
  for (const Index3& at : tests::face(scene, 0, false))
    tests::hold(scene, at);
  for (const Index3& at : tests::face(scene, 0, true))
    tests::move(scene, at, {0.5, 0, 0});
  return scene;
}

TEST(SolveContract, EveryMethodRefusesASceneOfNothing) {
  for (const std::string_view method : methods()) {
    const Answer answer = solve(Scene{}, method);
    EXPECT_EQ(answer.status, Status::refused) << method;
    EXPECT_NE(answer.message.find("no cells"), std::string::npos) << answer.message;
  }
}

TEST(SolveContract, EveryMethodAnswersAScene) {
  for (const std::string_view method : methods()) {
    const Answer answer = solve(pulled_box(), method);
    EXPECT_EQ(answer.method, method);
    EXPECT_EQ(answer.status, Status::done) << method;
    EXPECT_EQ(answer.message, "") << method;
    EXPECT_FALSE(answer.algorithm.empty()) << method;
    EXPECT_GT(answer.iterations, 0) << method;
    EXPECT_GT(answer.bytes, 0) << method;
    EXPECT_GT(answer.seconds.total(), 0) << method;
    for (const Prescribed& p : pulled_box().prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), p.value) << method;
  }
}

TEST(SolveContract, AnUnknownMethodIsRefusedWithTheKnownOnes) {
  const Answer answer = solve(pulled_box(), "magic");
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.method, "magic");
  EXPECT_NE(answer.message.find("`magic`"), std::string::npos) << answer.message;
  for (const std::string_view method : methods())
    EXPECT_NE(answer.message.find(method), std::string::npos) << answer.message;
}

TEST(SolveContract, LoadsAreRefused) {
  Scene heavy = pulled_box();
  heavy.gravity = {0, -9.81, 0};
  Scene loaded = pulled_box();
  loaded.tractions.push_back({0, 0, true, {1, 0, 0}});
  for (const std::string_view method : methods())
    for (const Scene* scene : {&heavy, &loaded}) {
      if (method == "relaxed" || method == "coupled") { // elastic methods
        EXPECT_EQ(solve(*scene, method).status, Status::done);
        continue;
      }
      const Answer answer = solve(*scene, method);
      EXPECT_EQ(answer.status, Status::refused);
      EXPECT_TRUE(answer.message.starts_with(std::string(method) + " carries no loads")) << answer.message;
      EXPECT_TRUE(answer.displacement.empty());
    }
}

TEST(SolveContract, MovesThatAreNotFiniteAreRefused) {
  for (const double value :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    Scene scene = pulled_box();
    tests::move(scene, {4, 0, 0}, {value, 0, 0});
    for (const std::string_view method : methods())
      EXPECT_EQ(solve(scene, method).status, Status::refused) << method;
  }
}

TEST(SolveContract, SameInputSameBits) {
  for (const std::string_view method : methods()) {
    Control control;
    const Answer once = solve(pulled_box(), method, control);
    control.threads = 2;
    const Answer again = solve(pulled_box(), method, control);
    EXPECT_EQ(once.displacement, again.displacement) << method;
  }
}

TEST(SolveContract, ACallerCanStopEveryMethodThatIsLong) {
  Control stop;
  stop.stop_requested = [] { return true; };
  Control no_time;
  no_time.seconds_budget = 0.0;
  for (const char* method :
       {"limits", "dijkstra", "sweep"}) { // literal is short, relaxers have tests of their own
    EXPECT_EQ(solve(pulled_box(), method, stop).status, Status::interrupted) << method;
    const Answer answer = solve(pulled_box(), method, no_time);
    EXPECT_EQ(answer.status, Status::budget_reached) << method;
    const Scene scene = pulled_box();
    EXPECT_EQ(largest_violation(scene, LinkLimits(scene), answer.displacement), 0) << method;
  }
}

} // namespace
} // namespace maille::deform
