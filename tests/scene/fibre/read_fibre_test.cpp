#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "maille/scene/scene.hpp"
#include "scene/image/image_writers.hpp"
#include "support/bodies/carved.hpp"
#include "support/kit.hpp"

#include <Eigen/Cholesky>

namespace maille {
namespace {

using std::numbers::pi;

std::string scene_with(const std::string& specimen) {
  return "[specimen]\n" + specimen + "\n[[hold]]\nwhere = \"z-\"\n";
}

const std::string box = R"(shape = "box"
cells = [4, 2, 4]
spacing = "1 mm"
material = "muscle/soleus"
)";

double turn(const Specimen& body, std::int64_t cell) {
  const Vec3 f = body.fibre_of(cell);
  return std::atan2(f[2], f[0]);
}

TEST(ReadFibreAnalytic, CellsTakeTheDirectionOfTheNearestPointOfACurve) {
  // A corner from x to z at (4, 0, 0) mm: cells nearer to the first piece are below the diagonal.
  const Scene scene = parse_scene(
      scene_with(box + "fibre = { curve = [[0, 0, 0], [\"4 mm\", 0, 0], [\"4 mm\", 0, \"4 mm\"]] }"));
  const Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const Index3 at = body.grid.cell_at(cell);
    const double x = (at[0] + 0.5) / 4, z = (at[2] + 0.5) / 4; // along each piece, 0 to 1
    // At the corner 45 degrees, at the ends 0 and 90; between them the blend of the two, both of length 1.
    const double c = std::cos(pi / 4), s = std::sin(pi / 4);
    const double first = std::atan2(x * s, 1 - x + x * c), second = std::atan2(z + (1 - z) * s, (1 - z) * c);
    if (x + z == 1) // both pieces are as near
      continue;
    EXPECT_NEAR(turn(body, cell), x + z < 1 ? first : second, 1e-6) << at[0] << " " << at[2];
  }
  EXPECT_EQ(body.fibre_report.source, "curve");
}

TEST(ReadFibreAnalytic, BipennateFibresMirrorAtTheirSeam) {
  const double angle = 25 * pi / 180;
  const std::string fibre = "fibre = { angle = \"25 deg\", plane = \"xz\", bipennate = ";
  const Specimen middle = parse_scene(scene_with(box + fibre + "true }")).specimen;
  const Specimen low = parse_scene(scene_with(box + fibre + "\"1 mm\" }")).specimen;
  const Specimen seam = parse_scene(scene_with(box + fibre + "\"1.5 mm\" }")).specimen;
  const Specimen none = parse_scene(scene_with(box + fibre + "false }")).specimen;
  EXPECT_TRUE(none.fibres.empty());
  for (int z = 0; z < 4; ++z) {
    const std::int64_t cell = middle.grid.cell({1, 1, z});
    EXPECT_NEAR(turn(middle, cell), z < 2 ? -angle : angle, 1e-6);
    EXPECT_NEAR(turn(low, cell), z < 1 ? -angle : angle, 1e-6);
    EXPECT_NEAR(turn(seam, cell), z < 1 ? -angle : z > 1 ? angle : 0, 1e-6);
  }
}

TEST(ReadFibreContract, FaultsNameTheirLineAndKey) {
  const auto fault_of = [&](const std::string& fibre) {
    const Fault fault = test::only_fault_of([&] { parse_scene(scene_with(box + "fibre = " + fibre)); });
    EXPECT_EQ(fault.line, 6) << to_string(fault);
    return fault.key;
  };
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0]] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], [0, 0, 0]] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], [\"1 m\", 0, 0], [\"0.5 m\", 0, 0]] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], [\"1 m\", 0, 0], [0, 0, 0]] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], \"1 mm\"] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], [\"1 kPa\", 0, 0]] }"), "specimen.fibre.curve");
  EXPECT_EQ(fault_of("{ curve = [[0, 0, 0], [\"1 m\", 0, 0]], smooth = 1 }"), "specimen.fibre.smooth");
  EXPECT_EQ(fault_of("{ angle = \"0.3 rad\", plane = \"xz\", bipennate = \"1 kPa\" }"),
            "specimen.fibre.bipennate");
  EXPECT_EQ(fault_of("{ angle = \"0.3 rad\", plane = \"xz\", bipennate = \"3 m\" }"),
            "specimen.fibre.bipennate");
  EXPECT_EQ(fault_of("{ tensor_image = \"t.nii\" }"), "specimen.fibre") << "a box has no voxels";
}

