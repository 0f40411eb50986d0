#include "maille/scene/answer.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace maille {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

Vector3d random_vector(std::mt19937& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}

Vec3 vec3(const Vector3d& v) {
  return {v[0], v[1], v[2]};
}

/// Displacements of points that a rotation about `centre` and a shift carry along.
std::vector<Vec3> carried(const std::vector<Vec3>& rest, const Matrix3d& rotation, const Vector3d& shift) {
  std::vector<Vec3> u;
  for (const Vec3& x : rest) {
    const Vector3d p(x[0], x[1], x[2]);
    u.push_back(vec3(rotation * p + shift - p));
  }
  return u;
}

TEST(FrameAnalytic, FindsTheRotationThatPointsAreCarriedBy) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const bool is_plane = seed % 2 == 0; // points in a plane determine the turn as well
    std::vector<Vec3> rest;
    for (int i = 0; i < 7; ++i)
      rest.push_back(vec3(random_vector(random, 1)));
    if (is_plane)
      for (Vec3& x : rest)
        x[2] = 0.25;
    const Matrix3d rotation =
        AngleAxisd(uniform(random, -3.1, 3.1), random_vector(random, 1).normalized()).toRotationMatrix();
    const Vector3d shift = random_vector(random, seed % 3 == 0 ? 100 : 1);
    const Frame frame = fit_frame(3, rest, carried(rest, rotation, shift));
    ASSERT_TRUE(frame.is_turned) << "seed " << seed;
    EXPECT_LE((frame.rotation - rotation).norm(), 1e-12) << "seed " << seed;
    for (std::size_t i = 0; i < rest.size(); ++i) { // truth: nothing moves within the body
      const Vec3 w = frame.in_object(rest[i], carried(rest, rotation, shift)[i]);
      EXPECT_LE(std::hypot(w[0], w[1], w[2]), 1e-13 * (1 + shift.norm())) << "seed " << seed;
    }
  }
}

TEST(FrameAnalytic, ThereAndBackIsTheIdentity) {
  std::mt19937 random(3);
  const std::vector<Vec3> rest{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  const Matrix3d rotation = AngleAxisd(2, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Frame frame = fit_frame(3, rest, carried(rest, rotation, {1, -2, 0.5}));
  for (int i = 0; i < 20; ++i) {
    const Vec3 x = vec3(random_vector(random, 5)), u = vec3(random_vector(random, 5));
    const Vec3 again = frame.in_world(x, frame.in_object(x, u));
    for (std::size_t b = 0; b < 3; ++b)
      EXPECT_NEAR(again[b], u[b], 1e-13);
  }
}

TEST(FrameAnalytic, TranslationsAndSymmetricStretchesAreNotTurned) {
  std::mt19937 random(5);
  std::vector<Vec3> rest;
  for (int i = 0; i < 9; ++i)
    rest.push_back(vec3(random_vector(random, 1)));
  const Matrix3d sheared = (Matrix3d() << 1.2, 0.1, 0.3, 0.1, 0.9, -0.2, 0.3, -0.2, 1.4).finished();
  Vector3d mean = Vector3d::Zero();
  for (const Vec3& x : rest)
    mean += Vector3d(x[0], x[1], x[2]) / 9;
  for (const Vector3d& shift : {Vector3d(0, 0, 0), Vector3d(0.1, 0.2, -0.3), Vector3d(100, 50, 1)}) {
    // The rotation of x -> S x + t is the identity for every symmetric positive definite S (polar
    // decomposition) if the points' second moment commutes with S; a cross of points along S's axes has such
    // a moment.
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(sheared);
    std::vector<Vec3> cross;
    for (int i = 0; i < 6; ++i)
      cross.push_back(vec3((i % 2 == 0 ? 1 : -1) * axes.eigenvectors().col(i / 2)));
    EXPECT_FALSE(fit_frame(3, cross, carried(cross, sheared, shift)).is_turned);
    EXPECT_FALSE(fit_frame(3, rest, carried(rest, Matrix3d::Identity(), shift)).is_turned);
  }
}

TEST(FrameAnalytic, TurningWhatWasAskedTurnsTheFrame) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<Vec3> rest, u, turned;
    const Matrix3d extra =
        AngleAxisd(uniform(random, -3, 3), random_vector(random, 1).normalized()).toRotationMatrix();
    for (int i = 0; i < 6; ++i) {
      rest.push_back(vec3(random_vector(random, 1)));
      u.push_back(vec3(random_vector(random, 0.2)));
      const Vector3d x(rest[i][0], rest[i][1], rest[i][2]), place = x + Vector3d(u[i][0], u[i][1], u[i][2]);
      turned.push_back(vec3(extra * place - x));
    }
    const Frame plain = fit_frame(3, rest, u), after = fit_frame(3, rest, turned);
    EXPECT_LE((after.rotation - extra * plain.rotation).norm(), 1e-12) << "seed " << seed;
  }
}

