/// Forces, strain, stress and energy as `maille run` and `maille compare` tell them.

#include "maille/images/image.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string& bar = test::pulled_bar;

struct Folder : test::TemporaryFolder {
  std::string path(const std::string& name) const { return (*this / name).string(); }
  std::string with(const std::string& text) const { return write("bar.toml", text).string(); }
  json read(const std::string& name) const { return json::parse(test::text_of(path(name))); }
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    lines.push_back(line);
  return lines;
}

// Truth: balance, with a pressure on the area that its faces have then; a dead load would miss 10 %.
TEST(MechanicsCommandAnalytic, PressureThatFollowsIsInBalance) {
  const Folder folder;
  const json results = test::json_of("run " +
                                     folder.with("strain = \"finite\"\n" +
                                                 test::pulled_box_text("[4, 2, 2]", "[\"0.4 mm\", 0, 0]") +
                                                 "[[load]]\nwhere = \"z+\"\npressure = \"1 kPa\"\n") +
                                     " --json");
  EXPECT_FALSE(test::has(results.dump(), "not in balance")) << results.dump(1);
}

// Truth: Hooke's law of a bar that is pulled.
TEST(MechanicsCommandAnalytic, ABarOfOneMaterial) {
  const Folder folder;
  const json results =
      test::json_of("run " + folder.with(bar) + " --methods coupled,fem_q1,limits --json")["results"];
  ASSERT_EQ(results.size(), 3u);
  for (const json& row : results) {
    const json& found = row["mechanics"];
    const json& body = found["body"];
    EXPECT_EQ(body["cells"], 16);
    EXPECT_NEAR(body["volume_at_rest"], 16e-9, 1e-18);
    EXPECT_TRUE(found["labels"].empty());
    ASSERT_EQ(found["materials"].size(), 1u);
    EXPECT_EQ(found["materials"][0]["material"], "soft");
    EXPECT_FALSE(body.contains("fibre_strain")) << "isotropic matter has no fibres";
    if (row["method"] == "limits") {
      EXPECT_TRUE(found["holds"].empty() && found["moves"].empty());
      EXPECT_FALSE(body.contains("von_mises") || body.contains("strain_energy"));
      continue;
    }
    EXPECT_NEAR(body["volume_change"], 1.05 * 0.985 * 0.985 - 1, 1e-6);
    EXPECT_NEAR(body["largest_strain"]["mean"], 0.05, 1e-6);
    EXPECT_NEAR(body["smallest_strain"]["p95"], -0.015, 1e-6);
    EXPECT_NEAR(body["von_mises"]["max"], 500, 1e-2);
    EXPECT_NEAR(body["pressure"]["p50"], -500. / 3, 1e-2);
    EXPECT_NEAR(body["strain_energy"], 0.5 * 500 * 0.05 * 16e-9, 1e-12);
    EXPECT_NEAR(body["strain_energy"], row["strain_energy"], 1e-10 * row["strain_energy"].get<double>());
    ASSERT_EQ(found["moves"].size(), 1u);
    EXPECT_EQ(found["moves"][0]["name"], "move[1]");
    EXPECT_EQ(found["moves"][0]["where"], "x+");
    EXPECT_NEAR(found["moves"][0]["force"][0], 500 * 4e-6, 1e-8) << "pulled towards +x";
    EXPECT_NEAR(found["moves"][0]["moment"][1], 0, 1e-11);
    EXPECT_NEAR(found["moves"][0]["centroid"][0], 4e-3, 1e-15);
    ASSERT_EQ(found["holds"].size(), 3u);
    EXPECT_NEAR(found["holds"][0]["force"][0], -500 * 4e-6, 1e-8);
    EXPECT_NEAR(found["holds"][1]["force"][1], 0, 1e-8);
  }
}

TEST(MechanicsCommandContract, ConventionsAreOneText) {
  const Folder folder;
  const Outcome run = maille_command("run " + folder.with(bar) + " --json");
  const std::string text = json::parse(run.out)["results"][0]["mechanics"]["conventions"];
  EXPECT_EQ(text, mechanics_conventions());
  EXPECT_EQ(maille_command("help mechanics").out, text);
}

