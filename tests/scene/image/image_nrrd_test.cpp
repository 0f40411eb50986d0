// NRRD files of the tests' own making. Truth of the numbers: what the test wrote (Contract), or the
// directions that a header has (Analytic).

#include "maille/images/image.hpp"
#include "maille/images/write_image.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene.hpp"
#include "scene/image/image_writers.hpp"
#include "support/kit.hpp"

namespace maille::image_tests {
namespace {

class NrrdContract : public testing::Test {
protected:
  static std::string header(const std::string& fields) {
    return "NRRD0004\n# made by hand\n" + fields + "\n";
  }
  Image read(const std::string& bytes) { return read_image(folder_.write("image.nrrd", bytes)); }
  std::vector<Fault> faults(const std::string& bytes) {
    return faults_of(folder_.write("image.nrrd", bytes));
  }
  TemporaryFolder folder_;
};
using NrrdAnalytic = NrrdContract;

template<class T>
void expect_read_exactly(const TemporaryFolder& folder, const std::string& type,
                         const std::vector<T>& values) {
  for (const bool is_big_endian : {false, true})
    for (const bool is_compressed : {false, true}) {
      std::string data = bytes_of(values, is_big_endian);
      if (is_compressed)
        data = deflated(data, true);
      const std::string header = "NRRD0001\r\ntype: " + type +
                                 "\r\ndimension: 3\nsizes: 3 2 1\nspacings: 3.2 3.2 1.5\n" +
                                 "endian: " + (is_big_endian ? "big" : "little") +
                                 "\nencoding: " + (is_compressed ? "gzip" : "raw") + "\n";
      std::vector<Image> images;
      images.push_back(read_image(folder.write("image.nrrd", header + "\n" + data)));
      folder.write("below/image.raw", data);
      images.push_back(read_image(folder.write("image.nhdr", header + "data file: below/image.raw\n")));
      for (const Image& image : images) {
        EXPECT_EQ(image.info.size, (Index3{3, 2, 1}));
        EXPECT_EQ(image.info.spacing, (Vec3{0.0032, 0.0032, 0.0015}));
        EXPECT_EQ(image.info.world, WorldAxes::lps);
        EXPECT_FALSE(image.info.states_world);
        EXPECT_EQ(image.values, std::vector<float>(values.begin(), values.end())) << type;
      }
    }
}

TEST_F(NrrdContract, ReadsEveryTypeLocalOrBesideCompressedOrNot) {
  expect_read_exactly<std::int8_t>(folder_, "signed char", {-128, -1, 0, 1, 2, 127});
  expect_read_exactly<std::uint8_t>(folder_, "uchar", {0, 1, 2, 127, 128, 255});
  expect_read_exactly<std::int16_t>(folder_, "short", {-32768, -2, 0, 1, 258, 32767});
  expect_read_exactly<std::uint16_t>(folder_, "unsigned short", {0, 1, 258, 32768, 40000, 65535});
  expect_read_exactly<std::int32_t>(folder_, "int", {-16777216, -2, 0, 1, 66051, 16777216});
  expect_read_exactly<std::uint32_t>(folder_, "uint32_t", {0, 1, 66051, 16777215, 16777216, 2147483648U});
  expect_read_exactly<std::int64_t>(folder_, "longlong", {-5, 0, 1, 66051, 16777216, 2});
  expect_read_exactly<std::uint64_t>(folder_, "unsigned long long", {0, 1, 66051, 16777215, 3, 4});
  expect_read_exactly<float>(folder_, "float", {-1.5F, 0, 0.1F, 1e-40F, 3e38F, 7});
  expect_read_exactly<double>(folder_, "double", {-1.5, 0, 0.25, 1e-3F, 3e38F, 7});
}

TEST_F(NrrdContract, ComponentsBecomePlanesBeforeOrBehindTheAxesOfSpace) {
  const std::vector<float> one_to_six{1, 2, 3, 4, 5, 6};
  const std::string common = "type: uchar\nencoding: raw\nspace: left-posterior-superior\n";
  const Image first =
      read(header(common + "dimension: 4\nsizes: 2 3 1 1\nkinds: vector domain domain domain\n"
                           "space directions: none (2,0,0) (0,3,0) (0,0,4)\n") +
           "\1\4\2\5\3\6");
  const Image last = read(header(common + "dimension: 4\nsizes: 3 1 1 2\nkinds: domain domain domain list\n"
                                          "space directions: (2,0,0) (0,3,0) (0,0,4) none\n") +
                          "\1\2\3\4\5\6");
  for (const Image& image : {first, last}) {
    EXPECT_EQ(image.info.components, 2);
    EXPECT_EQ(image.info.size, (Index3{3, 1, 1}));
    EXPECT_EQ(image.values, one_to_six);
    EXPECT_EQ(image.info.world, WorldAxes::lps);
  }
}

// A slice may stand in a space of three axes: the third axis is across it.
TEST_F(NrrdAnalytic, DirectionsSpacingAndOriginAreThoseOfTheHeader) {
  const std::string slice =
      "type: uchar\nencoding: raw\ndimension: 2\nsizes: 3 2\nspace directions: (0,2,0) (0,0,3)\n"
      "space origin: (1,-2,4)\nspace: ";
  const Image lps = read(header(slice + "left-posterior-superior\n") + "123456");
  EXPECT_EQ(lps.info.world, WorldAxes::lps);
  expect_near(lps.info.spacing, {2e-3, 3e-3, std::sqrt(6.0) * 1e-3}, 1e-12);
  expect_near(lps.info.origin, {1e-3, -2e-3, 4e-3}, 1e-15);
  expect_near(lps.info.direction, {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}}, 1e-12);
  // Left to right is turned round.
  const Image las = read(header(slice + "left-anterior-superior\n") + "123456");
  EXPECT_EQ(las.info.world, WorldAxes::ras);
  expect_near(las.info.origin, {-1e-3, -2e-3, 4e-3}, 1e-15);
  expect_near(las.info.direction, {{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}}, 1e-12);
  const Image metres = read(header(slice + "RAS\nspace units: \"m\" \"m\" \"m\"\n") + "123456");
  EXPECT_EQ(metres.info.world, WorldAxes::ras);
  expect_near(metres.info.origin, {1, -2, 4}, 1e-12);
  const std::string ends = "type: uchar\ndimension: 3\nsizes: 1 2 3\nencoding: raw\naxis mins: 5 0 0\n"
                           "axis maxs: 7 3 2\ncenterings: cell cell node\n";
  const Image old = read(header(ends) + "123456");
  expect_near(old.info.spacing, {2e-3, 1.5e-3, 1e-3}, 1e-15);
  expect_near(old.info.origin, {6e-3, 0.75e-3, 0}, 1e-15);
}

TEST_F(NrrdContract, SaysWhatIsWrong) {
  const std::string good = "type: short\ndimension: 3\nsizes: 1 2 3\nendian: little\nencoding: raw\n";
  EXPECT_NO_THROW(read(header(good) + std::string(12, 'x')));
  EXPECT_EQ(keys_of(faults("NRRD0009x")), "");
  EXPECT_EQ(keys_of(faults("P5 3 2")), "");
  EXPECT_EQ(keys_of(faults(header("type: short\n") + "xx")), "dimension; dimension");
  EXPECT_EQ(keys_of(faults(header(good + "sizes: 4 4 4\n") + "xx")), "sizes");
  EXPECT_EQ(keys_of(faults(header(good) + std::string(11, 'x'))), "sizes");
  EXPECT_NO_THROW(read(header(good) + std::string(13, 'x'))); // a line end behind the data
  EXPECT_EQ(
      keys_of(faults(header("type: block\ndimension: 3\nsizes: 1 2 3\nencoding: bzip2\nspace: moon\n"))),
      "type; encoding; space");
  EXPECT_EQ(keys_of(faults(header("type: int\ndimension: 3\nsizes: 1 2 3\nencoding: raw\n") + "x")),
            "endian");
  EXPECT_EQ(keys_of(faults(header(good + "byte skip: -1\n") + std::string(12, 'x'))), "byte skip");
  EXPECT_EQ(keys_of(faults(header(good + "data file: ../outside.raw\n"))), "data file");
  EXPECT_EQ(keys_of(faults(
                header("type: uchar\ndimension: 4\nsizes: 1 2 1 1\nencoding: raw\nkinds: domain list domain "
                       "domain\n") +
                "xx")),
            "kinds");
  EXPECT_EQ(keys_of(faults(header(good + "space: RAS\nspace directions: (1,0,0) (0,1) (0,0,1)\n") +
                           std::string(12, 'x'))),
            "space directions");
  EXPECT_EQ(
      keys_of(faults(header(good + "space: RAS\nspace units: \"mm\" \"m\" \"mm\"\n") + std::string(12, 'x'))),
      "space units");
  file_warnings(true);
  read(header(good) + std::string(12, 'x'));
  EXPECT_TRUE(
      std::ranges::any_of(file_warnings(), [](const std::string& w) { return test::has(w, "no spacing"); }));
}

constexpr const char* segmentation_fields =
    "type: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 2 2\n"
    "space directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\nencoding: raw\nspace origin: "
    "(0,0,0)\n"
    "Segment0_Name:=Soleus\nSegment0_LabelValue:=3\nSegment0_Layer:=0\nSegment1_Name:=Gastrocnemius "
    "medialis\n"
    "Segment1_LabelValue:=7\nSegment1_Layer:=0\n";

TEST_F(NrrdContract, SegmentsOfSlicerAreLabelsByName) {
  const std::string data("\3\3\7\7\3\3\7\7\3\3\7\7\3\3\7\7");
  const auto file = folder_.write("calf.seg.nrrd", header(segmentation_fields) + data);
  const auto segments = named_segments(file);
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[1].name, "Gastrocnemius medialis");
  EXPECT_EQ(segments[1].label, 7);
  const Scene read =
      parse_scene("[specimen]\nshape = \"image\"\nimage = \"calf.seg.nrrd\"\n"
                  "labels = { Soleus = \"muscle/soleus\", \"Gastrocnemius medialis\" = "
                  "\"muscle/vastus_lateralis\" }\nfibre = [1, 0, 0]\n[[hold]]\nwhere = \"x-\"\n",
                  folder_.path() / "scene.toml");
  ASSERT_EQ(read.materials.size(), 2U);
  for (std::size_t cell = 0; cell < 16; ++cell)
    EXPECT_EQ(read.specimen.label[cell], cell % 4 < 2 ? 3 : 7);
  const auto faults = test::faults_found_by([&] {
    parse_scene("[specimen]\nshape = \"image\"\nimage = \"calf.seg.nrrd\"\nlabels = { Soles = "
                "\"fat/subcutaneous\" }\n" +
                    test::hold_text(),
                folder_.path() / "scene.toml");
  });
  EXPECT_TRUE(test::says_only(faults, {.expected = "Soleus, Gastrocnemius medialis"}));
}

