/// Contracting fibres: closed forms, and the lattice against finite elements.

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"

#include <Eigen/Cholesky>

namespace maille {
namespace {

constexpr double pull = 2e3;

Answer fem(const Scene& scene, int degree, fem_ref::Options options = {}) {
  options.degree = degree;
  return fem_ref::solve(scene, options).answer;
}

/// A box of muscle with fibres turned in xz, contracting.
Scene contracting_box(int dimension, Index3 cells, double degrees) {
  Scene scene = test::box_scene(dimension, cells, {1e-3, 0.8e-3, 1.25e-3});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(30e3, 10e3, 4e3, 0.3, 0.4);
  const double angle = degrees * std::numbers::pi / 180;
  scene.specimen.fibre = {std::cos(angle), dimension == 2 ? std::sin(angle) : 0,
                          dimension == 3 ? std::sin(angle) : 0};
  scene.active_stress.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), pull);
  scene.relaxation.tolerance = 1e-8;
  return scene;
}

/// Holds just what keeps the body from moving rigidly: a corner, the next along x but along x, the next along
/// y along z alone.
void hold_three_corners(Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const Index3& n = grid.cells();
  const int d = scene.dimension();
  for (int b = 0; b < d; ++b) {
    scene.prescribed.push_back({grid.node({0, 0, 0}), b, 0, true});
    if (b > 0)
      scene.prescribed.push_back({grid.node({n[0], 0, 0}), b, 0, true});
    if (b > 1)
      scene.prescribed.push_back({grid.node({0, n[1], 0}), b, 0, true});
  }
  test::sort_prescribed(scene);
}

/// The displacement that hold_three_corners leaves of a constant strain: an upper triangular gradient has it
/// and turns nothing.
Displacement affine(const Scene& scene, const Eigen::VectorXd& strain) {
  std::array<Vec3, 3> gradient{};
  const int d = scene.dimension();
  for (int a = 0; a < d; ++a)
    gradient[static_cast<std::size_t>(a)][static_cast<std::size_t>(a)] = strain(a);
  if (d == 2)
    gradient[0][1] = strain(2);
  if (d == 3) {
    gradient[1][2] = strain(3);
    gradient[0][2] = strain(4);
    gradient[0][1] = strain(5);
  }
  return test::affine_displacement<Displacement>(scene, gradient);
}

// Truth: free matter strains by - C^-1 sigma a a^T, the same in every cell.
TEST(ContractionAnalytic, AFreeBodyTakesOnTheStrainThatCancelsThePull) {
  for (const auto plane : {PlaneAssumption::strain, PlaneAssumption::stress})
    for (const int dimension : {1, 2, 3}) {
      if (dimension != 2 && plane == PlaneAssumption::stress)
        continue;
      for (const double degrees : {0.0, 35.0}) {
        Scene scene = contracting_box(dimension, {8, dimension > 1 ? 3 : 1, dimension > 2 ? 4 : 1}, degrees);
        scene.plane = plane;
        hold_three_corners(scene);
        const Eigen::VectorXd strain = scene.cell_stiffness(0).ldlt().solve(-scene.cell_active_stress(0));
        const Displacement expected = affine(scene, strain);
        for (const Answer& answer : {fem(scene, 1), fem(scene, 2), deform::solve(scene, "coupled")}) {
          ASSERT_EQ(answer.status, Status::done) << answer.method << ": " << answer.message;
          EXPECT_LT(test::largest_difference(answer.displacement, expected),
                    (answer.method == "coupled" ? 1e-6 : 1e-8) * test::largest(expected))
              << answer.method << " in " << dimension << "D at " << degrees;
          if (dimension == 3) {
            const CellFields fields = cell_fields(scene, answer.displacement);
            for (const double s : fields.stress[5])
              EXPECT_NEAR(s, 0, 1e-4 * pull) << answer.method;
          }
          const double area = dimension == 3 ? 12e-6 : dimension == 2 ? 2.4e-3 : 1; // across x
          for (const double r : answer.reaction)
            EXPECT_NEAR(r, 0, 1e-4 * pull * area) << answer.method;
        }
      }
      // Along the fibre and free, it is sigma / E, by which the fibre gets shorter.
      if (dimension == 1) {
        const Scene scene = contracting_box(1, {4, 1, 1}, 0);
        EXPECT_NEAR(scene.cell_stiffness(0)(0, 0), 30e3, 1e-6);
        EXPECT_NEAR(scene.cell_active_stress(0)(0), pull, 1e-9);
      }
    }
}

// Truth: nothing moves between ends held along the fibres, and each end is pulled inwards with sigma times
// the area.
TEST(ContractionAnalytic, HeldEndsCarryThePullTimesTheArea) {
  for (const int dimension : {1, 2, 3}) {
    Scene scene = contracting_box(dimension, {8, dimension > 1 ? 3 : 1, dimension > 2 ? 4 : 1}, 0);
    if (dimension == 2)
      scene.plane = PlaneAssumption::stress;
    test::hold_face(scene, 0, false);
    test::prescribe_face(scene, 0, true, 0, 0, false); // the other end is free to get thinner
    const double area = dimension == 3 ? 3 * 0.8e-3 * 4 * 1.25e-3 : dimension == 2 ? 3 * 0.8e-3 : 1;
    for (const Answer& answer : {fem(scene, 1), fem(scene, 2), deform::solve(scene, "coupled")}) {
      ASSERT_EQ(answer.status, Status::done) << answer.method << ": " << answer.message;
      EXPECT_NEAR(test::total_reaction(scene, answer, 0, true), -pull * area, 1e-6 * pull * area)
          << answer.method;
      EXPECT_NEAR(test::total_reaction(scene, answer, 0, false), pull * area, 1e-6 * pull * area)
          << answer.method;
      for (const double u : answer.displacement.values())
        EXPECT_NEAR(u, 0, 1e-9) << answer.method;
    }
  }
}