/// A row of voxels along z with labels, and their tensors, next to one another in a folder.
class TensorScene {
public:
  using Tensor = std::array<float, 6>; ///< xx yy zz xy xz yz

  TensorScene(const std::string& labels, const std::vector<Tensor>& tensors) {
    image_tests::NiftiFile file;
    file.dim = {3, 1, 1, std::int64_t(labels.size())};
    file.pixdim = {1, 2, 2, 3};
    file.data = labels;
    folder_.write("labels.nii", file.bytes());
    file.dim = {4, 1, 1, std::int64_t(labels.size()), 6};
    file.pixdim = {1, 2, 2, 3, 1};
    file.datatype = 16;
    file.bitpix = 32;
    file.data.clear();
    for (std::size_t component = 0; component < 6; ++component)
      for (const Tensor& tensor : tensors)
        file.data += image_tests::bytes_of(tensor[component], false);
    folder_.write("tensors.nii", file.bytes());
  }
  Scene read(const std::string& fibre = "", const std::string& more = "") const {
    return read_scene(folder_.write(
        "scene.toml",
        scene_with("shape = \"image\"\nimage = \"labels.nii\"\nlabels = { \"1..9\" = \"muscle/soleus\" }\n" +
                   more + "fibre = { tensor_image = \"tensors.nii\"" + fibre + " }")));
  }

private:
  image_tests::TemporaryFolder folder_;
};

constexpr TensorScene::Tensor along_x{3, 1, 1, 0, 0, 0}, along_y{1, 3, 1, 0, 0, 0}, nothing{};
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

// Truth: the eigenvectors of diagonal tensors are the axes; what is no diffusion is counted by what it is.
TEST(ReadFibreAnalytic, VoxelsWithoutADirectionAreFilled) {
  const TensorScene tensors(std::string("\1\1\1\1\1\2\2\3", 8), {along_x,
                                                                 nothing,
                                                                 {not_a_number, 1, 1, 0, 0, 0},
                                                                 {3, -1, 1, 0, 0, 0},
                                                                 {2, 2, 2, 0, 0, 0},
                                                                 nothing,
                                                                 along_y,
                                                                 {3, 3, 1, 0, 0, 0}});
  const Specimen body = tensors.read().specimen;
  const auto along = [&](std::int64_t cell, std::size_t axis) { return std::abs(body.fibre_of(cell)[axis]); };
  for (std::int64_t cell = 0; cell < 5; ++cell)
    EXPECT_NEAR(along(cell, 0), 1, 1e-6) << cell;
  EXPECT_NEAR(along(5, 1), 1, 1e-6) << "its neighbour on the other side is of another label";
  EXPECT_NEAR(along(6, 1), 1, 1e-6);
  const FibreReport& report = body.fibre_report;
  EXPECT_EQ(report.cells, 8);
  EXPECT_EQ(report.no_tensor, 3);
  EXPECT_EQ(report.not_positive, 1);
  EXPECT_EQ(report.isotropic, 2);
  EXPECT_EQ(report.from_neighbours, 5);
  EXPECT_EQ(report.from_label, 0);
  EXPECT_EQ(report.from_body, 1) << "nothing with label 3 has a direction";
  EXPECT_EQ(report.smoothing_radius, 0);
}

TEST(ReadFibreAnalytic, SmoothingStopsAtLabelsThoughTheirMaterialIsOne) {
  const TensorScene::Tensor plus{2, 2, 1, 0.5f, 0, 0}; // 45 degrees in xy
  const TensorScene::Tensor tilted{3, 1, 1, 0.2f, 0, 0}, back{3, 1, 1, -0.2f, 0, 0};
  const TensorScene tensors(std::string("\1\1\2\2", 4), {tilted, back, plus, plus});
  const Specimen body = tensors.read(", smooth = \"4 mm\"").specimen;
  EXPECT_NEAR(std::abs(body.fibre_of(0)[0]), 1, 1e-6);
  EXPECT_NEAR(std::abs(body.fibre_of(1)[0]), 1, 1e-6);
  EXPECT_NEAR(body.fibre_of(2)[0] * body.fibre_of(2)[1], 0.5, 1e-6);
  EXPECT_DOUBLE_EQ(body.fibre_report.smoothing_radius, 4e-3);
  // tan 2 phi = 2 xy / (xx - yy) = 0.2 for the first two cells, which turn by phi; the others stay.
  EXPECT_NEAR(body.fibre_report.smoothing_turn, std::atan(0.2) / 2 / 2, 1e-6);
}

