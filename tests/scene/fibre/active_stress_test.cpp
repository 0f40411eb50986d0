#include "maille/materials/fault.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "maille/scene/scene.hpp"
#include "scene/image/image_writers.hpp"
#include "support/bodies/carved.hpp"
#include "support/mistake.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace maille {
namespace {

constexpr double pull = 30e3;

/// A carved body whose fibres turn from cell to cell, every third cell of which contracts more than the one
/// before.
Scene contracting_body() {
  Scene scene = test::carved_body({5, 4, 6}, test::Fibres::turning);
  scene.active_stress.resize(static_cast<std::size_t>(scene.specimen.grid.n_cells()));
  for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
    scene.active_stress[cell] = pull * static_cast<double>(cell % 3);
  return scene;
}

// Truth: a stress in equilibrium with itself inside each cell has neither a resultant nor a moment.
TEST(ActiveStressAnalytic, ItsForcesAndTheirMomentsAddUpToNothing) {
  const Scene scene = contracting_body();
  const Grid& grid = scene.specimen.grid;
  std::array<List<double>, 3> force;
  double size = 0;
  for (int b = 0; b < 3; ++b) {
    force[static_cast<std::size_t>(b)] = nodal_forces(scene, b);
    for (const double f : force[static_cast<std::size_t>(b)])
      size += std::abs(f);
  }
  EXPECT_GT(size, 0);
  Vec3 sum{}, moment{};
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(grid.node_at(node));
    const auto i = static_cast<std::size_t>(node);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
      sum[a] += force[a][i];
      moment[a] += x[b] * force[c][i] - x[c] * force[b][i];
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(sum[a], 0, 1e-12 * size);
    EXPECT_NEAR(moment[a], 0, 1e-14 * size); // arms of some millimetres
  }
}

// Truth: one cell of sides h, its fibre along x, is pulled together by sigma h_y h_z / 4 at each corner.
TEST(ActiveStressAnalytic, ACellsCornersArePulledTogetherAlongItsFibre) {
  Scene scene = test::box_scene(3, {1, 1, 1}, {1e-3, 2e-3, 3e-3});
  scene.active_stress = {pull};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    EXPECT_NEAR(nodal_forces(scene, 0)[corner], (corner & 1 ? -1 : 1) * pull * 2e-3 * 3e-3 / 4, 1e-15);
    EXPECT_NEAR(nodal_forces(scene, 1)[corner], 0, 1e-15);
  }
  scene.specimen.fibre = {0, std::sqrt(0.5), std::sqrt(0.5)}; // shear yz as well: half of it on each face
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const double y = corner & 2 ? -1 : 1, z = corner & 4 ? -1 : 1;
    EXPECT_NEAR(nodal_forces(scene, 1)[corner], pull / 2 * (y * 1e-3 * 3e-3 + z * 1e-3 * 2e-3) / 4, 1e-15);
  }
}

// Truth: free matter gives way until nothing pulls at it: its stress is zero where its strain is - S sigma,
// and that of a body at rest is the fibres' own.
TEST(ActiveStressAnalytic, StressIsElasticAndActiveTogether) {
  Scene scene = test::box_scene(3, {2, 1, 1});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 6e3, 0.3, 0.4);
  scene.specimen.fibre = {0.48, 0.6, 0.64};
  scene.active_stress = {pull, 0};
  const Eigen::Matrix<double, 6, 1> free =
      scene.object_stiffness(0).ldlt().solve(-scene.object_active_stress(0));
  const auto [strain, stress] = StrainAndStress(scene, 0)(free);
  for (const double s : stress)
    EXPECT_NEAR(s, 0, 1e-9 * pull);
  const CellFields at_rest = cell_fields(scene, Displacement(scene.specimen.grid));
  EXPECT_NEAR(at_rest.stress[0][0], pull * 0.48 * 0.48, 1e-9 * pull);
  EXPECT_NEAR(at_rest.stress[0][4], pull * 0.6 * 0.64, 1e-9 * pull); // YZ
  EXPECT_NEAR(at_rest.von_mises[0], pull, 1e-9 * pull);              // of one principal stress
  EXPECT_EQ(at_rest.von_mises[1], 0);
}

// Truth: by the definition, C strain + active stress with the free directions' stresses gone, worked out from
// the whole C.
TEST(ActiveStressAnalytic, FewerDimensionsFreeTheSameDirectionsAsTheStiffness) {
  for (const int dimension : {1, 2}) {
    Scene scene = test::box_scene(dimension, dimension == 1 ? Index3{2, 1, 1} : Index3{2, 2, 1});
    scene.plane = PlaneAssumption::stress;
    scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 6e3, 0.3, 0.4);
    scene.specimen.fibre = {0.48, 0.6, 0.64};
    scene.active_stress.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), pull);
    const Eigen::VectorXd active = scene.cell_active_stress(0);
    // At the strain that this stress alone wants, matter that is free in every direction has no stress at
    // all.
    const Eigen::Matrix<double, 6, 1> free =
        scene.object_stiffness(0).ldlt().solve(-scene.object_active_stress(0));
    const Eigen::VectorXd in_plane = dimension == 1
                                         ? Eigen::VectorXd(free.head<1>())
                                         : Eigen::VectorXd(Eigen::Vector3d(free(0), free(1), free(5)));
    EXPECT_LT((scene.cell_stiffness(0) * in_plane + active).norm(), 1e-9 * pull) << dimension;
  }
}

