// Real volumes, where MAILLE_DATA says that they are. Truth of the numbers: the data's own description.

#include "image_writers.hpp"

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
