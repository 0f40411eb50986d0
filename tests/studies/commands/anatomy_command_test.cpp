/// Bodies as anatomy has them, as a user meets them: a calf whose muscles glide, constants found from
/// displacements, and data that lie elsewhere.
#include "maille/scene/write_image.hpp"

#include "studies/commands/run_command.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

/// A MetaImage of float32, n x n x n voxels of 1 mm from `corner` [mm] on.
std::string image_of(int n, double corner, int components,
                     const std::function<float(const std::array<int, 3>& at, int component)>& value) {
  std::string text = fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
                                 "False\nOffset = {0} {0} {0}\nElementSpacing = 1 1 1\nDimSize = {1} {1} "
                                 "{1}\nElementNumberOfChannels = {2}\nElementType = "
                                 "MET_FLOAT\nElementDataFile = LOCAL\n",
                                 corner + 0.5, n, components);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int c = 0; c < components; ++c) {
          const float number = value({x, y, z}, c);
          std::array<char, 4> bytes{};
          std::memcpy(bytes.data(), &number, 4);
          text.append(bytes.data(), 4);
        }
  return text;
}

/// Two blocks on each other, pulled and sheared; the stiffness of each in kPa.
std::string blocks_of(int lower, int upper) {
  return fmt::format(R"(units = "mm"
[specimen]
shape = "image"
image = "blocks.mha"
coarsen = 2
[specimen.labels]
1 = {{ youngs_modulus = "{} kPa", poisson_ratio = 0.3 }}
2 = {{ youngs_modulus = "{} kPa", poisson_ratio = 0.4 }}
[[hold]]
where = "z-"
[[load]]
where = "z+"
force = ["0.05 N", 0, "0.2 N"]
[[measure]]
name = "top"
displacement = {{ at = [4, 4, 8] }}
[[measure]]
name = "side"
displacement = {{ at = [7, 2, 4] }}
)",
                     lower, upper);
}

class Blocks {
public:
  /// @param axes more of the header
  explicit Blocks(const std::string& axes = "") {
    std::string image = image_of(8, 0, 1, [](const auto& at, int) { return at[2] < 4 ? 1.0F : 2.0F; });
    folder_.write("blocks.mha", image.insert(image.find("NDims"), axes));
  }
  std::string write(const std::string& name, const std::string& content) const {
    return folder_.write(name, content).string();
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Outcome identify(const std::string& data) const {
    return maille_command("identify " + folder_.write("start.toml", blocks_of(60, 90)).string() +
                          " --measured " + data +
                          " --sigma '1 um' --json --unknown "
                          "specimen.labels.1.youngs_modulus,specimen.labels.2.youngs_modulus");
  }

private:
  test::TemporaryFolder folder_;
};

void expect_found(const Outcome& outcome) {
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const json found = json::parse(outcome.out);
  EXPECT_NEAR(found["unknowns"][0]["value"].get<double>(), 100, 1);
  EXPECT_NEAR(found["unknowns"][1]["value"].get<double>(), 50, 0.5);
}

// Truth: the constants that the displacements were computed with; the image has four voxels a cell's face.
TEST(IdentifyDisplacementAnalytic, FindsTheConstantsOfAnImageAndOfPoints) {
  const Blocks files;
  const Outcome truth = maille_command("run " + files.write("truth.toml", blocks_of(100, 50)) +
                                       " --maps --json --out " + files.path("out"));
  ASSERT_EQ(truth.code, 0) << truth.err;
  expect_found(files.identify(files.path("out/truth_coupled_displacement.nii.gz")));
  const json measures = json::parse(truth.out)["results"][0]["measures"];
  std::string points = "x [mm],y [mm],z [mm],ux [m],uy [m],uz [m]\n";
  const std::array<std::string, 2> places{"4,4,8", "7,2,4"};
  for (std::size_t i = 0; i < 2; ++i)
    points += fmt::format("{},{:.9g},{:.9g},{:.9g}\n", places[i], measures[i]["vector"][0].get<double>(),
                          measures[i]["vector"][1].get<double>(), measures[i]["vector"][2].get<double>());
  expect_found(files.identify(files.write("points.csv", points)));
}

// Truth: the constants that the displacements were computed with; vectors along the oblique grid or the world.
TEST(IdentifyDisplacementAnalytic, FindsTheConstantsOfEveryFormat) {
  const Blocks files("TransformMatrix = 0.6 0.8 0 -0.8 0.6 0 0 0 1\n");
  ASSERT_EQ(maille_command("run " + files.write("truth.toml", blocks_of(100, 50)) + " --maps --out " +
                           files.path("out"))
                .code,
            0);
  const Image map = read_image(files.path("out/truth_coupled_displacement.nii.gz"));
  const ImageInfo& info = map.info;
  std::string axes, bytes;
  for (std::size_t a = 0; a < 3; ++a)
    axes += fmt::format(" ({}, {}, {})", info.direction[0][a], info.direction[1][a], info.direction[2][a]);
  const auto n = static_cast<std::size_t>(info.n_voxels());
  for (std::size_t v = 0; v < n; ++v)
    for (std::size_t a = 0; a < 3; ++a) {
      double along = 0;
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t c = 0; c < 3; ++c)
          along += info.direction[row][a] * info.vectors_to_world.value()[row][c] * map.values[c * n + v];
      const auto number = static_cast<float>(along);
      bytes.append(reinterpret_cast<const char*>(&number), 4);
    }
  expect_found(files.identify(files.write(
      "along.nrrd",
      fmt::format("NRRD0005\ntype: float\nendian: little\nencoding: raw\ndimension: 4\nsizes: 3 {} {} {}\n"
                  "kinds: vector domain domain domain\nspace: {}\nspace directions: none{}\n"
                  "space origin: ({}, {}, {})\nmeasurement frame:{}\n\n",
                  info.size[0], info.size[1], info.size[2],
                  info.world == WorldAxes::ras ? "right-anterior-superior" : "left-posterior-superior", axes,
                  1e3 * info.origin[0], 1e3 * info.origin[1], 1e3 * info.origin[2], axes) +
          bytes)));
  Image lps = map; // as write_image has it
  for (std::size_t i = 0; i < 2 * n; ++i)
    lps.values[i] = -lps.values[i];
  for (const char* name : {"world.nrrd", "world.mha"}) {
    write_image(lps, files.path(name));
    expect_found(files.identify(files.path(name)));
  }
}

