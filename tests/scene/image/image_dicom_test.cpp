/// Series of DICOM files, written here by GDCM as a scanner writes them.
#include "maille/images/image.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

#include <gdcmImage.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageWriter.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>

namespace maille {
namespace {

namespace fs = std::filesystem;

struct Written {
  int columns = 5, rows = 4, slices = 6;
  double column_spacing = 0.7, row_spacing = 1.3, step = 2.5; // mm
  std::string series = "1.2.826.0.1.3680043.2.1125.1";
  gdcm::TransferSyntax syntax = gdcm::TransferSyntax::ExplicitVRLittleEndian;
  std::function<double(int)> slope = [](int) { return 1.0; };
  std::function<double(int)> intercept = [](int) { return 0.0; };
  std::function<Vec3(int)> shift = [](int) { return Vec3{}; }; // of a slice, mm
  std::function<bool(int)> is_left_out = [](int) { return false; };
  unsigned order = 1; // of the files' names
  std::string frames; // NumberOfFrames, if any
};

/// Oblique: turned about z and tipped about its own row.
constexpr double turn = 0.4, tip = -0.3;
const Vec3 of_row{std::cos(turn), std::sin(turn), 0};
const Vec3 of_column{-std::sin(turn) * std::cos(tip), std::cos(turn) * std::cos(tip), std::sin(tip)};
const Vec3 normal{of_row[1] * of_column[2] - of_row[2] * of_column[1],
                  of_row[2] * of_column[0] - of_row[0] * of_column[2],
                  of_row[0] * of_column[1] - of_row[1] * of_column[0]};
const Vec3 corner{-30, 12, 140}; // mm, left posterior superior

std::int16_t stored(int i, int j, int k) {
  return std::int16_t(100 * k + 10 * j + i - 200);
}

void put_text(gdcm::DataSet& data, std::uint16_t group, std::uint16_t element, gdcm::VR vr,
              std::string value) {
  if (value.size() % 2 != 0)
    value += vr == gdcm::VR::UI ? '\0' : ' ';
  gdcm::DataElement entry(gdcm::Tag(group, element), 0, vr);
  entry.SetByteValue(value.data(), gdcm::VL(std::uint32_t(value.size())));
  data.Replace(entry);
}

/// Decimal strings, between backslashes.
void put_numbers(gdcm::DataSet& data, std::uint16_t group, std::uint16_t element,
                 const std::vector<double>& values) {
  std::string text;
  for (const double value : values)
    text += fmt::format("{}{:.9g}", text.empty() ? "" : "\\", value);
  put_text(data, group, element, gdcm::VR::DS, text);
}

/// Files in an order that says nothing of the slices'. @return the name of each slice's file
std::vector<std::string> write_series(const fs::path& folder, const Written& what) {
  gdcm::Trace::WarningOff();
  std::vector<int> numbers(std::size_t(what.slices));
  for (int k = 0; k < what.slices; ++k)
    numbers[std::size_t(k)] = k;
  std::shuffle(numbers.begin(), numbers.end(), std::mt19937(what.order));
  std::vector<std::string> names;
  for (int k = 0; k < what.slices; ++k) {
    const std::string name =
        "IM" + what.series.substr(what.series.size() - 1) + std::to_string(1000 + numbers[std::size_t(k)]);
    names.push_back(name);
    if (what.is_left_out(k))
      continue;
    std::vector<std::int16_t> pixels;
    for (int j = 0; j < what.rows; ++j)
      for (int i = 0; i < what.columns; ++i)
        pixels.push_back(stored(i, j, k));
    gdcm::SmartPointer<gdcm::Image> image = new gdcm::Image;
    image->SetNumberOfDimensions(2);
    image->SetDimension(0, unsigned(what.columns));
    image->SetDimension(1, unsigned(what.rows));
    image->SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    image->SetPixelFormat(gdcm::PixelFormat::INT16);
    image->SetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
    gdcm::DataElement data(gdcm::Tag(0x7fe0, 0x0010));
    data.SetByteValue(reinterpret_cast<const char*>(pixels.data()),
                      gdcm::VL(std::uint32_t(pixels.size() * sizeof(std::int16_t))));
    image->SetDataElement(data);
    if (what.syntax != gdcm::TransferSyntax::ExplicitVRLittleEndian) {
      gdcm::ImageChangeTransferSyntax change;
      change.SetTransferSyntax(what.syntax);
      change.SetInput(*image);
      if (!change.Change())
        throw std::runtime_error("gdcm cannot compress");
      image = const_cast<gdcm::Image*>(dynamic_cast<const gdcm::Image*>(&change.GetOutput()));
    }
    gdcm::ImageWriter writer;
    writer.SetImage(*image);
    put_text(writer.GetFile().GetDataSet(), 0x0008, 0x0016, gdcm::VR::UI, "1.2.840.10008.5.1.4.1.1.4"); // MR
    writer.SetFileName((folder / name).c_str());
    if (!writer.Write())
      throw std::runtime_error("gdcm cannot write");
    // The writer of images has a mind of its own about places and rescaling: put in as a scanner has them.
    gdcm::Reader reader;
    reader.SetFileName((folder / name).c_str());
    if (!reader.Read())
      throw std::runtime_error("gdcm cannot read");
    gdcm::DataSet& header = reader.GetFile().GetDataSet();
    put_text(header, 0x0008, 0x0060, gdcm::VR::CS, "MR");
    put_text(header, 0x0008, 0x103e, gdcm::VR::LO, "calf");
    put_text(header, 0x0020, 0x000e, gdcm::VR::UI, what.series);
    std::vector<double> position;
    const Vec3 aside = what.shift(k);
    for (std::size_t a = 0; a < 3; ++a)
      position.push_back(corner[a] + k * what.step * normal[a] + aside[a]);
    put_numbers(header, 0x0020, 0x0032, position);
    put_numbers(header, 0x0020, 0x0037,
                {of_row[0], of_row[1], of_row[2], of_column[0], of_column[1], of_column[2]});
    put_numbers(header, 0x0028, 0x0030, {what.row_spacing, what.column_spacing});
    put_numbers(header, 0x0018, 0x0050, {1.0}); // thinner than their distance: there are gaps
    if (!what.frames.empty())
      put_text(header, 0x0028, 0x0008, gdcm::VR::IS, what.frames);
    put_numbers(header, 0x0028, 0x1052, {what.intercept(k)});
    put_numbers(header, 0x0028, 0x1053, {what.slope(k)});
    gdcm::Writer again;
    again.SetFile(reader.GetFile());
    again.SetFileName((folder / name).c_str());
    if (!again.Write())
      throw std::runtime_error("gdcm cannot write");
  }
  return names;
}

/// Every fault of reading `place`, as one text.
std::string faults_of(const fs::path& place) {
  std::string text;
  for (const Fault& fault : test::faults_found_by([&] { read_image(place); }))
    text += fault.key + ": expected " + fault.expected + ", found " + fault.found + "\n";
  return text;
}

void expect_values(const Image& image, const Written& what) {
  ASSERT_EQ(image.info.size, (Index3{what.columns, what.rows, what.slices}));
  std::size_t voxel = 0;
  for (int k = 0; k < what.slices; ++k)
    for (int j = 0; j < what.rows; ++j)
      for (int i = 0; i < what.columns; ++i, ++voxel)
        EXPECT_FLOAT_EQ(image.values[voxel], float(stored(i, j, k) * what.slope(k) + what.intercept(k)));
}

/// Truth: the places and values that were written; formulas of PS3.3 C.7.6.2.
TEST(DicomAnalytic, AnObliqueSeriesStandsWhereItsHeadersSay) {
  const test::TemporaryFolder folder;
  const Written what;
  const auto names = write_series(folder.path(), what);
  ASSERT_FALSE(std::ranges::is_sorted(names)) << "the names would give the order away";
  const Image image = read_image(folder.path());
  expect_values(image, what);
  EXPECT_EQ(image.info.world, WorldAxes::lps);
  const Vec3 spacing{what.column_spacing * 1e-3, what.row_spacing * 1e-3, what.step * 1e-3};
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(image.info.spacing[a], spacing[a], 1e-9);
    EXPECT_NEAR(image.info.origin[a], corner[a] * 1e-3, 1e-8);
    EXPECT_NEAR(image.info.direction[a][0], of_row[a], 1e-6);
    EXPECT_NEAR(image.info.direction[a][1], of_column[a], 1e-6);
    EXPECT_NEAR(image.info.direction[a][2], normal[a], 1e-6);
  }
  EXPECT_EQ(read_image_info(folder.path()).size, image.info.size);
}

TEST(DicomAnalytic, EverySliceIsRescaledByItsOwnSlope) {
  const test::TemporaryFolder folder;
  Written what;
  what.slope = [](int k) { return 0.5 + k; };
  what.intercept = [](int k) { return -7.0 * k - 1; };
  write_series(folder.path(), what);
  expect_values(read_image(folder.path()), what);
}

/// Truth: the same values, uncompressed.
TEST(DicomOracle, CompressedPixelsAreTheSame) {
  for (const auto syntax : {gdcm::TransferSyntax::JPEG2000Lossless, gdcm::TransferSyntax::RLELossless,
                            gdcm::TransferSyntax::JPEGLosslessProcess14_1}) {
    const test::TemporaryFolder folder;
    Written what;
    what.syntax = syntax;
    what.columns = what.rows = 16;
    write_series(folder.path(), what);
    expect_values(read_image(folder.path()), what);
  }
}

// Truth: the majority of the voxels of each block, counted in the image that is read as a whole.
TEST(DicomOracle, ABodyIsReadSliceBySlice) {
  const test::TemporaryFolder folder;
  const Written what;
  write_series(folder.path(), what);
  const Image image = read_image(folder.path());
  const Specimen body =
      parse_scene("[specimen]\nshape = \"image\"\nimage = \"" + folder.path().string() +
                  "\"\ncoarsen = 2\nmaterial = \"fat/subcutaneous\"\nthreshold = -45.5\n"
                  "[[hold]]\nwhere = { sphere = { centre = [0, 0, 0], radius = \"10 m\" } }\n")
          .specimen;
  const Index3& n = image.info.size;
  std::int64_t cells = 0;
  for (int k = 0; k < n[2]; k += 2)
    for (int j = 0; j < n[1]; j += 2)
      for (int i = 0; i < n[0]; i += 2) {
        int above = 0;
        for (int v = 0; v < 8; ++v) {
          const int x = i + v % 2, y = j + v / 2 % 2, z = k + v / 4;
          if (x < n[0] && y < n[1] && z < n[2])
            above += image.values[std::size_t(x + n[0] * (y + n[1] * z))] > -45.5F ? 1 : 0;
        }
        const Index3 at{i / 2 - int(std::lround(body.origin[0] / body.grid.spacing()[0])),
                        j / 2 - int(std::lround(body.origin[1] / body.grid.spacing()[1])),
                        k / 2 - int(std::lround(body.origin[2] / body.grid.spacing()[2]))};
        EXPECT_EQ(body.grid.has_cell(at) && body.is_matter(body.grid.cell(at)), above >= 4)
            << i << " " << j << " " << k;
        cells += above >= 4 ? 1 : 0;
      }
  EXPECT_EQ(body.n_matter_cells(), cells);
  EXPECT_GT(cells, 10);
}

TEST(DicomContract, AFileStandsForItsSeriesAndOtherFilesAreNoMatter) {
  const test::TemporaryFolder folder;
  Written what, other;
  other.series = "1.2.826.0.1.3680043.2.1125.2";
  other.slices = 3;
  const auto names = write_series(folder.path(), what);
  folder.write("notes.txt", "not DICOM");
  expect_values(read_image(folder.path()), what);
  write_series(folder.path(), other);
  const std::string faults = faults_of(folder.path());
  EXPECT_TRUE(test::has(faults, "one series"));
  EXPECT_TRUE(test::has(faults, "6 of \"" + what.series));
  EXPECT_TRUE(test::has(faults, "3 of \"" + other.series));
  expect_values(read_image(folder.path() / names[2]), what);
  EXPECT_EQ(files_of_image(folder.path()).size(), 10U);
}

TEST(DicomContract, ASliceThatIsMissingTwiceThereOrAsideIsRefused) {
  const auto said_of = [](const Written& what,
                          const std::function<std::string(const std::vector<std::string>&)>& words) {
    const test::TemporaryFolder folder;
    const auto names = write_series(folder.path(), what);
    return test::has(faults_of(folder.path()), words(names));
  };
  Written gap, twice, tilted;
  gap.is_left_out = [](int k) { return k == 2 || k == 3; };
  EXPECT_TRUE(said_of(gap, [](const auto& names) {
    return "7.5 mm between " + names[1] + " and " + names[4] + ": 2 missing";
  }));
  twice.shift = [](int k) {
    return k == 3 ? Vec3{-2.5 * normal[0], -2.5 * normal[1], -2.5 * normal[2]} : Vec3{};
  };
  EXPECT_TRUE(said_of(twice, [](const auto&) { return "at the same"; }));
  tilted.shift = [](int k) { return Vec3{0.4 * k * of_row[0], 0.4 * k * of_row[1], 0.4 * k * of_row[2]}; };
  EXPECT_TRUE(said_of(tilted, [](const auto&) { return "tilted gantry"; }));
  EXPECT_TRUE(said_of(tilted, [](const auto&) { return "0.4 mm aside"; }));
}

/// GDCM of Debian ends the process at many of these, and makes up pixels that are missing.
TEST(DicomContract, AFileThatIsCutShortIsAFault) {
  for (const auto syntax : {gdcm::TransferSyntax::ExplicitVRLittleEndian,
                            gdcm::TransferSyntax::JPEG2000Lossless, gdcm::TransferSyntax::RLELossless}) {
    const test::TemporaryFolder whole;
    Written what;
    what.syntax = syntax;
    what.columns = what.rows = 16;
    const auto names = write_series(whole.path(), what);
    const std::string bytes = test::text_of(whole.path() / names[1]);
    const std::size_t size = bytes.size();
    std::vector<std::size_t> cuts{132, 133, 200, size / 2, size - 200};
    if (syntax == gdcm::TransferSyntax::ExplicitVRLittleEndian)
      cuts.insert(cuts.end(), {size - 41, size - 2, size - 1});
    for (const std::size_t left : cuts) {
      const test::TemporaryFolder folder;
      fs::copy_file(whole.path() / names[0], folder.path() / names[0]);
      folder.write(names[1], bytes.substr(0, left));
      const std::string faults = faults_of(folder.path());
      EXPECT_TRUE(test::has(faults, names[1])) << left << " of " << size << ": ";
    }
  }
}

TEST(DicomContract, NumbersBeyondIntAreRefused) {
  for (const char* frames : {"99999999999", "-1"}) {
    const test::TemporaryFolder folder;
    Written what;
    what.frames = frames;
    const auto names = write_series(folder.path(), what);
    EXPECT_TRUE(test::has(faults_of(folder.path()), "NumberOfFrames")) << frames;
  }
}

TEST(DicomContract, WhatIsNoSeriesSaysSo) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(test::has(faults_of(folder.path()), "no DICOM image in it"));
  folder.write("notes", "not DICOM");
  EXPECT_TRUE(test::has(faults_of(folder.path()), "no DICOM image in it"));
  EXPECT_TRUE(test::has(faults_of(folder.path() / "notes"), "or a folder of DICOM files"));
}

} // namespace
} // namespace maille
