/// Values of cells on the voxels of an image, and the files that hold them.
#include "maille/images/write_image.hpp"
#include "maille/scene/voxel_map.hpp"

#include "support/kit.hpp"
#include "support/label_scene.hpp"

namespace maille {
namespace {

/// Truth: every voxel by itself: its cell is found from its middle in the world.
TEST(VoxelMapOracle, EveryVoxelHasTheValuesOfTheCellThatItsMiddleIsIn) {
  const test::LabelArray body = test::bent_body();
  for (const test::Orientation& orientation : test::all_orientations())
    for (const int coarsen : {1, 2}) {
      const test::LabelArray array = test::turned(body, orientation);
      image_tests::TemporaryFolder folder;
      folder.write("labels.nii", test::nifti_of(array));
      const Scene scene = read_scene(folder.write(
          "scene.toml",
          "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nmaterial = \"fat/subcutaneous\"\n"
          "coarsen = " +
              std::to_string(coarsen) + "\n[[hold]]\nwhere = \"x-\"\n"));
      const Specimen& specimen = scene.specimen;
      const ImageInfo info = read_image_info(specimen.image);
      const auto image = on_voxels(info, specimen, 3, [](std::int64_t cell, std::span<float> values) {
        for (std::size_t c = 0; c < 3; ++c)
          values[c] = float(1 + 10 * cell) + float(c);
      });
      ASSERT_TRUE(image);
      std::int64_t voxel = 0, marked = 0;
      for (const Index3& at : test::all_below(info.size)) {
        Vec3 world = info.origin;
        for (std::size_t r = 0; r < 3; ++r)
          for (std::size_t a = 0; a < 3; ++a)
            world[r] += info.direction[r][a] * info.spacing[a] * at[a];
        const Vec3 x = point_in_object(specimen.placement, world);
        Index3 cell{};
        for (std::size_t a = 0; a < 3; ++a)
          cell[a] = int(std::floor((x[a] - specimen.origin[a]) / specimen.grid.spacing()[a]));
        const bool is_matter = specimen.grid.has_cell(cell) && specimen.is_matter(specimen.grid.cell(cell));
        marked += is_matter ? 1 : 0;
        for (int c = 0; c < 3; ++c) {
          const float expected = is_matter ? float(1 + 10 * specimen.grid.cell(cell)) + float(c) : 0;
          EXPECT_EQ(image->values[std::size_t(c * info.n_voxels() + voxel)], expected);
        }
        ++voxel;
      }
      EXPECT_GT(marked, 0);
    }
}

/// Truth: what was written, as our reader reads it, whose numbers the image tests hold against the format.
TEST(VoxelMapContract, AFileHasTheGridAndTheValues) {
  for (const test::Orientation& orientation : test::all_orientations())
    for (const bool has_sform : {true, false}) {
      const test::LabelArray array = test::turned(test::bent_body(), orientation);
      image_tests::TemporaryFolder folder;
      const ImageInfo info = read_image_info(folder.write("labels.nii", test::nifti_of(array)));
      Image image{info, {}};
      image.info.components = 2;
      for (std::int64_t i = 0; i < 2 * info.n_voxels(); ++i)
        image.values.push_back(float(std::sin(double(i))));
      const auto file = folder.path() / "map.nii";
      write_nifti(image, file);
      if (!has_sform) {
        std::fstream header(file, std::ios::in | std::ios::out | std::ios::binary);
        header.seekp(254);
        header.write("\0\0", 2);
      }
      // A qform holds three numbers of a unit quaternion in float32; the fourth is the root of what is left.
      const double rounding = has_sform ? 3e-7 : 2e-6;
      const Image read = read_image(file);
      EXPECT_EQ(read.values, image.values);
      EXPECT_EQ(read.info.size, info.size);
      EXPECT_EQ(read.info.world, WorldAxes::ras);
      for (std::size_t r = 0; r < 3; ++r) {
        EXPECT_NEAR(read.info.origin[r], info.origin[r], 1e-8);
        EXPECT_NEAR(read.info.spacing[r], info.spacing[r], 1e-9);
        for (std::size_t a = 0; a < 3; ++a)
          EXPECT_NEAR(read.info.direction[r][a], info.direction[r][a], rounding);
      }
    }
}

/// Truth: nifti1.h: a symmetric matrix is its lower triangle row by row, and ITK's world turns x and y.
TEST(VoxelMapContract, TensorsAndFramesAreThoseOfTheFormat) {
  Image image;
  image.info.size = {1, 1, 1};
  image.info.components = 6;
  image.info.origin = {1e-3, 2e-3, 3e-3};
  image.info.world = WorldAxes::lps;
  image.values = {11, 22, 33, 12, 13, 23};
  image_tests::TemporaryFolder folder;
  write_nifti(image, folder.path() / "tensor.nii", StoredAs::tensors);
  const Image read = read_image(folder.path() / "tensor.nii");
  EXPECT_EQ(read.values, image.values);
  std::array<float, 6> stored{};
  std::ifstream(folder.path() / "tensor.nii", std::ios::binary)
      .seekg(352)
      .read(reinterpret_cast<char*>(stored.data()), sizeof stored);
  EXPECT_EQ(stored, (std::array<float, 6>{11, 12, 22, 13, 23, 33}));
  EXPECT_EQ(stored_form(folder.path() / "tensor.nii"), StoredAs::tensors);
  write_nifti(image, folder.path() / "six.nii"); // moments of a series: no matrix
  EXPECT_EQ(stored_form(folder.path() / "six.nii"), StoredAs::float32);
  Image three{image.info, {1, 2, 3}};
  three.info.components = 3;
  write_nifti(three, folder.path() / "three.nii"); // along no stated axes: no vector
  EXPECT_FALSE(read_image_info(folder.path() / "three.nii").vectors_to_world);
  std::mt19937 random(41);
  for (int n = 0; n < 40; ++n) {
    Image any = image;
    for (int& along : any.info.size)
      along = 1 + static_cast<int>(random() % 4);
    any.info.world = random() % 2 == 0 ? WorldAxes::ras : WorldAxes::lps;
    any.values.resize(static_cast<std::size_t>(6 * any.info.n_voxels()));
    std::ranges::generate(any.values, [&] { return static_cast<float>(random() % 1000) - 500; });
    for (const char* name : {"six.nii", "six.nii.gz", "six.mha", "six.nrrd"}) {
      write_image(any, folder.path() / name);
      EXPECT_EQ(read_image(folder.path() / name).values, any.values) << name;
    }
  }
  EXPECT_NEAR(read.info.origin[0], -1e-3, 1e-9);
  EXPECT_NEAR(read.info.origin[1], -2e-3, 1e-9);
  EXPECT_NEAR(read.info.origin[2], 3e-3, 1e-9);
  EXPECT_EQ(read.info.direction[0][0], -1);
  EXPECT_THROW(write_nifti(image, folder.path() / "no" / "where.nii"), std::runtime_error);
  image.values.pop_back();
  EXPECT_THROW(write_nifti(image, folder.path() / "short.nii"), std::invalid_argument);
}

} // namespace
} // namespace maille