TEST_F(NrrdContract, TheFilesOfAnImageAreThoseWhoseBytesAreRead) {
  const std::string fields = "type: uchar\ndimension: 3\nsizes: 1 2 3\nencoding: raw\n";
  const auto local = folder_.write("local.nrrd", header(fields) + "123456"),
             apart = folder_.write("apart.nhdr", header(fields + "data file: apart.raw\n")),
             data = folder_.write("apart.raw", "123456");
  using Files = std::vector<std::filesystem::path>;
  EXPECT_EQ(files_of_image(local), Files{local});
  EXPECT_EQ(files_of_image(apart), (Files{apart, data}));
}

/// Truth: what was written. The header, byte by byte, is what 3D Slicer asks of a field that carries points.
TEST_F(NrrdContract, WrittenFieldsReadBackAndSayWhatTheyAre) {
  Image field;
  field.info.size = {2, 3, 2};
  field.info.components = 3;
  field.info.spacing = {1e-3, 2e-3, 3e-3};
  field.info.origin = {0.01, 0.02, 0.03};
  field.info.world = WorldAxes::ras;
  for (int i = 0; i < 36; ++i)
    field.values.push_back(static_cast<float>(i));
  const auto file = folder_.path() / "push.nrrd";
  write_image(field, file, {StoredAs::float32, {{"displacement field type", "modeling"}}});
  const Image read = read_image(file);
  EXPECT_EQ(read.values, field.values);
  EXPECT_EQ(read.info.world, WorldAxes::lps);
  expect_near(read.info.origin, {-0.01, -0.02, 0.03}, 1e-12);
  std::string text = test::text_of(file);
  text.resize(text.find("\n\n") + 1);
  EXPECT_EQ(text, "NRRD0005\n# http://teem.sourceforge.net/nrrd/format.html\n# maille\n"
                  "type: float\ndimension: 4\n"
                  "space: left-posterior-superior\nsizes: 3 2 3 2\n"
                  "space directions: none (-1,0,0) (0,-2,0) (0,0,3)\nkinds: vector domain domain domain\n"
                  "endian: little\nencoding: gzip\nspace origin: (-10,-20,30)\n"
                  "displacement field type:=modeling\n");
  Image labels;
  labels.info.size = {2, 2, 1};
  labels.values = {0, 300, -2, 17};
  write_image(labels, folder_.path() / "labels.nrrd", {StoredAs::labels, {}});
  EXPECT_EQ(read_image(folder_.path() / "labels.nrrd").values, labels.values);
}

