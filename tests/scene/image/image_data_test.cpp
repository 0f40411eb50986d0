// Real volumes, where MAILLE_DATA says that they are. Truth of the numbers: the data's own description.

#include "maille/scene/read_scene.hpp"
#include "scene/image/image_writers.hpp"

#include <cmath>
#include <cstdlib>

namespace maille::image_tests {
namespace {

class ImageData : public testing::Test {
protected:
  void SetUp() override {
    if (std::getenv("MAILLE_DATA") == nullptr)
      GTEST_SKIP() << "MAILLE_DATA is not set: no real volumes to read";
  }
  static std::filesystem::path file(const char* name) {
    return std::filesystem::path(std::getenv("MAILLE_DATA")) / name;
  }
};

TEST_F(ImageData, CalfLabels) {
  const Image image = read_image(file("calf_mri/labels.nii.gz"));
  EXPECT_EQ(image.info.size, (Index3{160, 160, 25}));
  EXPECT_EQ(image.info.components, 1);
  expect_near(image.info.spacing, {0.003, 0.003, 0.006}, 1e-9);
  EXPECT_EQ(std::count(image.values.begin(), image.values.end(), 17.0F), 6417);
  EXPECT_EQ(
      std::count_if(image.values.begin(), image.values.end(), [](float v) { return v >= 13 && v <= 26; }),
      35588);
}

// The trace of a diffusion tensor is positive where there is muscle, and the medians of its eigenvalues add
// up to 4.58e-3 mm^2/s.
TEST_F(ImageData, CalfTensorsStandOnTheLabelsGrid) {
  const Image tensors = read_image(file("calf_mri/DTI-tensor.nii.gz"));
  const Image labels = read_image(file("calf_mri/labels.nii.gz"));
  EXPECT_EQ(tensors.info.components, 6);
  EXPECT_EQ(tensors.info.size, labels.info.size);
  expect_near(tensors.info.spacing, labels.info.spacing, 1e-9);
  expect_near(tensors.info.origin, labels.info.origin, 1e-6);
  expect_near(tensors.info.direction, labels.info.direction, 1e-6);
  const auto n = static_cast<std::size_t>(tensors.info.n_voxels());
  std::vector<float> traces;
  for (std::size_t voxel = 0; voxel < n; ++voxel)
    if (labels.values[voxel] >= 13 && labels.values[voxel] <= 26)
      traces.push_back(tensors.values[voxel] + tensors.values[n + voxel] + tensors.values[2 * n + voxel]);
  std::nth_element(traces.begin(), traces.begin() + static_cast<std::ptrdiff_t>(traces.size() / 2),
                   traces.end());
  EXPECT_NEAR(traces[traces.size() / 2], 4.58e-3, 0.1e-3);
}

/// Where the middle of a body's matter is in the image's world.
Vec3 middle_in_world(const Specimen& body) {
  Vec3 sum{};
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      Vec3 x = body.position(body.grid.cell_at(cell));
      for (std::size_t a = 0; a < 3; ++a)
        x[a] += body.grid.spacing()[a] / 2;
      for (std::size_t r = 0; r < 3; ++r)
        sum[r] += (body.placement.origin[r] + body.placement.direction[r][0] * x[0] +
                   body.placement.direction[r][1] * x[1] + body.placement.direction[r][2] * x[2]) /
                  static_cast<double>(body.n_matter_cells());
    }
  return sum;
}

// Truth: the muscle on the image's own voxels.
TEST_F(ImageData, AMuscleOnItsFibresLatticeStaysWhereItIs) {
  const auto soleus = [](const std::string& lattice) {
    return parse_scene(
        "[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\n"
        "labels = { 17 = \"muscle/soleus\" }\nfibre = { tensor_image = \"$MAILLE_DATA/calf_mri/"
        "DTI-tensor.nii.gz\" }\nlattice = \"" +
        lattice + "\"\n[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [0, 0, \"7.5 mm\"]\n");
  };
  const Specimen grid = soleus("grid").specimen, turned = soleus("fibre").specimen;
  EXPECT_NE(turned.placement.direction, grid.placement.direction);
  EXPECT_NEAR(static_cast<double>(turned.n_matter_cells()), static_cast<double>(grid.n_matter_cells()),
              0.02 * static_cast<double>(grid.n_matter_cells()));
  expect_near(middle_in_world(turned), middle_in_world(grid), 0.001); // a third of the smallest spacing
}

TEST_F(ImageData, HeadInXRays) {
  const Image image = read_image(file("head_ct/headsq.mha"));
  EXPECT_EQ(image.info.size, (Index3{64, 64, 93}));
  EXPECT_EQ(image.info.spacing, (Vec3{0.0032, 0.0032, 0.0015}));
  const auto [least, most] = std::minmax_element(image.values.begin(), image.values.end());
  EXPECT_EQ(*least, 0);
  EXPECT_EQ(*most, 3926);
}

} // namespace
} // namespace maille::image_tests
