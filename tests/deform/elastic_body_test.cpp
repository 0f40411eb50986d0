/// A body that stays, against answers to every question by itself.

#include "elastic/kept_answers.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/coupled_algorithms.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

using test::relative_difference;

Scene carved(const Index3& cells = {10, 9, 12}) {
  Scene scene = test::carved_body(cells, test::Fibres::slanted);
  scene.relaxation.tolerance = 1e-4;
  return scene;
}

Scene box(const Index3& cells = {12, 12, 12}) {
  Scene scene = test::box_scene(3, cells);
  test::hold_and_move_ends(scene);
  scene.relaxation.tolerance = 1e-4;
  return scene;
}

void move_by(Scene& scene, const Vec3& by) {
  for (Prescribed& p : scene.prescribed)
    if (!p.held)
      p.value = by[static_cast<std::size_t>(p.component)];
}

/// Answers of the same method to every question from nothing are the oracle.
void expect_as_alone(ElasticBody& body, const Scene& scene) {
  const Answer kept = body.answer(scene), alone = solve(scene, Method::coupled);
  ASSERT_EQ(kept.status, alone.status) << kept.message;
  EXPECT_LE(kept.residual, scene.relaxation.tolerance);
  // Both are as near to the answer as the tolerance; the energy norm is no displacement.
  const double near = 4 * scene.relaxation.tolerance;
  EXPECT_LE(relative_difference(kept.displacement, alone.displacement), near);
  EXPECT_NEAR(*kept.strain_energy, *alone.strain_energy, near * *alone.strain_energy);
  ASSERT_EQ(kept.reaction.size(), alone.reaction.size());
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < kept.reaction.size(); ++i) {
    difference += std::pow(kept.reaction[i] - alone.reaction[i], 2);
    size += std::pow(alone.reaction[i], 2);
  }
  EXPECT_LE(std::sqrt(difference / size), 10 * near); // residuals of nodes beside the handles
}

TEST(ElasticBodyConsistent, MovesThatChange) {
  for (const auto& scene_of : {std::function<Scene()>([] { return carved(); }), {[] { return box(); }}}) {
    Scene scene = scene_of();
    ElasticBody body;
    for (const Vec3& by :
         {Vec3{1e-4, 0, 5e-5}, {2e-4, 0, 1e-4}, {2e-4, 3e-5, 1e-4}, {0, 1e-4, 0}, {1e-5, 1e-4, 2e-5}}) {
      move_by(scene, by);
      expect_as_alone(body, scene);
    }
  }
}

TEST(ElasticBodyContract, WhatGoesOnAsItWentNeedsNoIterations) {
  for (Scene scene : {carved(), box()}) {
    ElasticBody body;
    const std::int64_t first = body.answer(scene).iterations;
    EXPECT_GT(first, 2);
    move_by(scene, {2e-4, 0, 1e-4}); // twice as far
    EXPECT_LE(body.answer(scene).iterations, 1);
    move_by(scene, {1e-4, 1e-4, 1e-4});
    body.answer(scene);
    move_by(scene, {0, 1e-4, 0.5e-4}); // a sum of those
    EXPECT_LE(body.answer(scene).iterations, 2);
  }
}

TEST(ElasticBodyConsistent, LoadsThatChange) {
  Scene scene = carved();
  for (Material& material : scene.materials)
    material.density = 1000;
  ElasticBody body;
  for (const Vec3& gravity : {Vec3{0, 0, -9.81}, {0, 0, -4}, {3, 0, -9.81}}) {
    scene.gravity = gravity;
    expect_as_alone(body, scene);
  }
  move_by(scene, {});
  expect_as_alone(body, scene);
}

