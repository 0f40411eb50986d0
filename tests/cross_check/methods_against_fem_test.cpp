/// Where neighbour limits and elasticity agree, and by how much they do not elsewhere.

#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

Answer fem(const Scene& scene, int degree = 1) {
  fem_ref::Options options;
  options.degree = degree;
  return fem_ref::solve(scene, options).answer;
}

double error_of(const Scene& scene, const char* method) {
  const Answer answer = deform::solve(scene, method), reference = fem(scene);
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  EXPECT_EQ(reference.status, Status::done) << reference.message;
  return compare(scene, answer.displacement, reference.displacement).relative_l2;
}

/// A box stretched by 2 % along x, both ends clamped.
Scene stretched_box(int dimension, Index3 cells, double poisson_ratio) {
  Scene scene = test::box_scene(dimension, cells);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.02e-3 * cells[0], 0, 0});
  return scene;
}

TEST(LimitsAgainstFemReference, StretchWithoutPoissonEffectIsExact) {
  // Theory, section 3: 0 % only for nu = 0 and a stretch; then both are the linear ramp in every row of
  // links.
  EXPECT_LT(error_of(stretched_box(2, {12, 6, 1}, 0), "limits"), 1e-12);
  EXPECT_LT(error_of(stretched_box(3, {8, 4, 4}, 0), "limits"), 1e-12);
}

TEST(SweepAgainstFemReference, StretchWithoutPoissonEffectIsTheRampToTheTolerance) {
  Scene scene = stretched_box(3, {8, 4, 4}, 0);
  scene.limits.from = LimitSource::given; // wide: relaxation alone
  scene.limits.given.stretch = {2, 2, 2};
  scene.limits.given.compress = {0, 0, 0};
  scene.limits.given.shear = {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}};
  EXPECT_LT(error_of(scene, "sweep"),
            10 * scene.relaxation.tolerance); // relative to the largest move, not the L2 norm
}

TEST(LimitsAgainstFemReference, PoissonEffectIsTheErrorThatRemains) {
  // Theory, section 3, pull with both ends clamped: limits know no contraction, so the error grows with nu.
  // The bounds are those of its table for pull2d (19 % at 0.3, 48 % at 0.49), with room for another length to
  // width.
  const double at_03 = error_of(stretched_box(2, {16, 16, 1}, 0.3), "limits");
  const double at_049 = error_of(stretched_box(2, {16, 16, 1}, 0.49), "limits");
  EXPECT_GT(at_03, 0.10);
  EXPECT_LT(at_03, 0.30);
  EXPECT_GT(at_049, at_03);
  EXPECT_LT(at_049, 0.60);
}

TEST(FemReference, QuadraticAndLinearElementsApproachEachOther) {
  double last = 1;
  for (const int n : {4, 8, 16}) {
    Scene scene = stretched_box(2, {2 * n, n, 1}, 0.3);
    scene.specimen.grid = Grid(2, {2 * n, n, 1}, {1e-2 / n, 1e-2 / n, 1});
    const double difference =
        compare(scene, fem(scene, 1).displacement, fem(scene, 2).displacement).relative_l2;
    EXPECT_LT(difference, 0.6 * last); // corner singularities: at least first order, not second
    last = difference;
  }
}

/// The middle of a block's upper face pushed in.
Scene poked_block(double poisson_ratio) {
  Scene scene = test::box_scene(3, {16, 16, 8});
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  test::hold_face(scene, 2, false);
  test::move_patch(scene, {6, 6, 8}, {10, 10, 8}, {0, 0, -0.5e-3});
  return scene;
}

// Truth: quadratic elements on the same cells, which are closer to the answer than either.
TEST(CoupledAgainstFemReference, APokeIsNearerThanByLinearElementsAndDoesNotLock) {
  for (const auto& [poisson_ratio, times] : {std::pair(0.3, 1.0), std::pair(0.49, 3.0)}) {
    const Scene scene = poked_block(poisson_ratio);
    const Answer fine = fem(scene, 2), linear = fem(scene, 1), coupled = deform::solve(scene, "coupled");
    ASSERT_EQ(coupled.status, Status::done) << coupled.message;
    const double error_of_coupled = compare(scene, coupled.displacement, fine.displacement).relative_l2,
                 error_of_linear = compare(scene, linear.displacement, fine.displacement).relative_l2;
    EXPECT_LE(times * error_of_coupled, error_of_linear) << "nu " << poisson_ratio;
  }
}

// Truth: both converge to the same forces; to 1 % on this mesh.
TEST(CoupledAgainstFemReference, ReactionsAndEnergyAreThoseOfQuadraticElements) {
  Scene scene = stretched_box(3, {16, 6, 6}, 0.3);
  const Answer fine = fem(scene, 2), coupled = deform::solve(scene, "coupled");
  const double pull = test::total_reaction(scene, coupled, 0, false),
               reference = test::total_reaction(scene, fine, 0, false);
  EXPECT_NEAR(pull, reference, 0.01 * reference);
  EXPECT_NEAR(*coupled.strain_energy, *fine.strain_energy, 0.01 * *fine.strain_energy);
}

/// A box that is bent, so that linear and quadratic elements disagree.
Scene bent_box() {
  Scene scene = test::box_scene(3, {6, 2, 2});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0, 0, 0.5e-3});
  return scene;
}

// Truth: the energy is a sum over cells.
TEST(CellEnergiesReference, ThoseOfElementsAddUp) {
  for (const int degree : {1, 2}) {
    const Answer answer = fem(bent_box(), degree);
    ASSERT_EQ(answer.cell_energy.size(), 24u);
    const double sum = std::accumulate(answer.cell_energy.begin(), answer.cell_energy.end(), 0.0);
    EXPECT_NEAR(sum / answer.strain_energy.value(), 1, 1e-10);
  }
}

// Truth: bilinear shape functions keep the sum and the moment of what they hand on.
TEST(ResultantsReference, AreThoseOfTheFinerMesh) {
  const Scene scene = bent_box(), fine = refined(scene);
  const Answer there = fem(fine);
  Answer here = there;
  bring_to_coarse(scene, fine, here);
  const Mechanics expected = mechanics_of(fine, there), found = mechanics_of(scene, here);
  for (const auto list : {&Mechanics::holds, &Mechanics::moves}) {
    ASSERT_EQ((found.*list).size(), 1u);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR((found.*list)[0].force[a], (expected.*list)[0].force[a], 1e-12);
      EXPECT_NEAR((found.*list)[0].moment[a], (expected.*list)[0].moment[a], 1e-15);
    }
  }
  EXPECT_NEAR(*found.body.strain_energy, *there.strain_energy, 1e-10 * *there.strain_energy);
}

} // namespace
} // namespace maille
