/// Every unconditional promise, checked on random scenes. A failure prints its seed and the smallest scene
/// that breaks the same promise; MAILLE_SEED=N begins at another seed.

#include "checks/promises.hpp"
#include "checks/random_scene.hpp"
#include "checks/world_promises.hpp"
#include "maille/deform/solve.hpp"
#include "support/componentwise_oracle.hpp"
#include "support/dense_program.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"

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

/// Promises of worlds after every frame, checked on random worlds. A failure prints its seed and the smallest
/// play that breaks a promise; MAILLE_SEED=N begins at another seed.

TEST(RandomPlaysContract, KeepEveryPromise) {
  const std::uint64_t first = first_seed(), n = test::cases(60, 12);
  for (std::uint64_t seed = first; seed < first + n; ++seed)
    if (const std::string broken = broken_promise_of_world_seed(seed); !broken.empty())
      ADD_FAILURE() << broken;
}

TEST(RandomPlaysOfOneSeedContract, AreTheSame) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Choices one(seed), two(seed);
    EXPECT_EQ(in_words(random_world(one)), in_words(random_world(two)));
    EXPECT_EQ(one.made(), two.made());
  }
}

TEST(RandomPlaysSpreadContract, EveryKindOfWorldIsAmongThem) {
  std::map<std::string, int> seen;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Choices choices(seed);
    const WorldPlay play = random_world(choices);
    ++seen["dimension " + std::to_string(play.scene.dimension)];
    ++seen["contact " + std::to_string(static_cast<int>(play.scene.contact))];
    ++seen[play.scene.method];
    seen["dynamics"] += play.scene.dynamics ? 1 : 0;
    seen["friction"] += play.scene.friction > 1 ? 1 : 0;
    for (const WorldObject& object : play.scene.objects) {
      ++seen["kind " + std::to_string(static_cast<int>(object.kind))];
      const double ratio = object.scene.specimen.grid.spacing()[0] / play.scene.spacing[0];
      seen["finer"] += ratio < 0.3 ? 1 : 0;
      seen["coarser"] += ratio > 3 ? 1 : 0;
      seen["turned"] += object.turn_angle != 0 ? 1 : 0;
    }
  }
  for (const char* kind :
       {"dimension 1", "dimension 2", "dimension 3", "contact 0", "contact 1", "limits", "relaxed", "coupled",
        "dynamics", "friction", "kind 0", "kind 1", "kind 2", "finer", "coarser", "turned"})
    EXPECT_GE(seen[kind], 8) << kind;
}

// Two boxes that meet with their surfaces, the lower one fixed; then the frame's result is falsified.
TEST(BrokenWorldPromiseContract, IsFoundWhereThereIsOne) {
  WorldScene scene = test::empty_world({12, 12}, "coupled");
  scene.contact = ContactLaw::surfaces;
  scene.objects = {test::box_object("floor", ObjectKind::fixed, {8, 2}, {2, 2, 0}),
                   test::box_object("tool", ObjectKind::rigid, {2, 2}, {5, 4.5, 0})};
  deform::World world(scene);
  deform::Drive drive;
  drive.object = 1;
  drive.motion.by = {0, -1, 0};
  const deform::FrameResult result = world.advance({&drive, 1});
  const std::vector<bool> in_hand{false, true}, free{false, false};
  ASSERT_GT(result.contacts.size(), 0u);
  EXPECT_EQ(broken_promise(world, result, in_hand), "");
  EXPECT_NE(broken_promise(world, result, free), "") << "the floor presses, and nothing presses back";
  const auto with = [&](const auto& change) {
    deform::FrameResult other = result;
    change(other);
    return broken_promise(world, other, in_hand);
  };
  EXPECT_NE(with([](auto& r) { r.status = Status::failed; }), "");
  EXPECT_NE(with([](auto& r) {
              r.status = Status::clamped;
              r.message.clear();
            }),
            "");
  EXPECT_NE(with([](auto& r) { r.contacts[0].force[0] = NAN; }), "");
  EXPECT_NE(with([](auto& r) { r.drives[0].fraction = INFINITY; }), "");
  EXPECT_NE(with([](auto& r) { r.contacts[0].force *= 2; }), "") << "action is not reaction";
}

/// Random choices, and how they are made smaller.

TEST(ChoicesContract, AReplayGivesTheSameNumbersAndThenZeros) {
  Choices choices(7);
  std::vector<int> first;
  for (int n = 1; n < 40; ++n)
    first.push_back(choices.below(n));
  Choices replay(choices.made());
  for (int n = 1; n < 40; ++n)
    EXPECT_EQ(replay.below(n), first[static_cast<std::size_t>(n - 1)]);
  EXPECT_EQ(replay.below(1000), 0);
}

TEST(ChoicesContract, NumbersStayBelowWhatIsAskedHoweverTheyAreReplayed) {
  Choices choices(std::vector<std::uint32_t>{900, 3, 0});
  EXPECT_EQ(choices.below(5), 4) << "the largest that there is";
  EXPECT_EQ(choices.below(5), 3);
}

