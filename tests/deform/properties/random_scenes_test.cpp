/// Every unconditional promise, checked on random scenes. A failure prints its seed and the smallest scene
/// that breaks the same promise; MAILLE_SEED=N begins at another seed.

#include "checks/promises.hpp"
#include "checks/random_scene.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace maille::lab {
namespace {

constexpr int n_parts = 20;

std::uint64_t first_seed() {
  const char* given = std::getenv("MAILLE_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : 1;
}

/// In parts, so that several processes can share them.
class RandomScenesContract : public testing::TestWithParam<int> {};

TEST_P(RandomScenesContract, KeepEveryPromise) {
  constexpr std::uint64_t n = MAILLE_RANDOM_SCENES / n_parts;
  const std::uint64_t first = first_seed() + static_cast<std::uint64_t>(GetParam()) * n;
  for (std::uint64_t seed = first; seed < first + n; ++seed)
    if (const std::string broken = broken_promise_of_seed(seed); !broken.empty())
      ADD_FAILURE() << broken;
}

INSTANTIATE_TEST_SUITE_P(Parts, RandomScenesContract, testing::Range(0, n_parts));

TEST(RandomScenesOfOneSeedContract, AreTheSame) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Choices one(seed), two(seed);
    EXPECT_EQ(in_words(random_scene(one)), in_words(random_scene(two)));
    EXPECT_EQ(one.made(), two.made());
  }
}

TEST(RandomScenesSpreadContract, EveryKindOfSceneIsAmongThem) {
  std::map<std::string, int> seen;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Choices choices(seed);
    const Scene scene = random_scene(choices);
    ++seen["dimension " + std::to_string(scene.dimension())];
    ++seen["limits " + std::to_string(static_cast<int>(scene.limits.from))];
    ++seen["materials " + std::to_string(scene.materials.size())];
    seen["loads"] += scene.has_loads() ? 1 : 0;
    seen["contraction"] += scene.contracts() ? 1 : 0;
    seen["holes"] += scene.specimen.n_matter_cells() < scene.specimen.grid.n_cells() ? 1 : 0;
    seen["fibres"] += scene.specimen.fibres.empty() ? 0 : 1;
  }
  for (const char* kind :
       {"dimension 1", "dimension 2", "dimension 3", "limits 0", "limits 1", "limits 2", "materials 1",
        "materials 2", "materials 3", "loads", "contraction", "holes", "fibres"})
    EXPECT_GE(seen[kind], 10) << kind;
}

TEST(BrokenPromiseContract, IsFoundWhereThereIsOne) {
  // A bar of two links between 0 and 1 mm; every answer but the right one breaks a promise.
  Scene scene;
  scene.specimen.grid = Grid(1, {2, 1, 1}, {1e-3, 1, 1});
  scene.materials.resize(1);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0.3);
  scene.prescribed = {{0, 0, 0, true}, {2, 0, 1e-3, false}};
  Answer answer;
  answer.displacement = Displacement(scene.specimen.grid);
  std::ranges::copy(std::vector<double>{0, 0.5e-3, 1e-3}, answer.displacement.component(0).begin());
  EXPECT_EQ(broken_promise(scene, "limits", answer), "");
  const auto with = [&](const auto& change) {
    Answer other = answer;
    change(other);
    return broken_promise(scene, "limits", other);
  };
  EXPECT_NE(with([](Answer& a) { a.displacement(0, 1) = NAN; }), "");
  EXPECT_NE(with([](Answer& a) { a.displacement(0, 0) = 1e-300; }), "");
  EXPECT_NE(with([](Answer& a) { a.displacement(0, 2) = 0.9e-3; }), "");
  EXPECT_NE(with([](Answer& a) { a.displacement(0, 1) = 0.6e-3; }), "") << "taut links give 0.5 mm each";
  EXPECT_NE(with([](Answer& a) { a.residual = INFINITY; }), "");
  EXPECT_NE(with([](Answer& a) { a.reaction = {NAN}; }), "");
  EXPECT_NE(with([](Answer& a) { a.status = Status::clamped; }), "");
  EXPECT_NE(with([](Answer& a) { a.status = Status::refused; }), "");
}

} // namespace
} // namespace maille::lab
