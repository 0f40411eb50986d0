#include "maille/base/arena.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille {
namespace {

NeighbourLimits given_limits() {
  NeighbourLimits limits;
  limits.stretch = {1.3, 1.1, 1.2};
  limits.compress = {0.8, 0.95, 0.9};
  limits.shear = {{{0, 0.1, 0.2}, {0.3, 0, 0.4}, {0.5, 0.6, 0}}};
  return limits;
}

TEST(LinkLimitsAnalytic, GivenRatiosBecomeMetresAlongEachAxis) {
  Scene scene = test::box_scene(3, {2, 2, 2}, {1e-3, 2e-3, 4e-3});
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  EXPECT_TRUE(limits.is_homogeneous());
  const auto y = limits.intervals({1, 1, 1}, 1);
  ASSERT_TRUE(y);
  EXPECT_NEAR(y->high[1], 0.1 * 2e-3, 1e-18); // (stretch - 1) h
  EXPECT_NEAR(y->low[1], -0.05 * 2e-3, 1e-18);
  EXPECT_NEAR(y->high[0], 0.3 * 2e-3, 1e-18); // shear[y][x] h
  EXPECT_NEAR(y->low[2], -0.4 * 2e-3, 1e-18);
}

TEST(LinkLimitsAnalytic, LinksExistOnlyBesideMatter) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  scene.specimen.material_id = {0, no_material, no_material, no_material};
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  EXPECT_TRUE(limits.intervals({0, 1, 0}, 0).has_value());  // upper edge of the one cell
  EXPECT_FALSE(limits.intervals({1, 0, 0}, 0).has_value()); // beyond it
  EXPECT_FALSE(limits.intervals({0, 2, 0}, 0).has_value());
}

TEST(LinkLimitsAnalytic, LinkBetweenTwoMaterialsObeysBoth) {
  Scene scene = test::box_scene(2, {1, 2, 1}, {1, 1, 1});
  Material stiff = scene.materials[0], soft = scene.materials[0];
  NeighbourLimits tight, loose;
  tight.stretch = {1.1, 1.1, 1.1};
  tight.compress = {0.5, 0.5, 0.5};
  loose.stretch = {1.5, 1.5, 1.5};
  loose.compress = {0.9, 0.9, 0.9};
  stiff.limits = tight;
  soft.limits = loose;
  scene.materials = {stiff, soft};
  scene.specimen.material_id = {0, 1};
  scene.limits.from = LimitSource::material;
  const auto between = LinkLimits(scene).intervals({0, 1, 0}, 0).value();
  EXPECT_NEAR(between.high[0], 0.1, 1e-15); // of the first
  EXPECT_NEAR(between.low[0], -0.1, 1e-15); // of the second
}

// Truth: 1 / 1.25^2 = 0.64, 1.25 - 1 / 1.25 = 0.45; turned by a quarter, axes change places.
TEST(LinkLimitsAnalytic, LimitsOfFailureAreThoseOfTheMatterAlongItsFibres) {
  Scene scene = test::box_scene(2, {1, 1, 1}, {1, 1, 1});
  scene.materials[0].damage.emplace();
  scene.materials[0].damage->stretch = {1.25, 2, 2};
  scene.limits.from = LimitSource::failure;
  for (const bool is_turned : {false, true}) {
    scene.specimen.fibre = is_turned ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
    const LinkLimits limits(scene);
    const int along = is_turned ? 1 : 0, across = 1 - along;
    const auto fibre = limits.intervals({0, 0, 0}, along).value(),
               other = limits.intervals({0, 0, 0}, across).value();
    EXPECT_NEAR(fibre.high[static_cast<std::size_t>(along)], 0.25, 1e-14);
    EXPECT_NEAR(fibre.low[static_cast<std::size_t>(along)], 0.25 - 1,
                1e-14); // 1 / 2^2: by what it bears across
    EXPECT_NEAR(fibre.high[static_cast<std::size_t>(across)], 0.45, 1e-14);
    EXPECT_NEAR(other.high[static_cast<std::size_t>(across)], 1, 1e-14);
    EXPECT_NEAR(other.low[static_cast<std::size_t>(across)], 0.64 - 1, 1e-14);
    EXPECT_NEAR(other.high[static_cast<std::size_t>(along)], 0.45, 1e-14);
  }
}