// MetaImage files of the tests' own making. Truth of the numbers: what the test wrote (Contract), or the
// matrix that a rotation has (Analytic).

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
void expect_meta_read_exactly(const TemporaryFolder& folder, const std::string& type,
                              const std::vector<T>& values) {
  for (const bool is_big_endian : {false, true})
    for (const bool is_compressed : {false, true}) {
      const std::string plain = bytes_of(values, is_big_endian),
                        data = is_compressed ? deflated(plain, false) : plain;
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
  expect_meta_read_exactly<std::int8_t>(folder_, "MET_CHAR", {-128, -1, 0, 1, 2, 127});
  expect_meta_read_exactly<std::uint8_t>(folder_, "MET_UCHAR", {0, 1, 2, 127, 128, 255});
  expect_meta_read_exactly<std::int16_t>(folder_, "MET_SHORT", {-32768, -2, 0, 1, 258, 32767});
  expect_meta_read_exactly<std::uint16_t>(folder_, "MET_USHORT", {0, 1, 258, 32768, 40000, 65535});
  expect_meta_read_exactly<std::int32_t>(folder_, "MET_INT", {-16777216, -2, 0, 1, 66051, 16777216});
  expect_meta_read_exactly<std::uint32_t>(folder_, "MET_UINT",
                                          {0, 1, 66051, 16777215, 16777216, 2147483648U});
  expect_meta_read_exactly<std::int32_t>(folder_, "MET_LONG", {-16777216, -2, 0, 1, 66051, 16777216});
  expect_meta_read_exactly<std::uint32_t>(folder_, "MET_ULONG", {0, 1, 66051, 16777215, 3, 4});
  expect_meta_read_exactly<std::int64_t>(folder_, "MET_LONG_LONG", {-5, 0, 1, 66051, 16777216, 2});
  expect_meta_read_exactly<std::uint64_t>(folder_, "MET_ULONG_LONG", {0, 1, 66051, 16777215, 3, 4});
  expect_meta_read_exactly<float>(folder_, "MET_FLOAT", {-1.5F, 0, 0.1F, 1e-40F, 3e38F, 7});
  expect_meta_read_exactly<double>(folder_, "MET_DOUBLE", {-1.5, 0, 0.25, 1e-3F, 3e38F, 7});
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

TEST_F(MetaImageContract, LettersThatTheMatrixContradictsAreSaid) {
  const auto is_said = [&](const std::string& letters) {
    file_warnings(true);
    read(header("ElementSpacing = 1 2 3\nAnatomicalOrientation = " + letters + "\n") + "\1\2\3\4\5\6");
    return !file_warnings(true).empty();
  };
  EXPECT_FALSE(is_said("RAI") || is_said("LPS") || is_said("???"));
  EXPECT_TRUE(is_said("RAS") && is_said("LAI"));
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