// Truth: linear elasticity. Half the way takes half the force and a quarter of the energy.
TEST(MechanicsCommandAnalytic, ForceOverDisplacementIsALine) {
  const Folder folder;
  const Outcome run = test::done("run " + folder.with(bar) + " --steps 4 --out " + folder.path("out"));
  EXPECT_TRUE(test::has(run.out, "force on moves [N]"));
  std::ifstream file(folder.path("out/bar_coupled_force.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line, "step,fraction,largest_displacement_m,move_force_x_n,move_force_y_n,move_force_z_n,"
                  "hold_force_x_n,hold_force_y_n,hold_force_z_n,strain_energy_j");
  int step = 0;
  for (; std::getline(file, line); ++step) {
    std::vector<double> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');)
      cells.push_back(std::stod(cell));
    ASSERT_EQ(cells.size(), 10u) << line;
    const double part = (step + 1) / 4.;
    EXPECT_EQ(cells[0], step + 1);
    EXPECT_EQ(cells[1], part);
    EXPECT_NEAR(cells[2], part * std::hypot(0.2e-3, 0.03e-3, 0.03e-3), 1e-9);
    EXPECT_NEAR(cells[3], part * 2e-3, 1e-8);
    EXPECT_NEAR(cells[6], -part * 2e-3, 1e-8);
    EXPECT_NEAR(cells[9], part * part * 0.5 * 500 * 0.05 * 16e-9, 1e-12);
  }
  EXPECT_EQ(step, 4);
  const json results = folder.read("out/bar_run_results.json");
  EXPECT_NE(std::ranges::find(results["written"], "bar_coupled_force.csv"), results["written"].end());
  EXPECT_TRUE(results["results"][0]["results"][0]["mechanics"].contains("conventions"));
}

TEST(MechanicsCommandContract, EstimatesOfForceAndStressStandBesideTheDisplacement) {
  const Folder folder;
  const std::string line = "run " + folder.with(bar) + " --methods coupled,limits --estimate";
  const json results = json::parse(maille_command(line + " --json").out)["results"];
  for (const char* key : {"force", "strain_energy", "strain", "stress"}) {
    EXPECT_LT(results[0]["estimated_error"][key].get<double>(), 1e-3) << key;
    EXPECT_EQ(results[1]["estimated_error"][key].is_null(), key != std::string("strain")) << key;
  }
  const std::string text =
      maille_command("compare" + line.substr(3) + " --csv " + folder.path("table.csv")).out;
  EXPECT_TRUE(test::has(text, "Estimated errors against elasticity"));
  EXPECT_TRUE(test::has(lines_of(test::text_of(folder.path("table.csv"))).at(0),
                        "estimated_force,estimated_strain_energy,estimated_strain,estimated_stress"));
}

TEST(MechanicsCommandContract, OneTableOfPartsAndOneLineOfABody) {
  const Folder folder;
  const auto lines_with = [&](const std::string& word, const std::string& text) {
    return std::ranges::count_if(lines_of(text),
                                 [&](const std::string& line) { return line.starts_with(word); });
  };
  const Outcome one = maille_command("run " + folder.with(bar));
  EXPECT_EQ(lines_with("part ", one.out), 1);
  EXPECT_EQ(lines_with("soft ", one.out), 1);
  EXPECT_EQ(lines_with("whole body", one.out), 0);
  for (const std::string& line : lines_of(one.out))
    EXPECT_LE(line.size(), 150u) << line;
}

// Truth: the voxels of the image, counted by hand; the whole is the sum of its labels.
TEST(MechanicsCommandContract, ASegmentationHasALineALabel) {
  const Folder folder;
  folder.write("labels.nii", test::nifti_of(test::bent_body()));
  const Outcome run =
      test::done("run " + folder.with(test::label_scene_text) + " --json " + folder.path("found.json"));
  EXPECT_TRUE(test::has(run.out, "\n5 firm "));
  EXPECT_TRUE(test::has(run.out, "\n17 muscle/soleus "));
  EXPECT_TRUE(test::has(run.out, "\nwhole body "));
  const json row = folder.read("found.json")["results"][0], labels = row["mechanics"]["labels"];
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0]["label"], 5);
  EXPECT_EQ(labels[0]["cells"], 10);
  EXPECT_EQ(labels[1]["label"], 17);
  EXPECT_EQ(labels[1]["material"], "muscle/soleus");
  EXPECT_EQ(labels[1]["cells"], 9);
  const double energy = row["strain_energy"];
  EXPECT_NEAR(labels[0]["strain_energy"].get<double>() + labels[1]["strain_energy"].get<double>(), energy,
              1e-10 * energy);
}

