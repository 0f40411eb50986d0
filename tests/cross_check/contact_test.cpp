/// Contact found by the voxel world, against finite elements with the same nodes prescribed.

#include "maille/deform/world/world.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

constexpr double mm = 1e-3;
constexpr double fine = 0.25 * mm; ///< of the world's cells; the block's are 1 mm

/// Takes away the cells outside the upper half of an ellipsoid.
void round_off(Specimen& specimen) {
  const Grid& grid = specimen.grid;
  specimen.material_id.assign(static_cast<std::size_t>(grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    const double x = (at[0] + 0.5) / 6 - 1, y = (at[1] + 0.5) / 6 - 1, z = (at[2] + 0.5) / 8;
    if (x * x + y * y + z * z > 1)
      specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
}

struct Case {
  const char* name;
  double poisson_ratio;
  int width; ///< of the tool [mm]
  bool is_dome = false;
  double error; ///< of the world against Q2, measured and a tenth more
};

/// A block of 12 x 12 x 8 mm, or a dome of stairs in it, held below, and a rigid tool above its middle, half
/// a millimetre away.
WorldScene block_and_tool(const Case& what) {
  WorldScene world;
  world.cells = {80, 80, 64};
  world.spacing = {fine, fine, fine};
  WorldObject block, tool;
  block.name = "block";
  block.kind = ObjectKind::deformable;
  block.scene = test::box_scene(3, {12, 12, 8});
  block.scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, what.poisson_ratio);
  if (what.is_dome)
    round_off(block.scene.specimen);
  block.scene.relaxation.tolerance = 1e-6;
  test::hold_face(block.scene, 2, false);
  block.position = {4.1 * mm, 4.1 * mm, 2.1 * mm}; // away from the cells' faces
  tool.name = "tool";
  tool.kind = ObjectKind::rigid;
  const int voxels = 4 * what.width;
  tool.scene = test::box_scene(3, {voxels, voxels, 3}, {fine, fine, fine});
  const double corner = 10.1 * mm - 0.5 * what.width * mm;
  tool.position = {std::round(corner / fine) * fine, std::round(corner / fine) * fine, 10.75 * mm};
  world.objects = {block, tool};
  return world;
}

struct Pressed {
  deform::World world;
  deform::FrameResult result;
};

/// The tool comes down by `depth`, a quarter of a millimetre a frame.
Pressed press(const WorldScene& scene, double depth) {
  Pressed pressed{deform::World(scene), {}};
  deform::Drive down;
  down.object = 1;
  down.motion.by = {0, 0, -fine};
  for (int frame = 0; frame < std::lround(depth / fine); ++frame) {
    pressed.result = pressed.world.advance({&down, 1});
    EXPECT_EQ(pressed.result.status, Status::done) << pressed.result.message;
    EXPECT_EQ(pressed.world.n_penetrations(), 0);
  }
  return pressed;
}

/// The same block, its contact nodes prescribed along z where the world has put them.
Scene question_of(const Pressed& pressed) {
  Scene scene = pressed.world.scene().objects[0].scene;
  for (const auto& contact : pressed.result.contacts)
    scene.prescribed.push_back({contact.voxel, 2, pressed.world.displacement(0)(2, contact.voxel), false});
  test::sort_prescribed(scene);
  return scene;
}

Answer fem(const Scene& scene, int degree) {
  fem_ref::Options options;
  options.degree = degree;
  return fem_ref::solve(scene, options).answer;
}

/// Force along z of what is moved; and how many of these forces pull.
struct Force {
  double total = 0;
  int pulls = 0;
};
Force force_of(const Scene& scene, const Answer& answer) {
  Force force;
  double largest = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (!scene.prescribed[i].held) {
      force.total += answer.reaction[i];
      largest = std::max(largest, std::abs(answer.reaction[i]));
    }
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    force.pulls += !scene.prescribed[i].held && answer.reaction[i] > 1e-3 * largest;
  return force;
}

double force_in_world(const Pressed& pressed) {
  double total = 0;
  for (const auto& contact : pressed.result.contacts)
    total += contact.force[2];
  return total;
}

/// Nodes that are free along z but inside the tool, whose lower face is where the contact nodes are.
int n_inside(const Pressed& pressed, const Scene& scene, const Answer& answer) {
  std::set<std::int64_t> touching;
  double face = 0;
  for (const auto& contact : pressed.result.contacts) {
    touching.insert(contact.voxel);
    face = pressed.world.position(0, contact.voxel)[2];
  }
  const Grid& grid = scene.specimen.grid;
  const Eigen::Vector3d origin = pressed.world.pose(0).position, low = pressed.world.pose(1).position,
                        high = low + fine * pressed.world.shape(1).size()[0] * Eigen::Vector3d::Ones();
  int n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    if (touching.contains(node) || !scene.specimen.is_node(grid.node_at(node)))
      continue;
    const Vec3 rest = scene.specimen.position(grid.node_at(node));
    Eigen::Vector3d x;
    for (int a = 0; a < 3; ++a)
      x[a] = origin[a] + rest[static_cast<std::size_t>(a)] + answer.displacement(a, node);
    n += x[2] > face + 0.01 * mm && x[0] > low[0] && x[1] > low[1] && x[0] < high[0] && x[1] < high[1];
  }
  return n;
}

class ContactAgainstFemReference : public testing::TestWithParam<Case> {};

// Truth: quadratic elements with the contact nodes prescribed. And Signorini's conditions, by which the world
// has found these nodes, hold for the elements too: nothing pulls, and nothing that is free is inside the
// tool.
TEST_P(ContactAgainstFemReference, APressedBodyIsThatOfQuadraticElements) {
  const Case& what = GetParam();
  const Pressed pressed = press(block_and_tool(what), 1.75 * mm);
  const Scene scene = question_of(pressed);
  const Answer linear = fem(scene, 1), quadratic = fem(scene, 2);
  ASSERT_EQ(quadratic.status, Status::done) << quadratic.message;
  const double error = compare(scene, pressed.world.displacement(0), quadratic.displacement).relative_l2,
               error_of_q1 = compare(scene, linear.displacement, quadratic.displacement).relative_l2;
  const Force force = force_of(scene, quadratic), force_of_q1 = force_of(scene, linear);
  const double total = force_in_world(pressed);
  EXPECT_LT(error, what.error);
  EXPECT_LT(error, error_of_q1);
  EXPECT_LT(std::abs(total - force.total), std::abs(force_of_q1.total - force.total));
  EXPECT_EQ(force.pulls, 0);
  EXPECT_EQ(n_inside(pressed, scene, quadratic), 0);
}

INSTANTIATE_TEST_SUITE_P(Tools, ContactAgainstFemReference,
                         testing::Values(Case{"plane", 0.3, 16, false, 0.0054},
                                         Case{"punch", 0.3, 5, false, 0.078},
                                         Case{"plane_nearly_incompressible", 0.49, 16, false, 0.0114},
                                         Case{"punch_nearly_incompressible", 0.49, 5, false, 0.0401},
                                         Case{"plane_on_a_dome", 0.3, 16, true, 0.0686}),
                         [](const auto& kind) { return std::string(kind.param.name); });

} // namespace
} // namespace maille