TEST(ElasticBodyConsistent, NodesThatAreTouchedAndLetGo) {
  Scene scene = carved();
  ElasticBody body;
  body.answer(scene);
  const std::vector<Prescribed> before = scene.prescribed;
  const Grid& grid = scene.specimen.grid;
  for (const int at : {3, 4, 7}) { // a finger of four nodes on a side
    scene.prescribed = before;
    for (const Index3& node : {Index3{0, at, 5}, {0, at + 1, 5}, {0, at, 6}, {0, at + 1, 6}})
      if (scene.specimen.is_node(node))
        scene.prescribed.push_back({grid.node(node), 0, 1e-4, false});
    test::sort_prescribed(scene);
    expect_as_alone(body, scene);
  }
  scene.prescribed = before;
  expect_as_alone(body, scene);
}

TEST(ElasticBodyConsistent, OneMaterialThatChanges) {
  for (const double factor : {1.3, 0.7, 20.0}) { // the last is worth coarser levels of its own
    Scene scene = carved();
    ElasticBody body;
    body.answer(scene);
    scene.materials[1].elasticity = ElasticConstants::isotropic(factor * 80e3, 0.4);
    expect_as_alone(body, scene);
    move_by(scene, {1e-4, 0, -1e-4});
    expect_as_alone(body, scene);
  }
  Scene scene = box();
  ElasticBody body;
  body.answer(scene);
  scene.materials[0].elasticity = ElasticConstants::isotropic(5e3, 0.2);
  expect_as_alone(body, scene);
}

TEST(ElasticBodyConsistent, AnotherBodyIsBegunAnew) {
  ElasticBody body;
  Scene scene = carved();
  body.answer(scene);
  scene.specimen.material_id[300] = scene.specimen.material_id[300] == 0 ? 1 : 0;
  expect_as_alone(body, scene);
  expect_as_alone(body, carved({9, 8, 7}));
  expect_as_alone(body, box({8, 8, 8}));
}

TEST(ElasticBodyConsistent, SpringsAndPartsOfTissueAreTheBodys) {
  Scene scene = carved();
  ElasticBody body;
  body.answer(scene);
  const std::int64_t cell = scene.specimen.grid.cell({0, 3, 0});
  scene.springs.push_back({cell, 0, false, 1e8, {}, -1});
  expect_as_alone(body, scene);
  scene.springs.front().stiffness = 1e7;
  expect_as_alone(body, scene);
  scene.specimen.tissue.assign(scene.specimen.material_id.size(), 1.0F);
  scene.specimen.tissue[static_cast<std::size_t>(cell)] = 0.3F;
  expect_as_alone(body, scene);
  scene.specimen.stiffness_ratio.assign(scene.specimen.material_id.size(), 2.0F);
  expect_as_alone(body, scene);
}

Scene within_limits(Scene scene) {
  scene.relaxation.tolerance = 1e-3;
  return test::with_limits(scene, test::even_limits(1.02, 0.9, 0.03));
}

TEST(ElasticBodyConsistent, LimitsThatBindMoreAndLess) {
  for (Scene scene : {within_limits(carved({8, 7, 8})), within_limits(box({8, 8, 8}))}) {
    ElasticBody body;
    const double h = scene.specimen.grid.spacing()[2];
    std::int64_t n_limited = 0;
    for (const double part : {0.15, 0.16, 0.165, 0.1, 0.001, 0.15}) {
      move_by(scene, {part * h, 0, part * h});
      const Answer kept = body.answer(scene), alone = solve(scene, Method::coupled);
      ASSERT_EQ(kept.status, alone.status) << part;
      n_limited += !alone.message.empty();
      EXPECT_EQ(kept.message.empty(), alone.message.empty()) << part << ' ' << kept.message;
      EXPECT_LE(relative_difference(kept.displacement, alone.displacement), 8e-3) << part;
      EXPECT_NEAR(*kept.strain_energy, *alone.strain_energy, 8e-3 * *alone.strain_energy) << part;
      EXPECT_LE(largest_violation(scene, LinkLimits(scene), kept.displacement), 1e-8) << part; // quanta
    }
    EXPECT_GE(n_limited, 3);
  }
}

Scene finite(Scene scene) {
  scene.strain = Strain::finite;
  return scene;
}