TEST(ChoicesAnalytic, EveryNumberIsAsLikely) {
  // Truth: 60,000 throws of a die; the standard deviation of a count is 91, five of them are 456.
  Choices choices(1);
  std::array<int, 6> counts{};
  for (int i = 0; i < 60000; ++i)
    ++counts[static_cast<std::size_t>(choices.below(6))];
  for (const int count : counts)
    EXPECT_NEAR(count, 10000, 456);
}

TEST(ShrunkAnalytic, FindsTheSmallestListThatFails) {
  // Fails where the sum of the first ten is 100 or more: the smallest such list that halving leads to has
  // nothing beyond what it needs.
  const auto fails = [](const std::vector<std::uint32_t>& list) {
    return std::accumulate(list.begin(), list.begin() + std::min<std::ptrdiff_t>(10, std::ssize(list)),
                           std::uint32_t{0}) >= 100;
  };
  const std::vector<std::uint32_t> result = shrunk(std::vector<std::uint32_t>(64, 90), fails, 10000);
  EXPECT_TRUE(fails(result));
  EXPECT_LE(result.size(), 10u);
  for (std::size_t i = 0; i < result.size(); ++i) { // nothing can be left out or halved any more
    std::vector<std::uint32_t> smaller = result;
    smaller[i] /= 2;
    EXPECT_TRUE(result[i] == 0 || !fails(smaller)) << i;
  }
}

TEST(ShrunkContract, AsksNoMoreOftenThanItMay) {
  int asked = 0;
  shrunk(
      std::vector<std::uint32_t>(100, 1000), [&](const auto&) { return ++asked > 1000; }, 17);
  EXPECT_EQ(asked, 17);
}

/// The relaxers' answers cost no more than any other answer that was found for the same question, in the
/// energy that each lowers.

constexpr double tolerance = 1e-5;

/// Random scenes that ask for a least energy: no loads (their work is another sum), no dead zone, in the
/// grid's frame.
template<class Visit>
void for_each_elastic_scene(std::uint64_t first, int n, const Visit& visit) {
  for (std::uint64_t seed = first; n > 0; ++seed) {
    Choices choices(seed);
    Scene scene = random_scene(choices);
    scene.relaxation.mode = RelaxationMode::elastic;
    scene.relaxation.extrapolation = Extrapolation::none;
    scene.relaxation.tolerance = tolerance;
    if (scene.has_loads() || object_frame(scene).is_turned)
      continue;
    visit(scene, seed);
    --n;
  }
}

double energy_of_links(const Scene& scene, const Displacement& u) {
  double sum = 0;
  const LinkLimits limits(scene);
  for (int b = 0; b < scene.dimension(); ++b)
    sum += test::energy_of(test::weighted_links(scene, limits, b), u.component(b));
  return sum;
}

/// What a rigid motion may cost [J] where the solve ends: every link off by the tolerance, of the largest
/// displacement.
double energy_of_tolerance(const Scene& scene, const Displacement& u) {
  double weights = 0;
  for (int b = 0; b < scene.dimension(); ++b)
    for (const test::WeightedLink& link : test::weighted_links(scene, LinkLimits(scene), b))
      weights += link.weight;
  return weights * std::pow(tolerance * test::largest(u), 2);
}

TEST(CoupledEnergyOracle, IsNotAboveThatOfAnyOtherMethodsAnswer) {
  int compared = 0;
  for_each_elastic_scene(1, test::cases(300, 30), [&](const Scene& scene, std::uint64_t seed) {
    const Answer coupled = deform::solve(scene, "coupled");
    if (coupled.status != Status::done)
      return;
    const double least = test::elastic_energy(scene, coupled.displacement);
    for (const char* method : {"limits", "sweep", "relaxed"}) {
      const Answer other = deform::solve(scene, method);
      if (other.n_cut > 0 || (other.status != Status::done && other.status != Status::budget_reached))
        continue;
      const double energy = test::elastic_energy(scene, other.displacement);
      EXPECT_LE(least, energy * (1 + 10 * tolerance) + energy_of_tolerance(scene, other.displacement))
          << "seed " << seed << " " << method << "\n"
          << in_words(scene);
      ++compared;
    }
  });
  EXPECT_GE(compared, test::cases(150, 10));
}

TEST(RelaxedEnergyOracle, IsNotAboveThatOfAnyOtherFeasibleAnswer) {
  int compared = 0;
  for_each_elastic_scene(1, test::cases(800, 80), [&](const Scene& scene, std::uint64_t seed) {
    const Answer relaxed = deform::solve(scene, "relaxed");
    if (!is_converged(relaxed.status))
      return;
    const double least = energy_of_links(scene, relaxed.displacement);
    for (const char* method : {"limits", "sweep"}) { // feasible, and cut back alike
      const Answer other = deform::solve(scene, method);
      if (other.n_cut > 0 || !has_displacement(other.status))
        continue;
      EXPECT_LE(least, energy_of_links(scene, other.displacement) * (1 + 10 * tolerance) +
                           energy_of_tolerance(scene, other.displacement))
          << "seed " << seed << " " << method << "\n"
          << in_words(scene);
      ++compared;
    }
  });
  EXPECT_GE(compared, test::cases(1000, 80));
}

} // namespace
} // namespace maille::lab