// Truth: a specimen whose cells are drawn out and sheared is as free as one whose cells are boxes, with the
// same strain.
TEST(ContractionAnalytic, MappedCellsPullAlike) {
  Scene scene = contracting_box(3, {4, 3, 3}, 35);
  hold_three_corners(scene);
  fem_ref::Options options;
  const auto shape = [](const Vec3& x) { return Vec3{2 * x[0], x[1], x[2] + 0.1 * x[1]}; };
  options.shape = shape;
  const Eigen::VectorXd e = scene.cell_stiffness(0).ldlt().solve(-scene.cell_active_stress(0));
  for (const int degree : {1, 2}) {
    const Answer answer = fem(scene, degree, options);
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    // The corner held along z stands at z = 0.1 y, so the body turns about x until it is where it was.
    const double turn = -0.1 * e(2);
    const Grid& grid = scene.specimen.grid;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Vec3 x = shape(scene.specimen.position(grid.node_at(node)));
      EXPECT_NEAR(answer.displacement(0, node), e(0) * x[0] + e(5) * x[1] + e(4) * x[2], 1e-9);
      EXPECT_NEAR(answer.displacement(1, node), e(1) * x[1] + (e(3) - turn) * x[2], 1e-9);
      EXPECT_NEAR(answer.displacement(2, node), turn * x[1] + e(2) * x[2], 1e-9);
    }
  }
}

Scene belly(int nx, int ny) {
  return parse_scene(
      "[specimen]\nshape = \"muscle\"\ncells = [" + std::to_string(nx) + ", " + std::to_string(ny) + ", " +
      std::to_string(ny) + "]\nspacing = \"" + std::to_string(120.0 / nx) + " mm\"\n" +
      "material = { E_fibre = \"60 kPa\", E_cross = \"20 kPa\", G_fibre = \"10 kPa\", "
      "nu_fibre = 0.3, nu_cross = 0.4 }\n"
      "fibre = { angle = \"20 deg\", plane = \"xz\" }\n"
      "tendon = { material = { youngs_modulus = \"600 kPa\", poisson_ratio = 0.3, name = \"tendon\" }, "
      "fraction = 0.15 }\n"
      "[[hold]]\nwhere = \"x-\"\n[[hold]]\nwhere = \"x+\"\n"
      "[[load]]\ncontraction = \"10 kPa\"\nmaterial = \"specimen.material\"\n");
}

/// Force of the hold at x- along x.
double force_at_lower_end(const Scene& scene, const Answer& answer) {
  double force = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (scene.prescribed[i].component == 0 && scene.specimen.grid.node_at(scene.prescribed[i].node)[0] == 0)
      force += answer.reaction[i];
  return force;
}

// Truth: quadratic elements on the same cells, which the others approach as cells are halved: what differs is
// discretisation.
TEST(ContractionReference, ThePennateBellyIsTheSameWithinDiscretisation) {
  const Scene coarse = belly(16, 6);
  std::array<double, 2> of_linear{}, of_coupled{}, of_force{};
  for (std::size_t i = 0; i < 2; ++i) {
    const Scene scene = i == 0 ? coarse : refined(coarse);
    const Answer fine = fem(scene, 2), linear = fem(scene, 1), coupled = deform::solve(scene, "coupled");
    ASSERT_EQ(fine.status, Status::done) << fine.message;
    ASSERT_EQ(coupled.status, Status::done) << coupled.message;
    of_linear[i] = compare(scene, linear.displacement, fine.displacement).relative_l2;
    of_coupled[i] = compare(scene, coupled.displacement, fine.displacement).relative_l2;
    const double reference = force_at_lower_end(scene, fine);
    EXPECT_LT(reference, 0) << "a hold pulls back outwards";
    EXPECT_NEAR(test::total_reaction(scene, fine, 0, true), 0, 1e-6 * std::abs(reference)) << "in balance";
    of_force[i] = std::abs(force_at_lower_end(scene, coupled) / reference - 1);
    RecordProperty("linear" + std::to_string(i), std::to_string(of_linear[i]));
    RecordProperty("coupled" + std::to_string(i), std::to_string(of_coupled[i]));
    RecordProperty("force" + std::to_string(i), std::to_string(of_force[i]));
  }
  EXPECT_LT(of_linear[1], 0.7 * of_linear[0]);
  EXPECT_LT(of_coupled[1], 0.7 * of_coupled[0]);
  EXPECT_LT(of_force[1], 0.7 * of_force[0]);
  EXPECT_LT(of_coupled[1], 0.05);
}

TEST(ContractionContract, MethodsThatCannotCarryItSaySo) {
  const Scene scene = belly(12, 4);
  for (const std::string_view method : {"limits", "dijkstra", "literal", "sweep", "relaxed"}) {
    const Answer answer = deform::solve(scene, method);
    EXPECT_EQ(answer.status, Status::refused) << method;
    EXPECT_TRUE(test::has(answer.message, "carries no"));
  }
  Scene dead_zone = scene;
  dead_zone.relaxation.mode = RelaxationMode::deformable;
  EXPECT_EQ(deform::solve(dead_zone, "relaxed").status, Status::refused);
}

} // namespace
} // namespace maille