// A course that goes on, turns aside, goes back, and whose nodes, matter and loads change.
TEST(ElasticBodyConsistent, CoursesAtFiniteStrain) {
  for (Scene scene : {finite(carved()), finite(box())}) {
    ElasticBody body;
    for (const Vec3& by : {Vec3{1e-3, 0, 5e-4},
                           {1.5e-3, 0, 7.5e-4},
                           {2e-3, 0, 1e-3},
                           {2e-3, 3e-4, 1e-3},
                           {5e-4, 0, 2.5e-4},
                           {5e-4, 0, 2.5e-4}}) {
      move_by(scene, by);
      expect_as_alone(body, scene);
    }
    scene.materials[0].elasticity = ElasticConstants::isotropic(15e3, 0.3);
    expect_as_alone(body, scene);
    scene.prescribed.erase(scene.prescribed.end() - 3, scene.prescribed.end());
    expect_as_alone(body, scene);
    for (Material& material : scene.materials)
      material.density = 1000;
    scene.gravity = {0, -9.81, 0};
    expect_as_alone(body, scene);
  }
}

// Truth: from rest, every angle by itself.
TEST(ElasticBodyConsistent, TurnsInSteps) {
  for (const int dimension : {2, 3}) {
    ElasticBody body;
    for (const double angle : {0.1, 0.2, 0.3, 0.4, 0.5, -0.5})
      expect_as_alone(body, test::bent_bar(dimension, 2, angle));
  }
}

TEST(ElasticBodyContract, TheNextStepAtFiniteStrainIsCheap) {
  Scene scene = finite(carved());
  scene.materials[0].law = NeoHookean{4e3, 6e3};
  scene.materials[0].elasticity = rest_constants(*scene.materials[0].law);
  ElasticBody body;
  std::vector<std::int64_t> iterations;
  for (int step = 1; step <= 6; ++step) {
    move_by(scene, {step * 2e-4, 0, 0});
    iterations.push_back(body.answer(scene).iterations);
  }
  EXPECT_LE(2 * iterations[4], solve(scene, Method::coupled).iterations);
  EXPECT_LE(2 * iterations[5], solve(scene, Method::coupled).iterations);
}

TEST(ElasticBodyContract, ACourseStoppedAnyTimeHasItsHandlesInPlace) {
  Scene scene = finite(carved({6, 5, 7}));
  for (int checks = 0; checks < 40; checks += 3) {
    ElasticBody body;
    move_by(scene, {5e-4, 0, 2e-4});
    body.answer(scene);
    move_by(scene, {7e-4, 3e-4, 0});
    Control control;
    control.stop_requested = [left = checks]() mutable { return left-- <= 0; };
    const Answer answer = body.answer(scene, control);
    const bool is_at_rest = largest_entry(answer.displacement) == 0;
    for (const Prescribed& p : scene.prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), is_at_rest ? 0 : p.value) << checks;
    expect_as_alone(body, scene);
  }
}

// Truth: Euler's load of a column, a quarter of a period long; it is passed on a course of stable states.
TEST(ElasticBodyContract, ACourseFindsTheStateUnstable) {
  constexpr int length = 40, across = 2;
  Scene scene = test::box_scene(2, {length, across, 1});
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0);
  scene.strain = Strain::finite;
  test::hold_face(scene, 0, false);
  const double thin = across * 1e-3,
               euler = std::pow(std::numbers::pi * thin / (2 * length * 1e-3), 2) * 1e6 / 12;
  for (int y = 0; y < across; ++y)
    scene.tractions.push_back({scene.specimen.grid.cell({length - 1, y, 0}), 0, true, {}});
  ElasticBody body;
  for (const double part : {0.5, 0.7, 0.9, 1.1}) {
    for (FaceLoad& load : scene.tractions)
      load.traction = {-part * euler, 0, 0};
    const Answer answer = body.answer(scene);
    EXPECT_EQ(answer.message.find("unstable") != std::string::npos, part > 1) << part << answer.message;
  }
}

