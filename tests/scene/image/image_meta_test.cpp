// MetaImage files of the tests' own making. Truth of the numbers: what the test wrote (Contract), or the
// matrix that a rotation has (Analytic).

#include "scene/image/image_writers.hpp"

namespace maille::image_tests {
namespace {

class MetaImageContract : public testing::Test {
protected:
  /// A header of 3 x 2 x 1 voxels; `fields` are further lines.
  static std::string header(const std::string& fields, const std::string& data_file = "LOCAL",
                            const std::string& type = "MET_UCHAR") {
    return "ObjectType = Image\nNDims = 3\nDimSize = 3 2 1\n" + fields + "ElementType = " + type +
           "\nElementDataFile = " + data_file + "\n";
  }
  Image read(const std::string& bytes) { return read_image(folder_.write("image.mha", bytes)); }
  std::vector<Fault> faults(const std::string& bytes) { return faults_of(folder_.write("image.mha", bytes)); }
  TemporaryFolder folder_;
};
using MetaImageAnalytic = MetaImageContract;

TEST_F(MetaImageContract, TheFilesOfAnImageAreThoseWhoseBytesAreRead) {
  const auto local = folder_.write("local.mha", header("") + "123456"),
             apart = folder_.write("apart.mhd", header("", "apart.raw")),
             outside = folder_.write("outside.mhd", header("", "../apart.raw")),
             other = folder_.write("other.nii", "no header");
  const auto data = folder_.write("apart.raw", "123456");
  using Files = std::vector<std::filesystem::path>;
  EXPECT_EQ(files_of_image(local), Files{local});
  EXPECT_EQ(files_of_image(apart), (Files{apart, data}));
  EXPECT_EQ(files_of_image(outside), Files{outside}) << "it is refused, and not read";
  EXPECT_EQ(files_of_image(other), Files{other});
}

const std::vector<float> one_to_six{1, 2, 3, 4, 5, 6};

template<class T>
void expect_read_exactly(const TemporaryFolder& folder, const std::string& type,
                         const std::vector<T>& values) {
  for (const bool is_big_endian : {false, true})
    for (const bool is_compressed : {false, true}) {
      std::string data = bytes_of(values, is_big_endian);
      if (is_compressed)
        data = deflated(data, false);
      const std::string header =
          "NDims = 3\r\nDimSize = 3 2 1\r\nElementSpacing = 3.2 3.2 1.5\r\nOffset = 1 -2 0.5\r\n"
          "BinaryDataByteOrderMSB = " +
          std::string(is_big_endian ? "True" : "False") +
          (is_compressed ? "\nCompressedData = True\nCompressedDataSize = " + std::to_string(data.size())
                         : "") +
          "\nElementType = " + type + "\nElementDataFile = ";
      std::vector<Image> images;
      images.push_back(read_image(folder.write("image.mha", header + "LOCAL\n" + data)));
      folder.write("below/image.raw", data);
      images.push_back(read_image(folder.write("image.mhd", header + "below/image.raw\n")));
      for (const Image& image : images) {
        EXPECT_EQ(image.info.size, (Index3{3, 2, 1}));
        EXPECT_EQ(image.info.spacing, (Vec3{0.0032, 0.0032, 0.0015}));
        EXPECT_EQ(image.info.origin, (Vec3{0.001, -0.002, 0.0005}));
        EXPECT_EQ(image.values, std::vector<float>(values.begin(), values.end())) << type;
      }
    }
}

TEST_F(MetaImageContract, ReadsEveryTypeLocalOrBesideCompressedOrNot) {
  expect_read_exactly<std::int8_t>(folder_, "MET_CHAR", {-128, -1, 0, 1, 2, 127});
  expect_read_exactly<std::uint8_t>(folder_, "MET_UCHAR", {0, 1, 2, 127, 128, 255});
  expect_read_exactly<std::int16_t>(folder_, "MET_SHORT", {-32768, -2, 0, 1, 258, 32767});
  expect_read_exactly<std::uint16_t>(folder_, "MET_USHORT", {0, 1, 258, 32768, 40000, 65535});
  expect_read_exactly<std::int32_t>(folder_, "MET_INT", {-16777216, -2, 0, 1, 66051, 16777216});
  expect_read_exactly<std::uint32_t>(folder_, "MET_UINT", {0, 1, 66051, 16777215, 16777216, 2147483648U});
  expect_read_exactly<std::int32_t>(folder_, "MET_LONG", {-16777216, -2, 0, 1, 66051, 16777216});
  expect_read_exactly<std::uint32_t>(folder_, "MET_ULONG", {0, 1, 66051, 16777215, 3, 4});
  expect_read_exactly<std::int64_t>(folder_, "MET_LONG_LONG", {-5, 0, 1, 66051, 16777216, 2});
  expect_read_exactly<std::uint64_t>(folder_, "MET_ULONG_LONG", {0, 1, 66051, 16777215, 3, 4});
  expect_read_exactly<float>(folder_, "MET_FLOAT", {-1.5F, 0, 0.1F, 1e-40F, 3e38F, 7});
  expect_read_exactly<double>(folder_, "MET_DOUBLE", {-1.5, 0, 0.25, 1e-3F, 3e38F, 7});
}

TEST_F(MetaImageContract, ChannelsBecomePlanes) {
  const Image image = read("NDims = 2\nDimSize = 3 1\nElementSpacing = 2 3\nElementNumberOfChannels = 2\n"
                           "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n\1\4\2\5\3\6");
  EXPECT_EQ(image.info.components, 2);
  EXPECT_EQ(image.info.size, (Index3{3, 1, 1}));
  EXPECT_EQ(image.info.spacing, (Vec3{0.002, 0.003, 0.001})); // a third axis of 1 mm
  EXPECT_EQ(image.values, one_to_six);
}

// Written axis by axis: image x goes along world (0, 1, 0), image y along (-1, 0, 0), image z along (0, 0,
// 1).
TEST_F(MetaImageAnalytic, TransformMatrixIsWrittenAxisByAxis) {
  for (const std::string name : {"TransformMatrix", "Rotation", "Orientation"}) {
    const Image image = read(header(name + " = 0 1 0 -1 0 0 0 0 1\n") + "\1\2\3\4\5\6");
    EXPECT_EQ(image.info.direction, (std::array<Vec3, 3>{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}})) << name;
  }
  const Image flat = read("NDims = 2\nDimSize = 1 1\nTransformMatrix = 0.6 0.8 -0.8 0.6\n"
                          "ElementType = MET_UCHAR\nElementDataFile = LOCAL\nx");
  expect_near(flat.info.direction, {{{0.6, -0.8, 0}, {0.8, 0.6, 0}, {0, 0, 1}}}, 1e-15);
}

TEST_F(MetaImageContract, OtherNamesForTheSameField) {
  for (const std::string name : {"Offset", "Position", "Origin"})
    EXPECT_EQ(read(header(name + " = 1 2 3\n") + "\1\2\3\4\5\6").info.origin, (Vec3{0.001, 0.002, 0.003}));
  EXPECT_EQ(read(header("ElementSize = 1 2 3\n") + "\1\2\3\4\5\6").info.spacing, (Vec3{0.001, 0.002, 0.003}));
  EXPECT_EQ(keys_of(faults(header("Offset = 1 2 3\nOrigin = 1 2 4\n") + "\1\2\3\4\5\6")), "Origin");
  EXPECT_EQ(keys_of(faults(header("Offset = 1 2 3\nOffset = 1 2 4\n") + "\1\2\3\4\5\6")), "Offset");
}

TEST_F(MetaImageContract, UnitsOfLength) {
  const auto spacing = [&](const std::string& unit) {
    return read(header("ElementSpacing = 1 2 3\nDistanceUnits = " + unit + "\n") + "\1\2\3\4\5\6")
        .info.spacing;
  };
  EXPECT_EQ(spacing("mm"), (Vec3{0.001, 0.002, 0.003}));
  EXPECT_EQ(spacing("cm"), (Vec3{0.01, 0.02, 0.03}));
  EXPECT_EQ(spacing("um"), (Vec3{1e-6, 2e-6, 3e-6}));
  EXPECT_EQ(keys_of(faults(header("DistanceUnits = inch\n") + "\1\2\3\4\5\6")), "DistanceUnits");
}

TEST_F(MetaImageContract, HeaderSizeSkipsWhatIsBeforeTheData) {
  folder_.write("image.raw", "skip\1\2\3\4\5\6");
  for (const std::string size : {"4", "-1"}) {
    const auto file = folder_.write("image.mhd", header("HeaderSize = " + size + "\n", "image.raw"));
    EXPECT_EQ(read_image(file).values, one_to_six) << size;
  }
  for (const std::string size : {"-2", "11", "9223372036854775807"})
    EXPECT_EQ(
        keys_of(faults_of(folder_.write("image.mhd", header("HeaderSize = " + size + "\n", "image.raw")))),
        "HeaderSize");
  EXPECT_EQ(keys_of(faults(header("HeaderSize = 4\n") + "\1\2\3\4\5\6")),
            "HeaderSize"); // within its own text
}

TEST_F(MetaImageContract, DataFilesOutsideTheFolderAreRefused) {
  folder_.write("outside.raw", "\1\2\3\4\5\6");
  const std::string absolute = (folder_.path() / "outside.raw").string();
  for (const std::string& name : {std::string("../outside.raw"), std::string("a/../../outside.raw"), absolute,
                                  std::string("LIST"), std::string("slice%03d.raw 1 3 1"), std::string()})
    EXPECT_EQ(keys_of(faults_of(folder_.write("below/image.mhd", header("", name)))), "ElementDataFile")
        << name;
  // A folder in the place of a file, and nothing at all.
  std::filesystem::create_directories(folder_.path() / "folder.raw");
  for (const std::string name : {"folder.raw", "missing.raw"})
    EXPECT_EQ(faults_of(folder_.write("image.mhd", header("", name))).front().expected, "a file");
}

TEST_F(MetaImageContract, TellsAllFaultsAtOnce) {
  EXPECT_EQ(
      keys_of(faults("NDims = 3\nDimSize = 3 0 1\nElementNumberOfChannels = -1\nElementSpacing = 1 nan 0\n"
                     "BinaryData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 0\nElementType = MET_OTHER\n"
                     "ElementToIntensityFunctionSlope = 2\nElementDataFile = LOCAL\n")),
      "DimSize; ElementNumberOfChannels; ElementType; BinaryData; ElementToIntensityFunctionSlope; "
      "ElementSpacing; ElementSpacing; TransformMatrix");
}

TEST_F(MetaImageContract, NamesTheFieldThatIsWrong) {
  const auto key = [&](const std::string& fields) {
    return keys_of(faults(header(fields) + "\1\2\3\4\5\6"));
  };
  EXPECT_EQ(key("ElementSpacing = 1 2\n"), "ElementSpacing");
  EXPECT_EQ(key("ElementSpacing = 1 2 3 4\n"), "ElementSpacing");
  EXPECT_EQ(key("ElementSpacing = 1 2 1e999\n"), "ElementSpacing");
  EXPECT_EQ(key("Offset = 1 2 inf\n"), "Offset");
  EXPECT_EQ(key("TransformMatrix = 1 0 0 0.1 1 0 0 0 1\n"), "TransformMatrix");
  EXPECT_EQ(key("CompressedData = maybe\n"), "CompressedData");
  EXPECT_EQ(key("CompressedData = True\n"), "data"); // it is not
  EXPECT_EQ(key("CompressedData = True\nCompressedDataSize = 7\n"), "CompressedDataSize");
  EXPECT_EQ(keys_of(faults("NDims = 4\nElementDataFile = LOCAL\n")), "NDims");
  EXPECT_EQ(keys_of(faults("NDims = 3\nElementDataFile = LOCAL\n")), "DimSize; ElementType");
  EXPECT_EQ(keys_of(faults("ObjectType = Tube\nNDims = 3\nElementDataFile = LOCAL\n")),
            "ObjectType; DimSize; ElementType");
  EXPECT_EQ(keys_of(faults(header("") + "\1\2\3\4\5")), "data"); // too short
  EXPECT_EQ(keys_of(faults("NDims = 3\n")), "ElementDataFile");  // ends before the data
  EXPECT_EQ(keys_of(faults(std::string(1 << 20, 'x'))), "");     // another format
}

TEST_F(MetaImageContract, IntegersThatFloat32CannotHoldAreAFault) {
  const std::string data = bytes_of(std::vector<std::int64_t>{0, 1, 2, 3, 4, 9007199254740993}, false);
  EXPECT_EQ(faults(header("", "LOCAL", "MET_LONG_LONG") + data).front().found, "9007199254740993");
}

} // namespace
} // namespace maille::image_tests