TEST(ActiveStressAnalytic, FractionsAndHalvedCellsPullAlike) {
  const Scene scene = contracting_body();
  const Scene half = scaled(scene, 0.5), fine = refined(scene);
  for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
    EXPECT_EQ(half.active_stress[cell], 0.5 * scene.active_stress[cell]);
  // The virtual work of an affine displacement is that of the stress: the same on both lattices.
  const std::array<Vec3, 3> gradient{{{0.3, -0.2, 0.5}, {0.1, 0.7, -0.4}, {0.2, 0.6, -0.1}}};
  const auto work = [&](const Scene& s) {
    const auto u = test::affine_displacement<Displacement>(s, gradient);
    double sum = 0;
    for (int b = 0; b < 3; ++b) {
      const List<double> force = nodal_forces(s, b);
      sum += std::inner_product(force.begin(), force.end(), u.component(b).begin(), 0.0);
    }
    return sum;
  };
  EXPECT_NEAR(work(scene), work(fine), 1e-12 * std::abs(work(fine)));
}

std::string with_load(const std::string& load) {
  return "[specimen]\nshape = \"muscle\"\ncells = [12, 4, 4]\nspacing = \"1 mm\"\n"
         "material = \"muscle/vastus_lateralis\"\n"
         "tendon = { material = \"tendon/tibialis_anterior\", fraction = 0.25 }\n"
         "[[hold]]\nwhere = \"x-\"\n[[load]]\n" +
         load + "\n";
}

TEST(ActiveStressContract, CellsAreChosenByPlaceAndMaterial) {
  const auto count = [](const Scene& scene, double stress) {
    return std::count(scene.active_stress.begin(), scene.active_stress.end(), stress);
  };
  const Scene all = parse_scene(with_load("contraction = \"30 kPa\""));
  EXPECT_EQ(count(all, 30e3), all.specimen.n_matter_cells());
  EXPECT_TRUE(all.has_loads());
  const Scene belly =
      parse_scene(with_load("contraction = \"30 kPa\"\nmaterial = \"muscle/vastus_lateralis\""));
  EXPECT_EQ(count(belly, 30e3), std::ranges::count(belly.specimen.material_id, std::uint8_t{0}));
  // Whole cells in the box: x from 4 to 6 mm, all of y and z; those of a second load pull with both.
  const Scene part = parse_scene(with_load(
      "contraction = \"30 kPa\"\nwhere = { box = [[\"4 mm\", 0, 0], [\"6.5 mm\", \"4 mm\", \"4 mm\"]] }\n"
      "[[load]]\ncontraction = \"10 kPa\"\nmaterial = \"muscle/vastus_lateralis\""));
  for (std::int64_t cell = 0; cell < part.specimen.grid.n_cells(); ++cell) {
    if (!part.specimen.is_matter(cell))
      continue;
    const int x = part.specimen.grid.cell_at(cell)[0];
    EXPECT_EQ(part.active_stress[static_cast<std::size_t>(cell)], x < 3 || x > 8     ? 0
                                                                  : x == 4 || x == 5 ? 40e3
                                                                                     : 10e3);
  }
  EXPECT_FALSE(parse_scene(with_load("gravity = [0, 0, -9.81]")).contracts());
}

TEST(ActiveStressContract, LabelsOfAnImageChooseCellsThoughTheirMaterialIsOne) {
  const image_tests::TemporaryFolder folder;
  image_tests::NiftiFile file;
  file.dim = {3, 1, 1, 6};
  file.data = std::string("\0\1\2\1\5\7", 6);
  folder.write("labels.nii", file.bytes());
  const Scene scene = read_scene(folder.write(
      "scene.toml", "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = { \"1..9\" = "
                    "\"muscle/soleus\" }\nfibre = [1, 0, 0]\n"
                    "[[hold]]\nwhere = \"z-\"\n[[load]]\ncontraction = 5\nlabels = [2, \"4..6\"]\n"));
  EXPECT_EQ(scene.active_stress, (std::vector<double>{0, 5, 0, 5, 0}));
}

TEST(ActiveStressContract, FaultsNameTheirLineAndKey) {
  const auto fault_of = [](const std::string& load) {
    const Fault fault = test::only_fault_of([&] { parse_scene(with_load(load)); });
    EXPECT_GE(fault.line, 9) << to_string(fault);
    return fault.key;
  };
  EXPECT_EQ(fault_of("contraction = \"-1 kPa\""), "load[1].contraction");
  EXPECT_EQ(fault_of("contraction = \"1 mm\""), "load[1].contraction");
  EXPECT_EQ(fault_of("contraction = \"1 kPa\"\ngravity = [0, 0, 1]"), "load[1]");
  EXPECT_EQ(fault_of("contraction = \"1 kPa\"\nwhere = \"x-\""), "load[1].where");
  EXPECT_EQ(fault_of("contraction = \"1 kPa\"\nmaterial = \"bone\""), "load[1].material");
  EXPECT_EQ(fault_of("contraction = \"1 kPa\"\nlabels = 17"), "load[1].labels");
  EXPECT_EQ(fault_of("contraction = \"1 kPa\"\ncolour = 17"), "load[1].colour");
}

} // namespace
} // namespace maille