TEST(ElasticBodyContract, TheSameQuestionsGiveTheSameBitsForAnyNumberOfThreads) {
  for (const Strain strain : {Strain::small, Strain::finite}) {
    const auto answers = [&](int threads) {
      Control control;
      control.threads = threads;
      Scene scene = carved({21, 21, 31});
      scene.strain = strain;
      ElasticBody body;
      std::vector<Answer> all;
      for (const Vec3& by : {Vec3{1e-4, 0, 5e-5}, {1.1e-4, 1e-5, 5e-5}}) {
        move_by(scene, by);
        all.push_back(body.answer(scene, control));
      }
      scene.materials[1].elasticity = ElasticConstants::isotropic(90e3, 0.4);
      all.push_back(body.answer(scene, control));
      return all;
    };
    const std::vector<Answer> one = answers(1), three = answers(3);
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].displacement, three[i].displacement) << i;
      EXPECT_EQ(one[i].reaction, three[i].reaction) << i;
    }
  }
}

TEST(ElasticBodyContract, WithItsHierarchyAloneAnAnswerKnowsNoneBeforeIt) {
  Scene rough = box(); // its state is float32
  rough.relaxation.tolerance = 1e-3;
  for (Scene scene : {carved(), box(), rough, within_limits(carved({8, 7, 8})), finite(carved({8, 7, 8}))}) {
    ElasticBody body(Keeping::hierarchy);
    const Scene first = scene;
    body.answer(scene);
    move_by(scene, {0.16e-3, 0, 0.16e-3});
    const Answer kept = body.answer(scene), alone = solve(scene, Method::coupled);
    EXPECT_EQ(kept.displacement, alone.displacement);
    EXPECT_EQ(kept.reaction, alone.reaction);
    EXPECT_EQ(kept.iterations, alone.iterations);
    scene.materials[0].elasticity = ElasticConstants::isotropic(11e3, 0.3);
    EXPECT_EQ(body.answer(scene).displacement, solve(scene, Method::coupled).displacement);
    EXPECT_EQ(body.answer(first).displacement, solve(first, Method::coupled).displacement);
  }
}

TEST(ElasticBodyContract, WithTheHierarchyOfHoldsAnAnswerKnowsNoneBeforeIt) {
  Scene scene = carved();
  const auto pressed = [&](int at) {
    Scene question = scene;
    std::erase_if(question.prescribed, [](const Prescribed& p) { return !p.held; });
    for (const Index3& node : {Index3{0, at, 5}, {0, at + 1, 5}})
      question.prescribed.push_back({scene.specimen.grid.node(node), 0, 1e-4, false});
    test::sort_prescribed(question);
    return question;
  };
  ElasticBody body(Keeping::hierarchy_of_holds), other(Keeping::hierarchy_of_holds);
  body.answer(pressed(2));
  expect_as_alone(body, pressed(5));
  EXPECT_EQ(body.answer(pressed(4)).displacement, other.answer(pressed(4)).displacement);
  EXPECT_EQ(body.answer(pressed(2)).displacement, other.answer(pressed(2)).displacement);
}

TEST(ElasticBodyContract, RefusesWhatSolveRefuses) {
  Scene scene = carved();
  ElasticBody body;
  scene.prescribed.clear();
  EXPECT_EQ(body.answer(scene).status, Status::refused);
  scene = carved();
  scene.prescribed.back().value = NAN;
  EXPECT_EQ(body.answer(scene).status, Status::refused);
  Control control;
  control.bytes_budget = 1000;
  EXPECT_EQ(body.answer(carved(), control).status, Status::refused);
  EXPECT_EQ(body.bytes(), 0);
  expect_as_alone(body, carved());
  EXPECT_GT(body.bytes(), 0);
  body.forget();
  EXPECT_EQ(body.bytes(), 0);
}

} // namespace
} // namespace maille::deform
