// Files that lie, end early or are damaged, in all formats: they must be refused with a reason, cost nothing,
// and never bring the reader down. The same samples are a start for a fuzzer.

#include "maille/scene/read_scene.hpp"
#include "scene/image/image_writers.hpp"
#include "scene/image/vti_writer.hpp"
#include "support/kit.hpp"

#include <cstring>
#include <sys/resource.h>

namespace maille::image_tests {
namespace {

struct Sample {
  std::string name; ///< of the file
  std::string bytes;
  bool may_lose_its_end = false; ///< XML after the data that says nothing new
};

std::string some_data(std::size_t count) {
  std::string data(count, '\0');
  for (std::size_t i = 0; i < count; ++i)
    data[i] = static_cast<char>(i * i % 251);
  return data;
}

std::vector<Sample> samples() {
  NiftiFile nifti{.dim = {3, 8, 4, 2}, .sform = 1, .srow = {1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7}};
  nifti.data = some_data(64);
  NiftiFile nifti_2 = nifti;
  nifti_2.version = 2;
  nifti_2.is_big_endian = true;
  nifti_2.sform = 0;
  nifti_2.qform = 1;
  const std::string compressed = deflated(some_data(64), false);
  const std::string meta = "NDims = 3\nDimSize = 8 4 2\nElementSpacing = 1 2 3\nOffset = 1 2 3\n"
                           "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementType = MET_UCHAR\n";
  std::vector<Sample> all{{"a.nii", nifti.bytes()},
                          {"b.nii", nifti_2.bytes()},
                          {"c.nii.gz", deflated(nifti.bytes(), true)},
                          {"d.mha", meta + "ElementDataFile = LOCAL\n" + some_data(64)},
                          {"e.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + compressed}};
  for (const std::string encoding : {"ascii", "binary", "raw", "base64"})
    for (const bool is_compressed : {false, true}) {
      VtiFile vti{.grid = R"(WholeExtent="0 8 0 4 0 2" Origin="1 2 3" Spacing="2 4 6")"};
      vti.encoding = encoding;
      vti.is_compressed = is_compressed;
      vti.block_bytes = 24;
      std::string numbers;
      for (const char byte : some_data(64))
        numbers += std::to_string(static_cast<unsigned char>(byte)) + ' ';
      vti.field_arrays = {
          {.type = "String", .name = "Units", .text = "109 0", .bytes = std::string("m\0", 2)}};
      vti.arrays = {{.type = "UInt8", .text = numbers, .bytes = some_data(64)}};
      all.push_back({"f_" + encoding + std::to_string(is_compressed) + ".vti", vti.bytes_of_file(),
                     encoding == "raw" || encoding == "base64"});
    }
  return all;
}

/// Whether the file was read; anything but an image or an InputError fails the test.
bool is_read(const std::filesystem::path& file) {
  constexpr std::int64_t one_mebibyte = 1 << 20;
  try {
    const Image image = read_image(file, {one_mebibyte});
    EXPECT_EQ(static_cast<std::int64_t>(image.values.size()), image.info.n_voxels() * image.info.components);
    return true;
  } catch (const InputError& error) {
    EXPECT_STRNE(error.what(), "");
    return false;
  }
}

TEST(HostileImageContract, TruncatedFilesAreRefused) {
  const TemporaryFolder folder;
  for (const Sample& sample : samples()) {
    ASSERT_TRUE(is_read(folder.write(sample.name, sample.bytes))) << sample.name;
    // What follows appended data closes tags only; it is at most 30 characters long.
    const std::size_t longest = sample.bytes.size() - (sample.may_lose_its_end        ? 30
                                                       : sample.name.ends_with("vti") ? 2
                                                                                      : 1);
    for (std::size_t part = 0; part <= 40; ++part) {
      const std::size_t length = longest * part / 40;
      EXPECT_FALSE(is_read(folder.write(sample.name, sample.bytes.substr(0, length))))
          << sample.name << ' ' << length;
    }
  }
}

TEST(HostileImageContract, TruncatedDataIsCountedInBytes) {
  const TemporaryFolder folder;
  NiftiFile file{.dim = {3, 4, 3, 2}, .datatype = 4, .bitpix = 16, .data = some_data(30)};
  Fault fault = faults_of(folder.write("a.nii", file.bytes())).front();
  EXPECT_EQ(fault.key, "data");
  EXPECT_EQ(fault.expected, "48 bytes");
  EXPECT_EQ(fault.found, "30 bytes");
  fault = faults_of(folder.write("a.nii.gz", deflated(file.bytes(), true))).front();
  EXPECT_EQ(fault.expected + ", " + fault.found, "48 bytes, 30 bytes");
  file.data = some_data(48);
  const std::string complete = deflated(file.bytes(), true);
  fault = faults_of(folder.write("a.nii.gz", complete.substr(0, complete.size() - 4)))
              .front(); // half of the trailer
  EXPECT_EQ(fault.expected, "complete encoded data");
}

// CRC and Adler sums find every changed byte of the data; changes in a gzip header's remarks change nothing.
TEST(HostileImageContract, DamagedCompressedDataIsRefused) {
  const TemporaryFolder folder;
  NiftiFile file{.dim = {3, 8, 4, 2}, .data = some_data(64)};
  const std::string sound = deflated(file.bytes(), true);
  const std::vector<float> values = read_image(folder.write("a.nii.gz", sound)).values;
  constexpr std::size_t gzip_header = 10;
  constexpr std::size_t gzip_trailer = 8;
  for (std::size_t at = gzip_header; at < sound.size(); ++at) {
    std::string damaged = sound;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    const auto damaged_file = folder.write("a.nii.gz", damaged);
    if (at == sound.size() - gzip_trailer - 1) // the last byte of deflated data ends in unused bits
      EXPECT_TRUE(!is_read(damaged_file) || read_image(damaged_file).values == values);
    else
      EXPECT_FALSE(is_read(damaged_file)) << at;
  }
  EXPECT_EQ(read_image(folder.write("a.nii.gz", deflated(file.bytes().substr(0, 100), true) +
                                                    deflated(file.bytes().substr(100), true)))
                .values,
            values); // two members are one file
  EXPECT_FALSE(is_read(folder.write("a.nii.gz", sound + "tail")));
  EXPECT_TRUE(is_read(folder.write("a.nii.gz", file.bytes()))); // not compressed at all: what is in it counts
  EXPECT_TRUE(is_read(folder.write("a.nii", sound)));
}

TEST(HostileImageContract, ChangedBytesNeverBringTheReaderDown) {
  const TemporaryFolder folder;
  std::mt19937 random(20240607);
  for (const Sample& sample : samples()) {
    int n_refused = 0;
    for (int round = 0; round < 300; ++round) {
      std::string bytes = sample.bytes;
      for (int change = 0; change < 1 + round % 4; ++change)
        bytes[random() % bytes.size()] = static_cast<char>(random() % 256);
      n_refused += is_read(folder.write(sample.name, bytes)) ? 0 : 1;
    }
    EXPECT_GT(n_refused, 30) << sample.name;
  }
}

TEST(HostileImageContract, SizesAreCheckedBeforeAnythingIsAllocated) {
  const TemporaryFolder folder;
  // 1000 x 1000 x 1000 float32 values are 4e9 bytes.
  NiftiFile nifti{.version = 2, .dim = {3, 1000, 1000, 1000}, .data = "x"};
  VtiFile vti{.grid = R"(WholeExtent="0 1000 0 1000 0 1000" Origin="1 2 3" Spacing="2 4 6")"};
  vti.arrays = {{.type = "UInt8", .bytes = "x"}};
  const std::string meta =
      "NDims = 3\nDimSize = 1000 1000 1000\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nx";
  const std::vector<std::filesystem::path> files = {
      folder.write("a.nii", nifti.bytes()), folder.write("a.nii.gz", deflated(nifti.bytes(), true)),
      folder.write("a.mha", meta), folder.write("a.vti", vti.bytes_of_file())};
  for (const auto& file : files) {
    const Fault fault = faults_of(file, {1000000}).front();
    EXPECT_EQ(fault.expected, "at most 1000000 bytes in memory");
    EXPECT_EQ(fault.found, "4000000000 bytes (1000 x 1000 x 1000 voxels, 1 values each, as float32)");
    EXPECT_EQ(read_image_info(file).size, (Index3{1000, 1000, 1000}));
  }
  nifti.dim = {3, 1000000, 1000000, 1000000}; // 4e18 bytes; no machine has half of that
  const Fault fault = faults_of(folder.write("b.nii", nifti.bytes())).front();
  EXPECT_EQ(fault.found.substr(0, 25), "4000000000000000000 bytes");
  EXPECT_TRUE(test::has(fault.expected, "half of what is free"));
  nifti.dim = {5, 2000000000, 2000000000, 2000000000, 2000000000, 2000000000};
  EXPECT_EQ(keys_of(faults_of(folder.write("c.nii", nifti.bytes()))), "dim[4]; dim[1]");
  nifti.dim = {4, 2000000000, 2000000000, 2000000000, 2};
  EXPECT_EQ(keys_of(faults_of(folder.write("c.nii", nifti.bytes()))), "dim[1]");
  nifti.dim = {1, std::int64_t{1} << 40};
  EXPECT_EQ(keys_of(faults_of(folder.write("c.nii", nifti.bytes()))), "dim[1]");
}

/// Most memory that this process has held so far [bytes].
std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

// Two files of some hundred bytes that claim a gibibyte, which the limits allow: memory follows the file, not
// the claim.
TEST(HostileImageContract, LyingSizesCostNoMemory) {
  const TemporaryFolder folder;
  const NiftiFile nifti{.version = 2, .dim = {3, 1024, 1024, 256}, .data = "x"};
  const std::int64_t before = peak_memory();
  const auto compressed = folder.write("a.nii.gz", deflated(nifti.bytes(), true));
  EXPECT_EQ(faults_of(compressed, {std::int64_t{1} << 31}).front().expected, "268435456 bytes");
  EXPECT_EQ(faults_of(folder.write("a.nii", nifti.bytes()), {std::int64_t{1} << 31}).front().found,
            "1 bytes");
  EXPECT_LT(peak_memory() - before, std::int64_t{64} << 20);
}

// 64 MiB of zeros in some 64 KiB, behind headers that speak of 64 bytes: refused at the first byte too many.
TEST(HostileImageContract, BombsAreNotUnpacked) {
  const TemporaryFolder folder;
  const std::size_t zeros = std::size_t{64} << 20;
  const std::string bomb = deflated(std::string(zeros, '\0'), false);
  const std::string meta = "NDims = 3\nDimSize = 8 4 2\nElementType = MET_UCHAR\nCompressedData = True\n"
                           "ElementDataFile = LOCAL\n";
  NiftiFile nifti{.dim = {3, 8, 4, 2}, .data = std::string(64, '\0')};
  const auto packed =
      folder.write("a.nii.gz", deflated(nifti.bytes(), true) + deflated(std::string(zeros, '\0'), true));
  const auto meta_file = folder.write("a.mha", meta + bomb);
  VtiFile vti{.grid = R"(WholeExtent="0 8 0 4 0 2" Origin="1 2 3" Spacing="2 4 6")"};
  vti.is_compressed = true;
  vti.block_bytes = zeros;
  vti.arrays = {{.type = "UInt8", .bytes = std::string(zeros, '\0')}};
  const auto vti_file = folder.write("a.vti", vti.bytes_of_file());
  const std::int64_t before = peak_memory();
  EXPECT_EQ(faults_of(packed).front().found, "more");
  EXPECT_EQ(faults_of(meta_file).front().found, "more");
  EXPECT_EQ(faults_of(vti_file).front().found, "data that go on behind the last of 64 values");
  EXPECT_LT(peak_memory() - before, std::int64_t{16} << 20);
}

// What comes before the data is skipped, and can be packed as well.
TEST(HostileImageContract, LongWaysToTheDataAreRefused) {
  const TemporaryFolder folder;
  NiftiFile nifti{.dim = {3, 8, 4, 2}, .data = std::string(64, '\0')};
  std::string bytes = nifti.bytes();
  const float far = 1e9F;
  std::memcpy(bytes.data() + 108, &far, sizeof far);
  EXPECT_EQ(faults_of(folder.write("a.nii.gz", deflated(bytes, true))).front().key, "vox_offset");
}

TEST(HostileImageContract, OtherThingsThanFiles) {
  const TemporaryFolder folder;
  EXPECT_EQ(faults_of(folder.path() / "missing.nii").front().expected, "a file");
  EXPECT_EQ(
      faults_of(folder.write("image.png", "x")).front().expected,
      "a file that ends in .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or .vti, or a folder of DICOM files");
  for (const std::string ending : {".nii", ".nii.gz", ".mha", ".mhd", ".vti"}) {
    const auto name = folder.path() / ("folder" + ending);
    std::filesystem::create_directories(name);
    EXPECT_EQ(faults_of(name).front().expected, "a file");
    EXPECT_FALSE(is_read(folder.write("empty" + ending, "")));
    EXPECT_FALSE(is_read(folder.write("noise" + ending, some_data(5000))));
  }
  // A reader of XML that trusted this would need sixty times its size.
  std::string tags = "<VTKFile>";
  for (int i = 0; i < 300000; ++i)
    tags += "<a>";
  EXPECT_TRUE(test::has(faults_of(folder.write("tags.vti", tags)).front().found, "more memory"));
}

// Real volumes, where MAILLE_DATA says that they are. Truth of the numbers: the data's own description.

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