TEST(MechanicsCommandContract, CompareHasErrorsOfWhatIsAsked) {
  const Folder folder;
  const Outcome run = test::done("compare " + folder.with(bar) + " --csv " + folder.path("table.csv") +
                                 " --json " + folder.path("table.json"));
  EXPECT_TRUE(test::has(run.out, "Errors against fem_q1"));
  EXPECT_FALSE(test::has(run.out, "most von Mises")) << "parts are in JSON alone";
  for (const std::string& line : lines_of(run.out))
    EXPECT_LE(line.size(), 150u) << line;
  for (const json& row : folder.read("table.json")["results"]) {
    EXPECT_TRUE(row.contains("mechanics")) << row;
    const bool is_reference = row["method"] == "fem_q1", has_forces = row["method"] != "limits";
    ASSERT_EQ(row.contains("error"), !is_reference);
    if (is_reference)
      continue;
    EXPECT_TRUE(row["error"].contains("strain")) << row;
    for (const char* key : {"force", "strain_energy", "stress"})
      EXPECT_EQ(row["error"].contains(key), has_forces) << key << row;
    if (row["method"] == "coupled") {
      for (const char* key : {"force", "strain_energy", "strain", "stress"})
        EXPECT_LT(row["error"][key], 1e-3) << "both are exact in a uniform pull";
    }
  }
  const std::string header = lines_of(test::text_of(folder.path("table.csv"))).at(0);
  for (const char* name : {"move_force_x_n", "hold_force_z_n", "strain_energy_j", "force_error",
                           "strain_energy_error", "strain_error", "stress_error"})
    EXPECT_TRUE(test::has(("," + header + ","), fmt::format(",{},", name))) << name;
}

TEST(MechanicsCommandContract, APictureNeedsSteps) {
  const Folder folder;
  const std::string run = "run " + folder.with(bar) + " --picture ";
  test::expect_refused({{run + folder.path("a.png"), "--steps 2 or more"},
                        {run + folder.path("a.txt") + " --steps 2", ".png or .svg"},
                        {run + folder.path("nowhere/a.png") + " --steps 2", "nowhere"}});
  const Outcome no_forces = test::done(run + folder.path("a.png") + " --steps 2 --methods limits", 1);
  EXPECT_TRUE(test::has(no_forces.err, "no picture"));
  const Outcome drawn = test::done(run + folder.path("a.svg") + " --steps 2 --methods coupled,relaxed");
  for (const char* word : {"force on moves [mN]", "strain energy [nJ]", "largest displacement", "relaxed"})
    EXPECT_TRUE(test::has(test::text_of(folder.path("a.svg")), word));
}