TEST(FrameAnalytic, PointsOnALineTakeTheSmallestTurn) {
  const std::vector<Vec3> rest{{1, 0, 0}, {2, 0, 0}, {5, 0, 0}};
  const Matrix3d quarter = AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()).toRotationMatrix();
  // Truth: of all turns that take x to y the one about z is the smallest, whatever spin about x came first.
  const Matrix3d spun = quarter * AngleAxisd(1, Vector3d::UnitX()).toRotationMatrix();
  const Frame frame = fit_frame(3, rest, carried(rest, spun, {0, 0, 0}));
  ASSERT_TRUE(frame.is_turned);
  EXPECT_LE((frame.rotation - quarter).norm(), 1e-14);
}

TEST(FrameAnalytic, WhereNoRotationIsNearestThereIsNone) {
  const std::vector<Vec3> corners{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  EXPECT_FALSE(fit_frame(3, corners, carried(corners, -Matrix3d::Identity(), {0, 0, 0})).is_turned);
  const std::vector<Vec3> collapsed{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  EXPECT_FALSE(fit_frame(3, corners, collapsed).is_turned); // all in one place
  EXPECT_FALSE(fit_frame(1, std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}}, std::vector<Vec3>{{0, 0, 0}, {-2, 0, 0}})
                   .is_turned);
}

TEST(FrameAnalytic, AHoldOrAFreeComponentTiesItToTheWorld) {
  Scene scene = test::lattice_box({4, 4, 4}, test::even_limits(1.25, 0.75, 0.25));
  const std::vector<Index3> corners{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const std::vector<Vec3> quarter{{0, 0, 0}, {-4, 4, 0}, {-4, -4, 0}}; // about z through the first
  for (std::size_t i = 0; i < 3; ++i)
    test::move(scene, corners[i], quarter[i]);
  ASSERT_TRUE(object_frame(scene).is_turned);
  EXPECT_NEAR(object_frame(scene).angle(), std::numbers::pi / 2, 1e-14);
  Scene held = scene;
  test::hold(held, {4, 4, 4});
  EXPECT_FALSE(object_frame(held).is_turned);
  Scene free = scene;
  std::erase_if(free.prescribed, [](const Prescribed& p) { return p.component == 2 && p.node == 0; });
  EXPECT_FALSE(object_frame(free).is_turned);
}

TEST(TurnAnalytic, ASceneFileTurnsWhatItMoves) {
  const Scene scene = parse_scene(R"(
[specimen]
shape = "box"
cells = [4, 2, 2]
spacing = "1 m"
material = "fat/subcutaneous"
[[move]]
where = "x+"
turn = { angle = "90 deg", axis = [2, 0, 0] }
by = ["0.5 m", 0, 0]
[[move]]
where = "x-"
by = 0
)",
                                  "turn.toml");
  // Truth: about x through the middle of the face (y = z = 1 m): y - 1 -> z - 1, z - 1 -> -(y - 1).
  const Grid& grid = scene.specimen.grid;
  for (const double fraction : {1.0, 0.5}) {
    const Scene step = scaled(scene, fraction);
    const double c = std::cos(fraction * std::numbers::pi / 2), s = std::sin(fraction * std::numbers::pi / 2);
    for (const Prescribed& p : step.prescribed) {
      const Index3 at = grid.node_at(p.node);
      const double y = at[1] - 1, z = at[2] - 1;
      const std::array<double, 3> u{0.5 * fraction, c * y - s * z - y, s * y + c * z - z};
      EXPECT_NEAR(p.value, at[0] == 4 ? u[static_cast<std::size_t>(p.component)] : 0, 1e-15);
    }
  }
}