TEST(LinkLimitsAnalytic, TautScaleIsTheStressOfTheBar) {
  // A bar of two materials in series: stress = displacement / sum(h / E).
  Scene scene = test::box_scene(1, {4, 1, 1}, {0.5, 1, 1});
  Material stiff = scene.materials[0];
  stiff.elasticity = ElasticConstants::isotropic(40e3, 0.3);
  scene.materials.push_back(stiff);
  scene.specimen.material_id = {0, 0, 1, 1};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.1, 0, 0});
  const double stress = 0.1 / (2 * 0.5 / 10e3 + 2 * 0.5 / 40e3);
  const LinkLimits limits(scene);
  EXPECT_NEAR(limits.taut_scale(), stress, 1e-12 * stress);
  EXPECT_NEAR(limits.intervals({0, 0, 0}, 0)->high[0], 0.5 * stress / 10e3, 1e-15);
  EXPECT_NEAR(limits.intervals({3, 0, 0}, 0)->high[0], 0.5 * stress / 40e3, 1e-15);
}

TEST(LinkLimitsAnalytic, StepsOfASeriesKeepTheLimitsOfTheWhole) {
  Scene scene = test::box_scene(1, {4, 1, 1});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-3, 0, 0});
  scene.limits.from = LimitSource::taut;
  const Scene half = scaled(scene, 0.5);
  EXPECT_DOUBLE_EQ(half.prescribed.back().value, 0.5e-3);
  EXPECT_EQ(LinkLimits(half).taut_scale(), LinkLimits(scene).taut_scale());
}

TEST(LinkLimitsAnalytic, ViolationIsCountedInRestLengths) {
  Scene scene = test::box_scene(1, {2, 1, 1}, {2, 1, 1});
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  Displacement u(scene.specimen.grid);
  u(0, 2) = 2 * 0.3 + 2 * 0.25; // the second link may stretch by 0.6
  EXPECT_NEAR(largest_violation(scene, limits, u), 0.25, 1e-15);
  u(0, 2) = 0.6;
  EXPECT_NEAR(largest_violation(scene, limits, u), 0, 1e-15);
}

/// The scale of taut limits against all pairs of prescribed nodes.

/// Oracle: a search from every prescribed node, and the largest ratio to every other.
double scale_over_all_pairs(Scene scene) {
  scene.limits.taut_scale = 1;
  const LinkLimits unit(scene);
  const std::vector<Prescribed> prescribed = prescribed_in_object(scene, object_frame(scene));
  double scale = 0;
  for (const Prescribed& p : prescribed) {
    const PathEnd end{p.node, 0};
    const auto length = shortest_paths(scene, unit, p.component, {&end, 1}, PathDirection::from_ends);
    for (const Prescribed& q : prescribed)
      if (q.component == p.component && q.value != p.value)
        scale = std::max(scale, std::abs(q.value - p.value) / length[static_cast<std::size_t>(q.node)]);
  }
  return scale;
}

/// Sums along a path in the other direction differ in their last digits.
void expect_the_same(const Scene& scene) {
  const double oracle = scale_over_all_pairs(scene);
  EXPECT_NEAR(LinkLimits(scene).taut_scale(), oracle, 1e-14 * oracle);
}

/// Every prescribed value anew, from -1 to 1 mm.
void prescribe_at_random(Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1e-3, 1e-3);
  for (Prescribed& p : scene.prescribed)
    p = {p.node, p.component, value(random), false};
}

TEST(TautScaleOracle, HandlesThatMoveAndTurn) {
  Scene scene = test::box_scene(3, {6, 5, 7});
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {});
  for (Prescribed& p : scene.prescribed)
    if (!p.held) {
      const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
      p.value = p.component == 0 ? -0.1 * x[1] : p.component == 1 ? 0.1 * x[0] : 1e-4;
    }
  expect_the_same(scene);
}

TEST(TautScaleOracle, BoxesThatAreHeldAndPoked) {
  for (const Index3& cells : {Index3{5, 4, 3}, {1, 6, 2}, {7, 1, 1}}) {
    Scene scene = test::box_scene(3, cells, {1e-3, 0.7e-3, 1.9e-3});
    scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
    test::hold_face(scene, 2, false);
    for (const int component : {0, 2})
      scene.prescribed.push_back(
          {scene.specimen.grid.node({cells[0], 0, cells[2]}), component, -2e-4, false});
    test::sort_prescribed(scene);
    expect_the_same(scene);
    prescribe_at_random(scene, 7);
    expect_the_same(scene);
  }
}

TEST(TautScaleOracle, AnyValuesOnBodiesWithHoles) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene = test::carved_body({4, 5, 4}, seed % 2 == 0 ? test::Fibres::none : test::Fibres::turning);
    prescribe_at_random(scene, seed);
    SCOPED_TRACE(seed);
    expect_the_same(scene);
  }
}

