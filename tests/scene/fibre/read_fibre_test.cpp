#include "maille/scene/read_scene.hpp"

#include "maille/materials/fault.hpp"
#include "scene/image/image_writers.hpp"
#include "support/mistake.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

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
  EXPECT_EQ(fault_of("{ tensor_image = \"t.nii\" }"), "specimen.fibre") << "a box has no voxels";
}

/// A row of voxels along z with labels, and their tensors, next to one another in a folder.
class TensorScene {
public:
  using Tensor = std::array<float, 6>; ///< xx yy zz xy xz yz

  TensorScene(const std::string& labels, const std::vector<Tensor>& tensors) {
    image_tests::NiftiFile file;
    file.dim = {3, 1, 1, static_cast<std::int64_t>(labels.size())};
    file.pixdim = {1, 2, 2, 3};
    file.data = labels;
    folder_.write("labels.nii", file.bytes());
    file.dim = {4, 1, 1, static_cast<std::int64_t>(labels.size()), 6};
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
TEST(ReadFibreAnalytic, VoxelsWithoutADirectionAreFilledFromTheirLabelAndCounted) {
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
    try {
      tensors.read(std::string(", smooth = ") + radius);
      FAIL() << radius << " was read";
    } catch (const InputError& error) {
      EXPECT_EQ(error.faults().at(0).key, "specimen.fibre.smooth");
    }
}

TEST(ReadFibreContract, AnImageWithoutADirectionIsAFault) {
  const TensorScene tensors(std::string("\1\1", 2), {nothing, nothing});
  try {
    tensors.read();
    FAIL() << "it was read";
  } catch (const InputError& error) {
    ASSERT_EQ(error.faults().size(), 1u);
    EXPECT_EQ(error.faults()[0].key, "specimen.fibre");
    EXPECT_EQ(error.faults()[0].line, 5);
  }
}

} // namespace
} // namespace maille
