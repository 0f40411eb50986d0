// NIfTI files of the tests' own making. Truth of the numbers: what the test wrote (Contract), or the matrix
// that a rotation has (Analytic).

#include "scene/image/image_writers.hpp"
#include "scene/image/vti_writer.hpp"
#include "support/kit.hpp"

namespace maille::image_tests {
namespace {

constexpr std::array<Vec3, 3> identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

class NiftiContract : public testing::Test {
protected:
  std::filesystem::path write(const NiftiFile& file) {
    ++n_written_;
    const std::string name = "image" + std::to_string(n_written_) + ".nii";
    return folder_.write(name, file.bytes());
  }
  TemporaryFolder folder_;

private:
  int n_written_ = 0;
};
using NiftiAnalytic = NiftiContract;

template<class T>
void expect_read_exactly(const TemporaryFolder& folder, int version, int datatype,
                         const std::vector<T>& values) {
  for (const bool is_big_endian : {false, true})
    for (const bool is_gzipped : {false, true}) {
      NiftiFile file{.version = version, .is_big_endian = is_big_endian, .dim = {3, 3, 2, 1}};
      file.datatype = datatype;
      file.bitpix = int(8 * sizeof(T));
      file.pixdim = {1, 2, 3, 0.5};
      file.data = bytes_of(values, is_big_endian);
      const std::string bytes = is_gzipped ? deflated(file.bytes(), true) : file.bytes();
      const Image image = read_image(folder.write(is_gzipped ? "image.nii.gz" : "image.nii", bytes));
      EXPECT_EQ(image.info.size, (Index3{3, 2, 1}));
      EXPECT_EQ(image.info.components, 1);
      EXPECT_EQ(image.info.spacing, (Vec3{0.002, 0.003, 0.0005}));
      EXPECT_EQ(image.info.origin, (Vec3{0, 0, 0}));
      EXPECT_EQ(image.info.direction, identity);
      EXPECT_EQ(image.values, std::vector<float>(values.begin(), values.end()))
          << "version " << version << ", type " << datatype << ", big endian " << is_big_endian;
    }
}

TEST_F(NiftiContract, ReadsEveryTypeInBothVersionsAndByteOrders) {
  for (const int version : {1, 2}) {
    expect_read_exactly<std::uint8_t>(folder_, version, 2, {0, 1, 2, 127, 128, 255});
    expect_read_exactly<std::int16_t>(folder_, version, 4, {-32768, -2, 0, 1, 258, 32767});
    expect_read_exactly<std::int32_t>(folder_, version, 8, {-16777216, -2, 0, 1, 66051, 16777216});
    expect_read_exactly<float>(folder_, version, 16, {-1.5F, 0, 0.1F, 1e-40F, 3e38F, 7});
    expect_read_exactly<double>(folder_, version, 64, {-1.5, 0, 0.25, 1e-3F, 3e38F, 7});
    expect_read_exactly<std::int8_t>(folder_, version, 256, {-128, -1, 0, 1, 2, 127});
    expect_read_exactly<std::uint16_t>(folder_, version, 512, {0, 1, 258, 32768, 40000, 65535});
    expect_read_exactly<std::uint32_t>(folder_, version, 768, {0, 1, 66051, 16777215, 16777216, 2147483648U});
    expect_read_exactly<std::int64_t>(folder_, version, 1024, {INT64_MIN, -5, 0, 1, 66051, 16777216});
    expect_read_exactly<std::uint64_t>(folder_, version, 1280,
                                       {0, 1, 66051, 16777215, 3, std::uint64_t{1} << 63});
  }
}

TEST_F(NiftiContract, FourthAndFifthAxisAreComponentsAndSlowest) {
  NiftiFile file{.dim = {5, 2, 1, 1, 2, 3}};
  file.data = std::string("\0\1\2\3\4\5\6\7\10\11\12\13", 12);
  const Image image = read_image(write(file));
  EXPECT_EQ(image.info.components, 6);
  EXPECT_EQ(image.values, (std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
  file.dim = {4, 2, 1, 1, 6};
  EXPECT_EQ(read_image(write(file)).info.components, 6);
}

TEST_F(NiftiContract, SlopeAndInterceptScale) {
  NiftiFile file{.dim = {1, 3}, .slope = 0.5, .intercept = -10, .data = std::string("\0\1\310", 3)};
  EXPECT_EQ(read_image(write(file)).values, (std::vector<float>{-10, -9.5F, 90}));
  for (const double none : {0.0, std::nan("")}) { // both mean: not scaled
    file.slope = none;
    EXPECT_EQ(read_image(write(file)).values, (std::vector<float>{0, 1, 200}));
  }
}

TEST_F(NiftiContract, UnitsOfLength) {
  NiftiFile file{.dim = {3, 1, 1, 1}, .pixdim = {1, 2, 3, 4}, .data = "x"};
  for (const auto& [units, spacing] : {std::pair{0, Vec3{0.002, 0.003, 0.004}},
                                       {1, Vec3{2, 3, 4}},
                                       {2 | 8, Vec3{0.002, 0.003, 0.004}},
                                       {3, Vec3{2e-6, 3e-6, 4e-6}}}) {
    file.units = units;
    EXPECT_EQ(read_image_info(write(file)).spacing, spacing);
  }
  file.units = 5;
  EXPECT_EQ(keys_of(faults_of(write(file))), "xyzt_units");
}

TEST_F(NiftiContract, AxesThatAreNotThereNeedNoSpacing) {
  const NiftiFile file{.dim = {2, 2, 1}, .pixdim = {1, 2, 3}, .data = "xy"};
  const ImageInfo info = read_image_info(write(file));
  EXPECT_EQ(info.size, (Index3{2, 1, 1}));
  EXPECT_EQ(info.spacing, (Vec3{0.002, 0.003, 0.001}));
}

// A turn by 30 degrees about z: quaternion (cos 15, 0, 0, sin 15 degrees), matrix ((c, -s, 0), (s, c, 0), (0,
// 0, 1)).
TEST_F(NiftiAnalytic, QuaternionOfATurnAboutZ) {
  NiftiFile file{.version = 2, .pixdim = {1, 2, 3, 4}, .data = "x"};
  file.qform = 1;
  const double angle = std::numbers::pi / 6;
  file.quatern = {0, 0, std::sin(angle / 2), 10, -20, 30};
  const double c = std::sqrt(3.0) / 2;
  ImageInfo info = read_image_info(write(file));
  expect_near(info.direction, {{{c, -0.5, 0}, {0.5, c, 0}, {0, 0, 1}}}, 1e-15);
  EXPECT_EQ(info.origin, (Vec3{0.010, -0.020, 0.030}));
  EXPECT_EQ(info.spacing, (Vec3{0.002, 0.003, 0.004}));
  file.pixdim[0] = -1; // qfac turns the third axis round
  expect_near(read_image_info(write(file)).direction, {{{c, -0.5, 0}, {0.5, c, 0}, {0, 0, -1}}}, 1e-15);
  file.version = 1; // float32 fields
  expect_near(read_image_info(write(file)).direction, {{{c, -0.5, 0}, {0.5, c, 0}, {0, 0, -1}}}, 1e-7);
}

// A third of a turn about (1, 1, 1): quaternion (1, 1, 1, 1) / 2 takes x to y, y to z and z to x.
TEST_F(NiftiAnalytic, QuaternionThatPermutesTheAxes) {
  NiftiFile file{.qform = 2, .quatern = {0.5, 0.5, 0.5, 0, 0, 0}, .data = "x"};
  expect_near(read_image_info(write(file)).direction, {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}}, 1e-15);
  // Half a turn about x: what rounding leaves of 1 - b^2 must not tilt it.
  file.version = 2;
  file.quatern = {std::sqrt(1 - 5e-8), 0, 0, 0, 0, 0};
  expect_near(read_image_info(write(file)).direction, {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}, 1e-15);
}

// Columns (0, 2, 0), (-3, 0, 0), (0, 0, 4): spacings 2, 3, 4, x to y and y to -x.
TEST_F(NiftiAnalytic, SformComesFirst) {
  NiftiFile file{.pixdim = {1, 9, 9, 9}, .qform = 1, .sform = 1, .quatern = {1, 0, 0, 7, 7, 7}, .data = "x"};
  file.srow = {0, -3, 0, 1, 2, 0, 0, 2, 0, 0, 4, 3};
  const ImageInfo info = read_image_info(write(file));
  EXPECT_EQ(info.spacing, (Vec3{0.002, 0.003, 0.004}));
  EXPECT_EQ(info.direction, (std::array<Vec3, 3>{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}));
  EXPECT_EQ(info.origin, (Vec3{0.001, 0.002, 0.003}));
}

// Axes that are off a right angle by 1e-4 (rounding of a careless writer) are evened out alike: each of the
// two turns by half of it, so the cosines become +-5e-5 (to second order).
TEST_F(NiftiAnalytic, SmallShearIsEvenedOut) {
  NiftiFile file{.version = 2, .sform = 1, .srow = {1, 1e-4, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .data = "x"};
  const ImageInfo info = read_image_info(write(file));
  expect_near(info.direction, {{{1, 5e-5, 0}, {-5e-5, 1, 0}, {0, 0, 1}}}, 1e-8);
  file.srow[1] = 2e-3;
  EXPECT_EQ(keys_of(faults_of(write(file))), "srow_x, srow_y, srow_z");
}

TEST_F(NiftiContract, IntegersThatFloat32CannotHoldAreAFault) {
  NiftiFile file{.dim = {1, 2}, .datatype = 8, .bitpix = 32};
  file.data = bytes_of<std::int32_t>(std::vector<std::int32_t>{16777216, 16777217}, false);
  EXPECT_EQ(faults_of(write(file)).front().found, "16777217");
  file.slope = 0.5; // a measured quantity, not a label
  EXPECT_EQ(read_image(write(file)).values.front(), 8388608.0F);
}

TEST_F(NiftiContract, InfinitiesStayAndFiniteValuesStayFinite) {
  NiftiFile file{.dim = {1, 2}, .datatype = 64, .bitpix = 64};
  file.data = bytes_of(std::vector<double>{INFINITY, std::nan("")}, false);
  const Image image = read_image(write(file));
  EXPECT_TRUE(std::isinf(image.values[0]));
  EXPECT_TRUE(std::isnan(image.values[1]));
  file.data = bytes_of(std::vector<double>{1, 1e39}, false);
  EXPECT_EQ(faults_of(write(file)).front().found, "1e+39");
}

TEST_F(NiftiContract, TellsAllFaultsAtOnce) {
  NiftiFile file{.dim = {3, 4, 0, -1}, .datatype = 128, .bitpix = 24};
  file.pixdim = {1, 1, 0, std::nan("")};
  file.units = 7;
  file.vox_offset = 100.5;
  EXPECT_EQ(keys_of(faults_of(write(file))),
            "dim[2]; dim[3]; datatype; xyzt_units; pixdim[2]; pixdim[3]; vox_offset");
}

TEST_F(NiftiContract, NamesTheFieldThatIsWrong) {
  const auto key = [&](auto change) {
    NiftiFile file{.dim = {3, 1, 1, 1, 1, 1, 1, 1}, .data = "x"};
    change(file);
    return keys_of(faults_of(write(file)));
  };
  EXPECT_EQ(key([](NiftiFile& file) { file.dim[0] = 0; }), "dim[0]");
  EXPECT_EQ(key([](NiftiFile& file) { file.dim[0] = 8; }), "dim[0]");
  EXPECT_EQ(key([](NiftiFile& file) { file.dim = {6, 1, 1, 1, 1, 1, 2}; }), "dim[6]");
  EXPECT_EQ(key([](NiftiFile& file) { file.dim = {5, 1, 1, 1, 0, -1}; }), "dim[4]; dim[5]");
  EXPECT_EQ(key([](NiftiFile& file) { file.datatype = 3; }), "datatype");
  EXPECT_EQ(key([](NiftiFile& file) { file.bitpix = 16; }), "bitpix");
  EXPECT_EQ(key([](NiftiFile& file) { file.magic = std::string("ni1\0", 4); }), "magic");
  EXPECT_EQ(key([](NiftiFile& file) { file.magic = "abcd"; }), "magic");
  EXPECT_EQ(key([](NiftiFile& file) { file.vox_offset = 1e30; }), "vox_offset");
  EXPECT_EQ(key([](NiftiFile& file) { file.vox_offset = 1000; }), "vox_offset");
  EXPECT_EQ(key([](NiftiFile& file) { file.pixdim[2] = INFINITY; }), "pixdim[2]");
  EXPECT_EQ(key([](NiftiFile& file) { file.pixdim[1] = -2; }), "pixdim[1]");
  EXPECT_EQ(key([](NiftiFile& file) {
              file.qform = 1, file.quatern = {1, 1, 0};
            }),
            "quatern_b, quatern_c, quatern_d");
  EXPECT_EQ(key([](NiftiFile& file) { file.slope = 1, file.intercept = INFINITY; }), "scl_inter");
  EXPECT_EQ(key([](NiftiFile& file) {
              file.qform = 1, file.quatern = {0, 0, 0, NAN};
            }),
            "qoffset_x, qoffset_y, qoffset_z");
  // Beyond 1e11 spacings doubles tell no ten-thousandth of a voxel.
  for (const float at : {2e11F, -1e30F, INFINITY})
    EXPECT_NE(
        key([&](NiftiFile& file) { file.sform = 1, file.srow = {1, 0, 0, at, 0, 1, 0, 0, 0, 0, 1, 0}; }), "");
  EXPECT_NE(key([](NiftiFile& file) { file.sform = 1, file.srow[0] = 1; }).find("srow_x"), std::string::npos);
}

// Truth: forms that are known here; what the fallback is, and how far apart they are, is said.
TEST_F(NiftiContract, FormsFallBackWithAWarning) {
  const TemporaryFolder folder;
  NiftiFile file{.dim = {3, 2, 1, 1}, .qform = 1, .sform = 2, .quatern = {0, 0, 0, 1, 2, 3}, .data = "ab"};
  const auto origin_and_warning = [&](const std::string& name) {
    const Vec3 origin = read_image_info(folder.write(name, file.bytes())).origin;
    const auto warnings = file_warnings(true);
    return fmt::format("{:.0f} {}", 1e3 * origin[0], warnings.empty() ? "" : warnings.front());
  };
  const std::string empty = origin_and_warning("empty.nii");
  EXPECT_TRUE(empty.starts_with("1 ") && empty.find("sform is empty: the qform counts") != std::string::npos)
      << empty;
  file.srow = {1, 0, 0, 11, 0, 1, 0, -3, 0, 0, 1, 6};
  const std::string apart = origin_and_warning("apart.nii");
  EXPECT_TRUE(apart.starts_with("11 ") && apart.find("up to 11.58 mm apart") != std::string::npos) << apart;
  file.srow[1] = 0.3;
  const std::string sheared = origin_and_warning("sheared.nii");
  EXPECT_TRUE(sheared.starts_with("1 ") && sheared.find("sheared") != std::string::npos) << sheared;
  file.srow = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3};
  EXPECT_EQ(origin_and_warning("same.nii"), "1 ");
  file.data += "behind";
  read_image(folder.write("longer.nii", file.bytes()));
  const auto left = file_warnings(true);
  EXPECT_TRUE(left.size() == 1 && left.front().find("6 bytes behind the 2") != std::string::npos);
}

// VTK XML image files of the tests' own making, in every encoding that VTK has and we read. Truth of the
// numbers: what the test wrote (Contract), or geometry done by hand (Analytic).

class VtiContract : public testing::Test {
protected:
  Image read(const std::string& bytes) { return read_image(folder_.write("image.vti", bytes)); }
  std::vector<Fault> faults(const std::string& bytes) { return faults_of(folder_.write("image.vti", bytes)); }
  TemporaryFolder folder_;
};
using VtiAnalytic = VtiContract;

/// A file of 3 x 2 x 1 cells of one byte.
VtiFile small_file() {
  VtiFile file;
  file.grid = R"(WholeExtent="0 3 0 2 0 1" Origin="1 2 3" Spacing="2 4 6")";
  file.arrays = {{.type = "UInt8", .text = "1 2 3 4 5 6", .bytes = "\1\2\3\4\5\6"}};
  return file;
}

const std::vector<float> one_to_six{1, 2, 3, 4, 5, 6};

template<class T>
void expect_read_exactly(const TemporaryFolder& folder, const std::string& type, const std::vector<T>& values,
                         const std::string& text) {
  for (const std::string encoding : {"ascii", "binary", "raw", "base64"})
    for (const bool is_compressed : {false, true})
      for (const bool is_wide : {false, true})
        for (const bool is_big_endian : {false, true}) {
          VtiFile file = small_file();
          file.encoding = encoding;
          file.is_compressed = is_compressed;
          file.has_wide_header = is_wide;
          file.is_big_endian = is_big_endian;
          file.block_bytes = 16; // several blocks, the last one shorter
          const VtiArray before{.type = "Int8", .name = "Before", .text = "0", .bytes = std::string(1, '\0')};
          file.field_arrays = {before};
          file.arrays = {{.type = type, .text = text, .bytes = bytes_of(values, is_big_endian)}};
          const Image image = read_image(folder.write("image.vti", file.bytes_of_file()));
          EXPECT_EQ(image.info.size, (Index3{3, 2, 1}));
          EXPECT_EQ(image.info.components, 1);
          EXPECT_EQ(image.values, std::vector<float>(values.begin(), values.end()))
              << type << ' ' << encoding << " compressed " << is_compressed << " wide " << is_wide << " big "
              << is_big_endian;
        }
}

TEST_F(VtiContract, ReadsEveryTypeInEveryEncoding) {
  expect_read_exactly<std::int8_t>(folder_, "Int8", {-128, -1, 0, 1, 2, 127}, "-128 -1 0 1 2 127");
  expect_read_exactly<std::uint8_t>(folder_, "UInt8", {0, 1, 2, 127, 128, 255}, "0 1 2\n127 128 255");
  expect_read_exactly<std::int16_t>(folder_, "Int16", {-32768, -2, 0, 1, 258, 32767},
                                    "-32768 -2 0 1 258 32767");
  expect_read_exactly<std::uint16_t>(folder_, "UInt16", {0, 1, 2, 3, 40000, 65535}, "0 1 2 3 40000 65535");
  expect_read_exactly<std::int32_t>(folder_, "Int32", {-2, 0, 1, 2, 66051, 16777216},
                                    "-2 0 1 2 66051 16777216");
  expect_read_exactly<std::uint32_t>(folder_, "UInt32", {0, 1, 2, 3, 66051, 2147483648U},
                                     "0 1 2 3 66051 2147483648");
  expect_read_exactly<std::int64_t>(folder_, "Int64", {-2, 0, 1, 2, 66051, 16777216},
                                    "-2 0 1 2 66051 16777216");
  expect_read_exactly<std::uint64_t>(folder_, "UInt64", {0, 1, 2, 3, 66051, 16777216},
                                     "0 1 2 3 66051 16777216");
  expect_read_exactly<float>(folder_, "Float32", {-1.5F, 0, 0.1F, 1e-30F, 3e38F, 7},
                             "-1.5 0 0.1 1e-30 3e38 7.0");
  expect_read_exactly<double>(folder_, "Float64", {-1.5, 0, 0.25, 2, 3, 7}, " -1.5 0 0.25 2 3 7 \n");
}

// The first cell's centre is half a spacing in from the origin: 1 + 2/2, 2 + 4/2, 3 + 6/2 mm.
TEST_F(VtiAnalytic, CellsAreVoxelsWithCentresHalfASpacingIn) {
  const ImageInfo info = read(small_file().bytes_of_file()).info;
  EXPECT_EQ(info.size, (Index3{3, 2, 1}));
  EXPECT_EQ(info.spacing, (Vec3{0.002, 0.004, 0.006}));
  EXPECT_EQ(info.origin, (Vec3{0.002, 0.004, 0.006}));
}

// The extent counts from the origin, along turned axes: x of the grid is y of the world, y of the grid is -x.
// Centre of cell (1, 2, 0): (1, 2, 3) + 1.5 * 2 * (0, 1, 0) + 2.5 * 4 * (-1, 0, 0) + 0.5 * 6 * (0, 0, 1) =
// (-9, 5, 6).
TEST_F(VtiAnalytic, ExtentAndDirectionMoveTheFirstVoxel) {
  VtiFile file = small_file();
  file.grid = R"(WholeExtent="1 4 2 4 0 1" Origin="1 2 3" Spacing="2 4 6" Direction="0 -1 0 1 0 0 0 0 1")";
  const ImageInfo info = read(file.bytes_of_file()).info;
  expect_near(info.origin, {-0.009, 0.005, 0.006}, 1e-15);
  EXPECT_EQ(info.direction, (std::array<Vec3, 3>{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}));
}

// A flat grid has one layer of cells, which lies in the points' plane: no half spacing along z.
TEST_F(VtiAnalytic, FlatGridsAndPointData) {
  VtiFile file = small_file();
  file.grid = R"(WholeExtent="0 3 0 2 5 5" Origin="0 0 0" Spacing="2 4 6")";
  EXPECT_EQ(read(file.bytes_of_file()).info.origin, (Vec3{0.001, 0.002, 0.030}));
  file.has_cell_data = false; // points: 4 x 3 x 1
  EXPECT_EQ(keys_of(faults(file.bytes_of_file())), "DataArray \"Labels\"");
  file.grid = R"(WholeExtent="0 2 0 1 5 5" Origin="0 0 0" Spacing="2 4 6")";
  const Image image = read(file.bytes_of_file());
  EXPECT_EQ(image.info.size, (Index3{3, 2, 1}));
  EXPECT_EQ(image.info.origin, (Vec3{0, 0, 0.030}));
  EXPECT_EQ(image.values, one_to_six);
}

TEST_F(VtiContract, TakesTheActiveScalarsElseTheOnlyArray) {
  VtiFile file = small_file();
  VtiArray other = file.arrays.front();
  other.name = "Other";
  other.bytes = "\6\5\4\3\2\1";
  VtiArray ghosts = other;
  ghosts.name = "vtkGhostType";
  file.arrays = {ghosts, file.arrays.front()};
  EXPECT_EQ(read(file.bytes_of_file()).values, one_to_six);
  file.arrays.push_back(other);
  EXPECT_EQ(faults(file.bytes_of_file()).front().found, "\"Labels\" of CellData, \"Other\" of CellData");
  file.attributes = R"(Scalars="Other")";
  EXPECT_EQ(read(file.bytes_of_file()).values, (std::vector<float>{6, 5, 4, 3, 2, 1}));
}

TEST_F(VtiContract, ComponentsBecomePlanes) {
  VtiFile file = small_file();
  file.grid = R"(WholeExtent="0 3 0 1 0 1" Origin="0 0 0" Spacing="1 1 1")";
  file.arrays.front().components = 2;
  file.arrays.front().bytes = "\1\4\2\5\3\6";
  const Image image = read(file.bytes_of_file());
  EXPECT_EQ(image.info.components, 2);
  EXPECT_EQ(image.values, one_to_six);
}

TEST_F(VtiContract, UnitsInTheFieldData) {
  WorldAxes world{};
  const auto spacing = [&](const std::string& units, const std::string& encoding) {
    VtiFile file = small_file();
    file.encoding = encoding;
    file.is_compressed = encoding == "raw";
    std::string codes;
    for (const char c : units)
      codes += std::to_string(int(c)) + " ";
    file.field_arrays = {{.type = "String", .name = "Units", .text = codes + "0", .bytes = units + '\0'}};
    const ImageInfo info = read(file.bytes_of_file()).info;
    world = info.states_world ? info.world : WorldAxes::unknown;
    return info.spacing[0];
  };
  for (const std::string encoding : {"ascii", "binary", "raw", "base64"}) {
    for (const std::string metres : {"m", "m; stress: Pa", "length: m", "lengths: m; Stress: Pa"})
      EXPECT_EQ(spacing(metres, encoding), 2.0) << metres << ' ' << encoding;
    for (const std::string others : {"mm", "lengths: mm", "Stress: m", "metal", "", "a stray m"})
      EXPECT_EQ(spacing(others, encoding), 0.002) << others << ' ' << encoding;
    EXPECT_EQ(world, WorldAxes::unknown);
    EXPECT_EQ(spacing("lengths: m; Stress: Pa; world: RAS", encoding), 2.0);
    EXPECT_EQ(world, WorldAxes::ras);
  }
}

TEST_F(VtiContract, RefusesByName) {
  const std::string sound = small_file().bytes_of_file();
  const auto found = [&](const std::string& from, const std::string& to) {
    std::string bytes = sound;
    EXPECT_NE(bytes.find(from), std::string::npos) << from;
    return faults(bytes.replace(bytes.find(from), from.size(), to)).front();
  };
  EXPECT_EQ(found("UInt32", "UInt16").found, "Unsupported header_type=\"UInt16\"");
  EXPECT_EQ(found("LittleEndian", "Middle").found, "Unsupported byte_order=\"Middle\"");
  EXPECT_TRUE(test::has(found("</Piece>", "").found, "mismatched tag"));
  for (const std::string offset : {"-1", "9223372036854775807", "99999"})
    EXPECT_EQ(found("offset=\"0\"", "offset=\"" + offset + '"').key, "DataArray \"Labels\"") << offset;
  EXPECT_EQ(found("encoding=\"raw\"", "encoding=\"hex\"").key, "DataArray \"Labels\"");
  EXPECT_EQ(found("   _", "   -").key, "DataArray \"Labels\"");
  EXPECT_EQ(found("<VTKFile ", "<VTKFile compressor=\"vtkLZMADataCompressor\" ").key, "DataArray \"Labels\"");
  EXPECT_EQ(found("UInt8", "Bit").key, "DataArray \"Labels\" type");
  EXPECT_EQ(found("NumberOfComponents=\"1\"", "NumberOfComponents=\"0\"").key, "NumberOfComponents");
  EXPECT_EQ(found("Spacing=\"2 4 6\"", "Spacing=\"2 0 6\"").key, "Spacing");
  EXPECT_EQ(found("Spacing=\"2 4 6\"", "Spacing=\"2 4\"").key, "Spacing");
  EXPECT_EQ(found("Origin=\"1 2 3\"", "Origin=\"1 2 nan\"").key, "Origin");
  EXPECT_EQ(found("Origin=", "Direction=\"1 0 0 0.1 1 0 0 0 1\" Origin=").key, "Direction");
  EXPECT_EQ(found("WholeExtent=\"0 3 0", "WholeExtent=\"5 3 0").key, "WholeExtent");
  EXPECT_EQ(found("Extent=\"0 3 0 2 0 1\">", "Extent=\"0 1 0 2 0 1\">").key, "Piece Extent");
  EXPECT_EQ(found("</Piece>", "</Piece><Piece></Piece>").key, "Piece");
  EXPECT_EQ(found("<DataArray", "<DataFrame").expected, "a DataArray");
}

TEST_F(VtiContract, RefusesDamagedData) {
  VtiFile file = small_file();
  file.encoding = "binary";
  const std::string sound = file.bytes_of_file(); // base64 of 6 0 0 0 1 2 3 4 5 6 is BgAAAAECAwQFBg==
  ASSERT_NE(sound.find("BgAAAAECAwQFBg=="), std::string::npos);
  for (const std::string damaged : {"BgAAAAECAwQFBg=", "BgAAAAECAwQFBg", "BgAA*AECAwQFBg==", "BgAAAAECAwQF",
                                    "", "B===", "BwAAAAECAwQFBgc=", "////////"}) {
    std::string bytes = sound;
    bytes.replace(bytes.find("BgAAAAECAwQFBg=="), 16, damaged);
    EXPECT_NE(keys_of(faults(bytes)), "") << damaged;
  }
  file.encoding = "ascii";
  for (const std::string damaged :
       {"1 2 3 4 5", "1 2 3 4 5 6 7", "1 2 3 4 5 x", "1 2 3 4 5 256", "1 2 3 4 5 6.5"}) {
    file.arrays.front().text = damaged;
    EXPECT_NE(keys_of(faults(file.bytes_of_file())), "") << damaged;
  }
}

// Blocks: 1 of 16 bytes, the last of 6, 14 bytes deflated. Each lie about them is found.
TEST_F(VtiContract, RefusesLyingBlocks) {
  VtiFile file = small_file();
  file.is_compressed = true;
  file.block_bytes = 16;
  const std::string sound = file.bytes_of_file();
  const std::size_t at = sound.find("   _") + 4;
  const std::string deflated_bytes = deflated("\1\2\3\4\5\6", false);
  ASSERT_EQ(sound.substr(at, 16),
            bytes_of(std::vector<std::uint32_t>{1, 16, 6, std::uint32_t(deflated_bytes.size())}, false));
  EXPECT_EQ(read(sound).values, one_to_six);
  for (std::size_t word = 0; word < 4; ++word)
    for (const std::uint32_t lie : {0U, 2U, 5U, 7U, 1000U, 4294967295U}) {
      if (word == 1 && lie > 6)
        continue; // the size of a full block is ignored if there are none
      std::string bytes = sound;
      EXPECT_NE(keys_of(faults(bytes.replace(at + 4 * word, 4, bytes_of(lie, false)))), "")
          << word << ' ' << lie;
    }
}

} // namespace
} // namespace maille::image_tests