TEST(TautScaleOracle, PiecesThatAreNotJoined) {
  Scene scene = test::box_scene(2, {5, 2, 1});
  scene.specimen.material_id = {0, 0, no_material, 0, 0, 0, 0, no_material, 0, 0};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {-1e-3, 0, 0});
  expect_the_same(scene);
  EXPECT_EQ(LinkLimits(scene).taut_scale(), 0) << "no move uses slack up";
  // The lowest value stands alone on its piece's end; the others differ on theirs.
  const std::int64_t near = scene.specimen.grid.node({4, 0, 0});
  scene.prescribed.push_back({near, 0, -0.8e-3, false});
  test::sort_prescribed(scene);
  for (Prescribed& p : scene.prescribed)
    if (p.held && p.component == 0)
      p.value = -2e-3;
  expect_the_same(scene);
  EXPECT_GT(LinkLimits(scene).taut_scale(), 0);
}

/// What memory limits leave, read from folders that look like the kernel's. The numbers are those written
/// into them.

using Root = test::TemporaryFolder;
constexpr std::int64_t nothing_limits = std::numeric_limits<std::int64_t>::max();

TEST(ControlGroupsContract, TheLeastOfAllGroupsAroundTheProcessCounts) {
  const Root root;
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits) << "no control groups at all";
  root.write("proc/self/cgroup", "0::/system.slice/slurm/job_7/step_0\n");
  const auto write = [&](const std::string& group, const char* max, const char* current) {
    root.write("sys/fs/cgroup/system.slice/" + group + "memory.max", max);
    root.write("sys/fs/cgroup/system.slice/" + group + "memory.current", current);
  };
  write("slurm/job_7/step_0/", "max\n", "100\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits) << "max is no limit";
  write("", "9000\n", "1000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 8000) << "of a group far above";
  write("slurm/job_7/", "700\n", "300\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 400) << "of the job";
  root.write("sys/fs/cgroup/system.slice/slurm/job_7/memory.stat", "anon 120\ninactive_file 150\nslab 3\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 550) << "files that are only cached are given up";
  write("other/", "1\n", "5000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 550) << "another's group";
  write("slurm/job_7/", "700\n", "5000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 0) << "more in use than is allowed";
}

TEST(ControlGroupsContract, ContainersThatShowTheirOwnGroupAsTheRoot) {
  const Root root;
  root.write("proc/self/cgroup", "0::/docker/0123456789abcdef\n");
  root.write("sys/fs/cgroup/memory.max", "5000\n");
  root.write("sys/fs/cgroup/memory.current", "2000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 3000);
}

TEST(ControlGroupsContract, VersionOneIsReadToo) {
  const Root root;
  root.write("proc/self/cgroup", "12:cpu,cpuacct:/user\n9:hugetlb,memory:/slurm/job_7\n1:name=systemd:/\n");
  const std::string groups = "sys/fs/cgroup/memory/";
  root.write(groups + "memory.limit_in_bytes", "9223372036854771712\n");
  root.write(groups + "memory.usage_in_bytes", "123456\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits)
      << "the largest multiple of a page is no limit";
  root.write(groups + "slurm/memory.limit_in_bytes", "600\n");
  root.write(groups + "slurm/memory.usage_in_bytes", "50\n");
  root.write(groups + "slurm/memory.stat", "inactive_file 1\ntotal_inactive_file 20\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 570);
  // Both versions at once, as between the two.
  root.write("proc/self/cgroup", "0::/user\n9:memory:/slurm\n");
  root.write("sys/fs/cgroup/unified/user/memory.max", "100\n");
  root.write("sys/fs/cgroup/unified/user/memory.current", "10\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 90);
}

TEST(ControlGroupsContract, DamagedFilesLimitNothing) {
  const Root root;
  root.write("proc/self/cgroup", "\n::\n0\n0:\n0::\n0::x\n4:memory\n0::/a\n");
  root.write("sys/fs/cgroup/a/memory.max", "much\n");
  root.write("sys/fs/cgroup/a/memory.current", "-\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits);
}

// In a process of its own: a limit cannot be taken back.
TEST(MemoryLimitsContract, LimitsOfAddressSpaceAndOfDataCount) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the address sanitizer has taken terabytes of addresses before";
#endif
  constexpr std::int64_t some = std::int64_t{1} << 28; // 256 MiB
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const rlimit limit{static_cast<rlim_t>(some), static_cast<rlim_t>(some)};
      const bool is_set = setrlimit(resource, &limit) == 0;
      const std::int64_t left = available_memory();
      _exit(is_set && left >= 0 && left < some ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << (resource == RLIMIT_AS ? "-v" : "-d");
  }
}

} // namespace
} // namespace maille