TEST(IdentifyDisplacementContract, DataThatLieElsewhereOrAreNoNumbersAreNamed) {
  const Blocks files;
  const auto expect = [&](const std::string& data, const std::string& words) {
    const Outcome outcome = files.identify(data);
    EXPECT_EQ(outcome.code, 2) << data << outcome.out;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  };
  expect(files.write("far.mha", image_of(8, 500, 3, [](const auto&, int) { return 0.1F; })),
         "none of them where there is matter");
  expect(
      files.write("gap.mha",
                  image_of(8, 0, 3, [](const auto& at, int) { return at[0] == 3 ? std::nanf("") : 0.1F; })),
      "none in 64 of them");
  expect(files.write("far.csv", "x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]\n90,0,0,1,0,0\n"),
         "far.csv:2: x: expected a point of the body at rest");
}

// Truth: forces balance, 20 N at the tendon; energies of parts are the body's; the map lies on the scan's
// voxels and is 0 where the labels are not.
TEST(GlidingCalfData, ATendonIsPulledBetweenNeighboursThatSlide) {
  if (!std::getenv("MAILLE_DATA"))
    GTEST_SKIP() << "MAILLE_DATA is not set";
  const test::TemporaryFolder folder;
  const std::string scene = std::string(MAILLE_SCENES) + "/calf_glides.toml";
  const Outcome run = maille_command("run " + scene + " --maps --json --out " + (folder / "out").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out)["results"][0];
  double tendon = 0, fibre_strain = 0;
  for (const json& measure : result["measures"])
    (measure["name"] == "tendon" ? tendon : fibre_strain) = measure["value"].get<double>();
  EXPECT_LT(tendon, -1e-3);
  EXPECT_GT(tendon, -20e-3);
  EXPECT_GT(fibre_strain, 0);
  const json& mechanics = result["mechanics"];
  double down = 0, parts = 0;
  for (const char* kind : {"holds", "moves", "loads"})
    for (const json& one : mechanics[kind])
      down += one["force"][2].get<double>();
  EXPECT_NEAR(down, 0, 0.02);
  for (const json& label : mechanics["labels"])
    parts += label["strain_energy"].get<double>();
  EXPECT_NEAR(parts, mechanics["body"]["strain_energy"].get<double>(), 1e-6 * parts);
  const Image labels = read_image(std::string(std::getenv("MAILLE_DATA")) + "/calf_mri/labels.nii.gz"),
              map = read_image((folder / "out/calf_glides_coupled_fibre_strain.nii.gz").string());
  ASSERT_EQ(map.info.size, labels.info.size);
  for (std::size_t r = 0; r < 3; ++r)
    EXPECT_NEAR(map.info.origin[r], labels.info.origin[r], 1e-8);
  std::int64_t on_17 = 0, far_away = 0;
  for (std::size_t voxel = 0; voxel < map.values.size(); ++voxel) {
    on_17 += labels.values[voxel] == 17 && map.values[voxel] != 0 ? 1 : 0;
    far_away += labels.values[voxel] == 18 && map.values[voxel] != 0 ? 1 : 0; // of the other leg
  }
  EXPECT_GT(on_17, 5000);
  EXPECT_EQ(far_away, 0);
}

} // namespace
} // namespace maille