using std::numbers::pi;

/// Every node on its place on the arc.
Displacement arc(const Scene& scene, double angle) {
  Displacement u(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node)), there = test::on_arc(x, angle);
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, node) = there[static_cast<std::size_t>(b)] - x[static_cast<std::size_t>(b)];
  }
  return u;
}

// Truth: an arc turns by the angle times the part of the way along it; its strain is the height over the
// radius.
TEST(BlockFramesAnalytic, AnArcTurnsLittleByLittle) {
  for (const int dimension : {2, 3})
    for (const double angle : {0.5, pi / 2, 3.1}) {
      const Scene scene = test::straight_bar(dimension, 4);
      const Displacement u = arc(scene, angle);
      const auto rotation = block_rotations(scene, u);
      const CellFields fields = cell_fields(scene, u);
      for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
        const Index3 at = scene.specimen.grid.cell_at(cell);
        const Eigen::AngleAxisd turn(rotation[static_cast<std::size_t>(cell)]);
        EXPECT_NEAR(turn.angle() * turn.axis()[2], angle * (at[0] + 0.5) / 16, 1e-12);
        // The mean gradient of a cell is that of its chord, shorter by the sine of half a cell's turn over
        // that turn.
        const double half = angle / 32, curved = std::sin(half) / half;
        const double strain = curved * (1 - angle / 4 * (at[1] - 1.5) / 4) - 1;
        EXPECT_NEAR(fields.strain[static_cast<std::size_t>(cell)][0], strain, 1e-12);
        EXPECT_NEAR(fields.strain[static_cast<std::size_t>(cell)][3], 0, 1e-12);
      }
    }
}

// Truth: the surface's links are longer by height over radius, within a cell's turn.
TEST(BlockFramesAnalytic, LinksOnAnArcAreMeasuredWhereTheyAre) {
  Scene scene = test::straight_bar(3, 8);
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch.fill(1.05);
  scene.limits.given.compress.fill(0.5);
  for (auto& row : scene.limits.given.shear)
    row.fill(0.05);
  const double angle = pi / 2, surface = angle * test::bar_height / 2 / test::bar_length;
  const double half = angle / 64, chord = std::sin(half) / half; // of an arc of one cell
  EXPECT_NEAR(largest_violation_in_blocks(scene, LinkLimits(scene), arc(scene, angle)),
              (1 + surface) * chord - 1.05, 1e-12);
  scene.limits.given.stretch.fill(1.2);
  EXPECT_EQ(largest_violation_in_blocks(scene, LinkLimits(scene), arc(scene, angle)), 0);
}

TEST(BlockFramesContract, ASceneAsksForThem) {
  const std::string head = R"(
[specimen]
shape = "box"
cells = [4, 2]
spacing = "1 m"
material = "fat/subcutaneous"
[[hold]]
where = "x-"
[relaxation]
)";
  const Scene scene = parse_scene(head + "frame = \"blocks\"\nincrements = 7", "blocks.toml");
  EXPECT_TRUE(in_blocks(scene));
  EXPECT_EQ(scene.relaxation.increments, 7);
  EXPECT_FALSE(in_blocks(parse_scene(head + "frame = \"object\"", "object.toml")));
  EXPECT_FALSE(in_blocks(parse_scene(head, "neither.toml")));
  EXPECT_THROW(parse_scene(head + "frame = \"world\"", "world.toml"), InputError);
  EXPECT_THROW(parse_scene(head + "increments = 0", "none.toml"), InputError);
}

} // namespace
} // namespace maille