TEST(ReadFibreAnalytic, CoarseCellsTakeTheTensorsOfTheirOwnLabel) {
  const TensorScene tensors(std::string("\1\1\1\2", 4), {along_x, along_x, along_x, {1, 90, 1, 0, 0, 0}});
  const Specimen body = tensors.read("", "coarsen = [1, 1, 4]\n").specimen;
  ASSERT_EQ(body.grid.n_cells(), 1);
  EXPECT_NEAR(std::abs(body.fibre_of(0)[0]), 1, 1e-6);
}

TEST(ReadFibreContract, ARadiusIsALengthOfZeroOrMore) {
  const TensorScene tensors(std::string("\1\1", 2), {along_x, along_y});
  EXPECT_EQ(tensors.read(", smooth = 0").specimen.fibre_report.smoothing_radius, 0);
  for (const char* radius : {"\"-1 mm\"", "\"1 kPa\"", "true"})
    EXPECT_TRUE(
        test::says_only(test::faults_found_by([&] { tensors.read(std::string(", smooth = ") + radius); }),
                        {.key = "specimen.fibre.smooth"}));
}

TEST(ReadFibreContract, AnImageWithoutADirectionIsAFault) {
  const TensorScene tensors(std::string("\1\1", 2), {nothing, nothing});
  EXPECT_TRUE(
      test::says_only(test::faults_found_by([&] { tensors.read(); }), {.line = 5, .key = "specimen.fibre"}));
}

constexpr double pull = 30e3;

/// A carved body whose fibres turn from cell to cell, every third cell of which contracts more than the one
/// before.
Scene contracting_body() {
  Scene scene = test::carved_body({5, 4, 6}, test::Fibres::turning);
  scene.active_stress.resize(std::size_t(scene.specimen.grid.n_cells()));
  for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
    scene.active_stress[cell] = pull * double(cell % 3);
  return scene;
}

// Truth: a stress in equilibrium with itself inside each cell has neither a resultant nor a moment.
TEST(ActiveStressAnalytic, ItsForcesAndTheirMomentsAddUpToNothing) {
  const Scene scene = contracting_body();
  const Grid& grid = scene.specimen.grid;
  std::array<List<double>, 3> force;
  double size = 0;
  for (int b = 0; b < 3; ++b) {
    force[std::size_t(b)] = nodal_forces(scene, b);
    for (const double f : force[std::size_t(b)])
      size += std::abs(f);
  }
  EXPECT_GT(size, 0);
  Vec3 sum{}, moment{};
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(grid.node_at(node));
    const auto i = std::size_t(node);
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
    scene.active_stress.assign(std::size_t(scene.specimen.grid.n_cells()), pull);
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
    EXPECT_EQ(part.active_stress[std::size_t(cell)], x < 3 || x > 8 ? 0 : x == 4 || x == 5 ? 40e3 : 10e3);
  }
  EXPECT_FALSE(parse_scene(with_load("gravity = [0, 0, -9.81]")).contracts());
}

TEST(ActiveStressContract, LabelsOfAnImageChooseCellsThoughTheirMaterialIsOne) {
  const image_tests::TemporaryFolder folder;
  image_tests::NiftiFile file;
  file.dim = {3, 1, 1, 6};
  file.data = std::string("\0\1\2\1\5\7", 6);
  folder.write("labels.nii", file.bytes());
  const auto pulling = [&](const std::string& labels) {
    return folder.write("scene.toml",
                        "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = { \"1..9\" = "
                        "\"muscle/soleus\" }\nfibre = [1, 0, 0]\n"
                        "[[hold]]\nwhere = \"z-\"\n[[load]]\ncontraction = 5\nlabels = " +
                            labels + "\n");
  };
  const Scene scene = read_scene(pulling("[2, \"4..6\"]"));
  EXPECT_EQ(scene.active_stress, (std::vector<double>{0, 5, 0, 5, 0}));
  const Fault absent = test::only_fault_of([&] { read_scene(pulling("[2, 3, \"8..9\"]")); });
  EXPECT_EQ(absent.found, "3, 8..9, which none has");
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
