#include "elastic/finite/finite_elasticity.hpp"

#include "support/bodies/bent_bar.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

/// A bar of a few cells, its material linear or neo-Hookean, with an oblique fibre that contracts.
struct Question {
  int dimension;
  PlaneAssumption plane;
  bool has_law, contracts;
};

std::vector<Question> questions() {
  std::vector<Question> all;
  for (const int dimension : {1, 2, 3})
    for (const PlaneAssumption plane : {PlaneAssumption::strain, PlaneAssumption::stress})
      for (const bool has_law : {false, true})
        for (const bool contracts : {false, true})
          if (dimension == 2 || plane == PlaneAssumption::strain)
            all.push_back({dimension, plane, has_law, contracts});
  return all;
}

Scene scene_of(const Question& asked) {
  Scene scene =
      test::box_scene(asked.dimension, {3, asked.dimension > 1 ? 2 : 1, asked.dimension > 2 ? 2 : 1});
  scene.strain = Strain::finite;
  scene.plane = asked.plane;
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 7e3, 0.3, 0.4);
  if (asked.has_law) {
    scene.materials[0].law = NeoHookean{4e3, 9e3};
    scene.materials[0].elasticity = rest_constants(*scene.materials[0].law);
  }
  scene.specimen.fibre = {0.64, 0.6, 0.48};
  if (asked.contracts)
    scene.active_stress.assign(scene.specimen.grid.n_cells(), 3e3);
  scene.specimen.tissue.assign(scene.specimen.grid.n_cells(), 1);
  scene.specimen.tissue[1] = 0.5F;
  return scene;
}

Displacement random_field(const Grid& grid, double size, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Displacement u(grid);
  for (double& value : u.values())
    value = uniform(random);
  return u;
}

double dot(const Displacement& a, const Displacement& b) {
  return std::inner_product(a.values().begin(), a.values().end(), b.values().begin(), 0.0);
}

Displacement moved(Displacement u, double step, const Displacement& along) {
  for (std::size_t i = 0; i < u.values().size(); ++i)
    u.values()[i] += step * along.values()[i];
  return u;
}

// Truth: central differences of energy and forces.
TEST(FiniteElasticityOracle, ForcesAndTangentAreDerivatives) {
  std::mt19937 random(3);
  ThreadTeam team(1);
  for (const Question& asked : questions()) {
    const Scene scene = scene_of(asked);
    const Grid& grid = scene.specimen.grid;
    const double h = grid.spacing()[0];
    const LatticeElasticity linear(scene);
    FiniteElasticity elasticity(scene, linear);
    const Displacement u = random_field(grid, 0.15 * h, random), along = random_field(grid, h, random);
    Displacement forces(grid), above(grid), below(grid), tangent(grid);
    ASSERT_TRUE(std::isfinite(elasticity.evaluate(u, forces, team)));
    constexpr double step = 1e-5;
    const double difference = (elasticity.evaluate(moved(u, step, along), above, team) -
                               elasticity.evaluate(moved(u, -step, along), below, team)) /
                              (2 * step);
    SCOPED_TRACE(testing::Message() << asked.dimension << " plane stress "
                                    << (asked.plane == PlaneAssumption::stress) << " law " << asked.has_law
                                    << " contracts " << asked.contracts);
    EXPECT_NEAR(dot(forces, along), difference, 1e-6 * std::abs(difference));
    elasticity.linearise(u, FiniteElasticity::Convexity::exact, team);
    elasticity.apply_tangent(along, tangent, team);
    double largest = 0;
    for (const double value : tangent.values())
      largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < tangent.values().size(); ++i)
      EXPECT_NEAR(tangent.values()[i], (above.values()[i] - below.values()[i]) / (2 * step), 1e-6 * largest);
  }
}

void expect_near(const Displacement& found, const Displacement& truth, double part) {
  const double largest = std::sqrt(dot(truth, truth));
  for (std::size_t i = 0; i < truth.values().size(); ++i)
    ASSERT_NEAR(found.values()[i], truth.values()[i], part * largest);
}