// Truth: Hooke's law. A pulled bar is strained alike everywhere, and moves from 0 to its end: the last frame
// of strain has the dark colours in its scale alone.
TEST(MechanicsCommandContract, AFilmHasAPictureAStepAndOneAtRest) {
  const Folder folder;
  const std::string mp4 = folder.path("a.mp4"), run = "run " + folder.with(bar) + " --film ";
  test::expect_refused({{run + mp4, "--film: expected --steps 2 or more"},
                        {run + folder.path("a.png") + " --steps 2", "ends in .mp4"},
                        {run + mp4 + " --steps 2 --field error", "--estimate"},
                        {run + mp4 + " --steps 2 --field stress --methods limits", "limits"}});
  std::map<std::string, int> dark;
  for (const std::string field : {"strain", "displacement", "error"}) {
    const Outcome filmed = maille_command(run + mp4 + " --steps 3 --estimate --field " + field);
    if (filmed.err.find("no film") != std::string::npos) // no ffmpeg, or no OpenGL
      GTEST_SKIP() << filmed.err;
    ASSERT_EQ(filmed.code, 0) << filmed.err;
    const std::string rgb = test::shell("ffmpeg -i " + mp4 + " -f rawvideo -pix_fmt rgb24 -").out;
    const std::size_t frame = rgb.size() / 4;
    EXPECT_EQ(rgb.size() % std::size_t{4 * 3 * 1000}, 0u) << "four frames 1000 pixels wide";
    for (std::size_t i = 3 * frame; i + 2 < rgb.size(); i += 3)
      dark[field] += std::uint8_t(rgb[i + 1]) + 25 < std::uint8_t(rgb[i + 2]);
  }
  EXPECT_GT(dark["displacement"], 4 * dark["strain"]);
}

// Truth: linear beam theory; the bar's own weight bends it by far more than it is long.
TEST(MechanicsCommandContract, AnAnswerThatSmallStrainsDoNotAllowIsWarnedOf) {
  const Folder folder;
  const std::string soft = R"(
hold = [{ where = "x-" }]
load = [{ gravity = [0, 0, "-9.81 m/s^2"] }]
[specimen]
shape = "box"
cells = [30, 2, 2]
spacing = "1 mm"
material = { poisson_ratio = 0.3, density = "1000 kg/m^3", youngs_modulus = )";
  for (const char* way : {"", " --json"})
    EXPECT_TRUE(test::has(test::done("run " + folder.with(soft + "\"8 kPa\" }") + way).out,
                          "more than small strains and turns allow"));
  const Outcome softer = maille_command("run " + folder.with(soft + "\"1 kPa\" }"));
  EXPECT_TRUE(softer.code == 1 && test::has(softer.out, "64 of 120 cells are turned inside out"));
  EXPECT_FALSE(test::has(maille_command("run " + folder.with(bar)).out, "warning"));
}

