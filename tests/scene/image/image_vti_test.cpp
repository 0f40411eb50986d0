// VTK XML image files of the tests' own making, in every encoding that VTK has and we read. Truth of the
// numbers: what the test wrote (Contract), or geometry done by hand (Analytic).

#include "scene/image/vti_writer.hpp"

#include <cmath>

namespace maille::image_tests {
namespace {

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
  const auto spacing = [&](const std::string& units, const std::string& encoding) {
    VtiFile file = small_file();
    file.encoding = encoding;
    file.is_compressed = encoding == "raw";
    std::string codes;
    for (const char c : units)
      codes += std::to_string(static_cast<int>(c)) + " ";
    file.field_arrays = {{.type = "String", .name = "Units", .text = codes + "0", .bytes = units + '\0'}};
    return read(file.bytes_of_file()).info.spacing[0];
  };
  for (const std::string encoding : {"ascii", "binary", "raw", "base64"}) {
    for (const std::string metres : {"m", "m; stress: Pa", "length: m", "lengths: m; Stress: Pa"})
      EXPECT_EQ(spacing(metres, encoding), 2.0) << metres << ' ' << encoding;
    for (const std::string others : {"mm", "lengths: mm", "Stress: m", "metal", "", "a stray m"})
      EXPECT_EQ(spacing(others, encoding), 0.002) << others << ' ' << encoding;
  }
}

TEST_F(VtiContract, RefusesByName) {
  const std::string sound = small_file().bytes_of_file();
  const auto found = [&](const std::string& from, const std::string& to) {
    std::string bytes = sound;
    EXPECT_NE(bytes.find(from), std::string::npos) << from;
    return faults(bytes.replace(bytes.find(from), from.size(), to)).front();
  };
  EXPECT_EQ(found("<VTKFile ", "<VTKFile compressor=\"vtkLZMADataCompressor\" ").found,
            "\"vtkLZMADataCompressor\"");
  EXPECT_EQ(found("ImageData\"", "RectilinearGrid\"").key, "type");
  EXPECT_EQ(found("UInt32", "UInt16").key, "header_type");
  EXPECT_EQ(found("LittleEndian", "Middle").key, "byte_order");
  EXPECT_EQ(found("encoding=\"raw\"", "encoding=\"hex\"").key, "encoding");
  EXPECT_EQ(found("format=\"appended\"", "format=\"secret\"").key, "DataArray \"Labels\" format");
  EXPECT_EQ(found("offset=\"0\"", "offset=\"-1\"").key, "DataArray \"Labels\" offset");
  EXPECT_EQ(found("offset=\"0\"", "offset=\"9223372036854775807\"").key, "DataArray \"Labels\" offset");
  EXPECT_EQ(found("offset=\"0\"", "offset=\"99999\"").key, "DataArray \"Labels\"");
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
  EXPECT_EQ(found("</Piece>", "").expected, "well-formed XML");
  EXPECT_EQ(found("   _", "   -").key, "AppendedData");
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
  for (const std::string damaged : {"1 2 3 4 5", "1 2 3 4 5 256", "1 2 3 4 5 x", "1 2 3 4 5 6.5"}) {
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
            bytes_of(std::vector<std::uint32_t>{1, 16, 6, static_cast<std::uint32_t>(deflated_bytes.size())},
                     false));
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