// Truth: the scalar law, which a body takes whose fibres contract, here by no stress at all. Runs are longer
// and shorter than vectors, broken by the other material, which has no law, and by cells without matter.
TEST(FiniteElasticityOracle, VectorsOfCellsAreTheScalarLaw) {
  std::mt19937 random(7);
  for (const double lambda : {9e3, 4e6, -2e3}) {
    Scene scene = test::box_scene(3, {11, 3, 2});
    scene.strain = Strain::finite;
    scene.materials.assign(2, scene.materials[0]);
    scene.materials[0].law = NeoHookean{4e3, lambda};
    scene.materials[0].elasticity = rest_constants(*scene.materials[0].law);
    scene.materials[1].elasticity = rest_constants(NeoHookean{7e3, lambda});
    Specimen& body = scene.specimen;
    const auto n = static_cast<std::size_t>(body.grid.n_cells());
    body.material_id.assign(n, 0);
    body.tissue.assign(n, 0.75F);
    for (const std::size_t cell : {4, 5, 17, 18, 33, 34, 35, 36, 37, 38, 39, 40, 41})
      body.material_id[cell] = 1;
    body.material_id[13] = body.material_id[30] = no_material;
    const LatticeElasticity linear(scene);
    FiniteElasticity vectors(scene, linear), scalar(scene, linear);
    scalar.set_active_stress(std::vector<double>(n, 0.0));
    ThreadTeam one(1), three(3);
    const double h = body.grid.spacing()[0];
    for (const double size : {1e-7, 0.01, 0.12}) {
      const Displacement u = random_field(body.grid, size * h, random),
                         p = random_field(body.grid, h, random);
      Displacement found(body.grid), truth(body.grid);
      const double energy = scalar.evaluate(u, truth, one);
      EXPECT_NEAR(vectors.evaluate(u, found, three), energy, 1e-12 * energy + 1e-16 * 4e3 * 1e-9);
      expect_near(found, truth, 1e-12 + 1e-15 / size); // of the difference of F and 1 / F
      for (const auto convexity :
           {FiniteElasticity::Convexity::exact, FiniteElasticity::Convexity::positive}) {
        for (FiniteElasticity* of : {&vectors, &scalar}) {
          of->linearise(u, convexity, one);
          of->apply_tangent(p, of == &vectors ? found : truth, one);
        }
        expect_near(found, truth, 1e-6); // of float32
        for (FiniteElasticity* of : {&vectors, &scalar})
          of->step_pressures(p, 0.1 * size, one); // the next tangent has pressures
      }
      for (FiniteElasticity* of : {&vectors, &scalar})
        of->forget_pressures();
    }
    Displacement inverted(body.grid), forces(body.grid);
    inverted(0, body.grid.node({5, 1, 1})) = 6 * h;
    EXPECT_EQ(vectors.evaluate(inverted, forces, one), scalar.evaluate(inverted, forces, one));
    EXPECT_EQ(vectors.n_inverted(), scalar.n_inverted());
    EXPECT_GT(vectors.n_inverted(), 0);
  }
}

// Truth: LatticeElasticity, the first order of the same question.
TEST(FiniteElasticityConsistent, TangentAtRestIsTheLattices) {
  std::mt19937 random(5);
  ThreadTeam team(1);
  for (const Question& asked : questions()) {
    if (asked.contracts)
      continue;
    const Scene scene = scene_of(asked);
    const LatticeElasticity linear(scene);
    FiniteElasticity elasticity(scene, linear);
    const Displacement rest(scene.specimen.grid), along = random_field(scene.specimen.grid, 1, random);
    Displacement tangent(rest), small(rest);
    elasticity.linearise(rest, FiniteElasticity::Convexity::exact, team);
    elasticity.apply_tangent(along, tangent, team);
    linear.apply(along, small, team);
    double largest = 0;
    for (const double value : small.values())
      largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < small.values().size(); ++i)
      EXPECT_NEAR(tangent.values()[i], small.values()[i], 1e-6 * largest)
          << asked.dimension << (asked.plane == PlaneAssumption::stress) << asked.has_law;
  }
}

} // namespace
} // namespace maille::deform