// Truth: a uniform strain in the world, on every voxel in every storage order; stress by Hooke's law.
TEST(VoxelMapCommandAnalytic, AStretchedBodyHasOneStrainOnItsVoxels) {
  test::LabelArray block{{4, 3, 2}, std::vector<int>(24, 0), {}};
  for (int voxel = 0; voxel < 24; ++voxel)
    block.values[static_cast<std::size_t>(voxel)] = voxel % 4 < 3 ? 17 : 0; // no matter along one side
  block.affine = affine_of({2e-3, 3e-3, 5e-3}, {0.01, -0.02, 0.03}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  const auto orientations = test::all_orientations();
  for (const std::size_t i : {0UL, 11UL, 22UL, 45UL}) {
    const Folder folder;
    const test::LabelArray array = test::turned(block, orientations[i]);
    folder.write("labels.nii", test::nifti_of(array));
    const Outcome run = test::done(
        "run " +
        folder.with(
            "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = { 17 = { youngs_modulus = "
            "\"10 kPa\", poisson_ratio = 0 } }\n[[hold]]\nwhere = \"left\"\n[[move]]\nwhere = "
            "\"right\"\nframe = \"ras\"\nby = [\"0.06 mm\", 0, 0]\n") +
        " --methods coupled --maps --out " + folder.path("out"));
    const ImageInfo info = read_image_info(folder.path("labels.nii"));
    const auto expect_map = [&](const std::string& name, const std::vector<double>& values) {
      const Image map = read_image(folder.path("out/bar_coupled_" + name + ".nii.gz"));
      ASSERT_EQ(map.info.size, info.size);
      ASSERT_EQ(map.info.components, static_cast<int>(values.size()));
      for (std::size_t r = 0; r < 3; ++r)
        EXPECT_NEAR(map.info.origin[r], info.origin[r], 1e-8);
      for (std::size_t c = 0; c < values.size(); ++c)
        for (std::size_t voxel = 0; voxel < array.values.size(); ++voxel)
          EXPECT_NEAR(static_cast<double>(map.values[c * array.values.size() + voxel]),
                      array.values[voxel] == 17 ? values[c] : 0, 1e-3 * std::abs(values[0]))
              << name << " " << c;
    };
    expect_map("strain", {0.01, 0, 0, 0, 0, 0}); // 0.06 mm over 6 mm
    expect_map("stress", {100, 0, 0, 0, 0, 0});
    expect_map("von_mises", {100});
    EXPECT_FALSE(std::filesystem::exists(folder.path("out/bar_coupled_fibre_strain.nii.gz")));
  }
}

// Truth: docs/command.md: maps ask for a folder and an image.
TEST(VoxelMapCommandContract, AsksForAFolderAndAnImage) {
  const Folder folder;
  const std::string maps = "run " + folder.with(bar) + " --maps";
  test::expect_refused({{maps, "--out"}, {maps + " --out " + folder.path("out"), "from an image"}});
}

/// Several processes as a user starts them: the same files as by one.

/// The reference is what one process writes.
TEST(RanksCommandContract, CoupledWritesTheSameFileByTwoProcesses) {
  if (test::shell("command -v mpirun").code != 0)
    GTEST_SKIP() << "mpirun is not installed";
  const test::TemporaryFolder folder;
  const std::string line = std::string(" run ") + MAILLE_SCENES +
                           "/muscle_belly.toml --methods coupled --threads 1 --json - --out ";
  const auto alone = test::done(line + (folder / "alone").string());
  const auto together =
      test::shell("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n 2 " +
                  std::string(MAILLE_COMMAND) + line + (folder / "together").string());
  ASSERT_EQ(together.code, 0) << together.err;
  const std::string file = "muscle_belly_coupled_0001.vtu";
  ASSERT_FALSE(test::text_of(folder / "alone" / file).empty());
  EXPECT_TRUE(test::text_of(folder / "alone" / file) == test::text_of(folder / "together" / file));
  const json one = json::parse(alone.out)["results"][0], two = json::parse(together.out)["results"][0];
  EXPECT_EQ(one.at("iterations").get<int>(), two.at("iterations").get<int>());
  EXPECT_EQ(one.at("strain_energy").get<double>(), two.at("strain_energy").get<double>());
}

// Each pair is what ranks 0 and 1 are asked; files that lag on a shared disk, scripts that differ.
TEST(RanksContract, RanksThatDifferEndWithTheDifferenceNamed) {
  if (test::shell("command -v mpirun").code != 0)
    GTEST_SKIP() << "mpirun is not installed";
  const test::TemporaryFolder folder;
  for (const auto& [name, modulus] : {std::pair{"a", "10 kPa"}, {"b", "20 kPa"}})
    folder.write(std::string(name) + ".toml",
                 test::box_text("[4, 3, 3]",
                                fmt::format("{{ youngs_modulus = \"{}\", poisson_ratio = 0.3 }}", modulus)) +
                     test::hold_text() + test::move_text("[\"0.1 mm\", 0, 0]"));
  const std::string maille = "exec " + std::string(MAILLE_COMMAND), at = (folder / "").string();
  for (const auto& [first, second, word] :
       {std::tuple{" run " + at + "a.toml", " run " + at + "b.toml", "scene"},
        {" run " + at + "a.toml", " run " + at + "none.toml", "none.toml"},
        {" run " + at + "none.toml", " run " + at + "a.toml", "none.toml"},
        {" run " + at + "a.toml", " check " + at + "a.toml", "command"},
        {" run " + at + "a.toml", " run " + at + "a.toml --steps 2", "options"}}) {
    folder.write("ranks.sh", "[ $OMPI_COMM_WORLD_RANK = 0 ] && " + maille + first + "\n" + maille + second);
    const auto run =
        test::shell("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpirun "
                    "--oversubscribe -n 2 sh " +
                    at + "ranks.sh");
    EXPECT_EQ(run.code, 2) << first << second << "\n124: it did not end\n" << run.err;
    EXPECT_TRUE(test::has(run.err, word));
  }
}

} // namespace
} // namespace maille
