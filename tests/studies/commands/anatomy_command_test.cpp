/// Bodies as anatomy has them, as a user meets them: a calf whose muscles glide, constants found from
/// displacements, and data that lie elsewhere.

#include "maille/base/csv.hpp"
#include "maille/images/image.hpp"
#include "maille/images/write_image.hpp"
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

struct Folder : test::TemporaryFolder {
  std::string path(const std::string& name) const { return (*this / name).string(); }
  std::string file(const std::string& name, const std::string& content) const {
    return write(name, content).string();
  }
};

struct Blocks : Folder {
  /// @param axes more of the header
  explicit Blocks(const std::string& axes = "") {
    std::string image =
        test::float_image(8, 0, 1, [](const auto& at, int) { return at[2] < 4 ? 1.0F : 2.0F; });
    write("blocks.mha", image.insert(image.find("NDims"), axes));
  }
  Outcome identify(const std::string& data) const {
    return maille_command("fit " + file("start.toml", blocks_of(60, 90)) + " --measured " + data +
                          " --sigma '1 um' --json --unknown "
                          "specimen.labels.1.youngs_modulus,specimen.labels.2.youngs_modulus");
  }
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
  const Outcome truth = test::done("run " + files.file("truth.toml", blocks_of(100, 50)) +
                                   " --maps --json --out " + files.path("out"));
  expect_found(files.identify(files.path("out/truth_coupled_displacement.nii.gz")));
  const json measures = json::parse(truth.out)["results"][0]["measures"];
  std::string points = "x [mm],y [mm],z [mm],ux [m],uy [m],uz [m]\n";
  const std::array<std::string, 2> places{"4,4,8", "7,2,4"};
  for (std::size_t i = 0; i < 2; ++i)
    points += fmt::format("{},{:.9g},{:.9g},{:.9g}\n", places[i], measures[i]["vector"][0].get<double>(),
                          measures[i]["vector"][1].get<double>(), measures[i]["vector"][2].get<double>());
  expect_found(files.identify(files.file("points.csv", points)));
}

// Truth: the constants that the displacements were computed with; vectors along the oblique grid or the
// world.
TEST(IdentifyDisplacementAnalytic, FindsTheConstantsOfEveryFormat) {
  const Blocks files("TransformMatrix = 0.6 0.8 0 -0.8 0.6 0 0 0 1\n");
  test::done("run " + files.file("truth.toml", blocks_of(100, 50)) + " --maps --out " + files.path("out"));
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
  expect_found(files.identify(files.file(
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
    EXPECT_TRUE(test::has(outcome.err, words));
  };
  expect(files.file("far.mha", test::float_image(8, 500, 3, [](const auto&, int) { return 0.1F; })),
         "none of them where there is matter");
  expect(files.file("gap.mha",
                    test::float_image(8, 0, 3,
                                      [](const auto& at, int) { return at[0] == 3 ? std::nanf("") : 0.1F; })),
         "none in 64 of them");
  expect(files.file("far.csv", "x [mm],y [mm],z [mm],ux [mm],uy [mm],uz [mm]\n90,0,0,1,0,0\n"),
         "far.csv:2: x: expected a point of the body at rest");
}

// Truth: forces balance, 20 N at the tendon; energies of parts are the body's; the map lies on the scan's
// voxels and is 0 where the labels are not.
TEST(GlidingCalfData, ATendonIsPulledBetweenNeighboursThatSlide) {
  if (!std::getenv("MAILLE_DATA"))
    GTEST_SKIP() << "MAILLE_DATA is not set";
  const test::TemporaryFolder folder;
  const std::string scene = std::string(MAILLE_SCENES) + "/calf_glides.toml";
  const Outcome run = test::done("run " + scene + " --maps --json --out " + (folder / "out").string());
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

/// Measures as `maille run`, `compare`, `trade` and `check` tell them.

const std::string bar = test::pulled_bar + R"([[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "half"
force = { section = { point = ["2 mm", 0, 0], normal = [1, 0, 0] } }
component = "normal"
[[measure]]
name = "longer"
length = [[0, "1 mm", "1 mm"], ["4 mm", "1 mm", "1 mm"]]
kind = "relative"
[[measure]]
name = "line"
displacement = { along = [[0, 0, 0], ["4 mm", 0, 0]], points = 5 }
component = "x"
)";

struct BarFolder : Folder {
  std::string scene(const std::string& more = "") const { return file("bar.toml", bar + more); }
};

std::vector<std::vector<std::string>> csv_in(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  for (CsvRecords records(text); records.next();)
    rows.push_back(records.cells());
  return rows;
}

double cell(const std::vector<std::vector<std::string>>& table, std::size_t row, const std::string& column) {
  const auto found = std::ranges::find(table.at(0), column);
  EXPECT_NE(found, table.at(0).end()) << column;
  const std::string& text = table.at(row).at(static_cast<std::size_t>(found - table[0].begin()));
  return text.empty() ? NAN : std::stod(text);
}

// Truth: Hooke's law of a bar that is pulled.
TEST(NamedMeasuresCommandAnalytic, RunTellsThemByName) {
  const BarFolder folder;
  const Outcome run = test::done("run " + folder.scene() + " --methods coupled,limits --json");
  const json rows = json::parse(run.out)["results"];
  const json& found = rows[0]["measures"];
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0]["name"], "pull");
  EXPECT_EQ(found[0]["unit"], "N");
  EXPECT_NEAR(found[0]["value"], 2e-3, 1e-7);
  EXPECT_NEAR(found[0]["vector"][0], 2e-3, 1e-7);
  EXPECT_NEAR(found[1]["value"], 2e-3, 1e-7);
  EXPECT_FALSE(found[1].contains("vector"));
  EXPECT_NEAR(found[2]["value"], 0.05, 1e-6);
  ASSERT_EQ(found[3]["line"].size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(found[3]["line"][i]["value"], 5e-5 * static_cast<double>(i), 1e-9);
  EXPECT_TRUE(rows[1]["measures"][0]["value"].is_null());
  EXPECT_NEAR(rows[1]["measures"][2]["value"], 0.05, 1e-6);
  EXPECT_TRUE(test::has(maille_command("run " + folder.scene()).out, "pull             coupled"));
}

TEST(NamedMeasuresCommandAnalytic, StepsHaveThem) {
  const BarFolder folder;
  const Outcome run = test::done("run " + folder.scene() + " --steps 4 --out " + folder.path("out"));
  const auto steps = csv_in(test::text_of(folder.path("out/bar_coupled_measures.csv")));
  ASSERT_EQ(steps.size(), 5u);
  for (std::size_t step = 1; step <= 4; ++step) {
    EXPECT_NEAR(cell(steps, step, "pull_x"), 5e-4 * static_cast<double>(step), 1e-7);
    EXPECT_NEAR(cell(steps, step, "longer"), 0.0125 * static_cast<double>(step), 1e-6);
  }
  const auto line = csv_in(test::text_of(folder.path("out/bar_coupled_line.csv")));
  ASSERT_EQ(line.size(), 6u);
  EXPECT_EQ(line[0], (std::vector<std::string>{"along_m", "x_m", "y_m", "z_m", "line"}));
  EXPECT_NEAR(cell(line, 5, "line"), 2e-4, 1e-9);
}

TEST(NamedMeasuresCommandAnalytic, CompareHasTheirErrors) {
  const BarFolder folder;
  const Outcome run = test::done("compare " + folder.scene() + " --methods limits,relaxed,fem_q1 --json " +
                                 folder.path("c.json") + " --csv " + folder.path("c.csv"));
  const json rows = json::parse(test::text_of(folder.path("c.json")))["results"];
  const auto table = csv_in(test::text_of(folder.path("c.csv")));
  ASSERT_EQ(table.size(), 4u);
  for (const auto& line : table)
    EXPECT_EQ(line.size(), table[0].size());
  for (std::size_t i = 0; i < 3; ++i) {
    const json& row = rows[i];
    EXPECT_NEAR(cell(table, i + 1, "longer"), row["measures"][2]["value"], 1e-9);
    if (row["method"] == "fem_q1") {
      EXPECT_NEAR(cell(table, i + 1, "pull"), 2e-3, 1e-7);
      EXPECT_TRUE(std::isnan(cell(table, i + 1, "pull_error")));
      EXPECT_FALSE(row.contains("error"));
    } else if (row["method"] == "limits") {
      EXPECT_FALSE(row["error"]["measures"].contains("pull"));
      EXPECT_LT(row["error"]["measures"]["longer"], 1e-6);
    } else {
      // It knows no Poisson effect: lambda + 2 mu in place of E, its own weights included.
      const double pull = row["measures"][0]["value"], truth = rows[2]["measures"][0]["value"];
      EXPECT_NEAR(row["error"]["measures"]["pull"], std::abs(pull / truth - 1), 1e-6);
      EXPECT_GT(row["error"]["measures"]["pull"], 0.1);
      EXPECT_NEAR(cell(table, i + 1, "pull_error"), row["error"]["measures"]["pull"], 1e-6);
    }
  }
}

TEST(NamedMeasuresCommandAnalytic, TradeMeasuresEveryLattice) {
  const BarFolder folder;
  const Outcome run = test::done(
      "study trade " + folder.scene() + " --methods coupled --spacings 2,1,0.5 --tolerances 1e-4 " +
      "--reference fem_q1 --json " + folder.path("t.json") + " --csv " + folder.path("t.csv"));
  const json rows = json::parse(test::text_of(folder.path("t.json")))["rows"];
  const auto table = csv_in(test::text_of(folder.path("t.csv")));
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(rows[i]["measures"][0]["value"], 2e-3, 1e-6) << "a uniform strain on any lattice";
    EXPECT_LT(rows[i]["error"]["measures"]["pull"], 1e-3);
    EXPECT_NEAR(cell(table, i + 1, "pull"), 2e-3, 1e-6);
    EXPECT_EQ(table[i + 1].size(), table[0].size());
  }
}

/// Truth: a uniform strain, whose force every lattice gives alike.
TEST(NamedMeasuresCommandAnalytic, ChooseChoosesByTheirErrors) {
  const BarFolder folder;
  const Outcome run =
      maille_command("study choose " + folder.scene() + " --error 5% --time 10s --of pull --json -");
  const json choice = json::parse(run.out);
  EXPECT_EQ(choice["wish"]["of"], "pull");
  EXPECT_LT(choice["probes"]["difference"], 1e-2);
  const Outcome unknown = test::refused("study choose " + folder.scene() + " --error 5% --time 10s --of pul");
  EXPECT_TRUE(test::has(unknown.err, "did you mean \"pull\"?"));
}

TEST(NamedMeasuresCommandContract, CheckListsThemAndFaultsEndWithTwo) {
  const BarFolder folder;
  const Outcome good = test::done("check " + folder.scene());
  EXPECT_TRUE(test::has(good.out, "measure pull: force on move[1]"));
  const json listed = json::parse(maille_command("check " + folder.scene() + " --json").out);
  EXPECT_EQ(listed["measures"][2]["name"], "longer");
  const std::string faulty = "[[measure]]\nname = \"pull\"\nforce = \"move[7]\"\n";
  for (const char* command : {"check ", "run ", "compare "}) {
    const Outcome bad = test::refused(command + folder.scene(faulty));
    EXPECT_TRUE(test::has(bad.err, "measure[5].force"));
    EXPECT_TRUE(test::has(bad.err, "measure[5].name"));
  }
}

/// `maille warp`, `run --warp` and `maille new`: files, tables and what is wrong.

class WarpCommandContract : public testing::Test {
protected:
  WarpCommandContract() {
    labels_ = folder_.write("labels.nii", test::nifti_of(test::bent_body())).string();
    scene_ =
        folder_
            .write("scene.toml",
                   "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\n"
                   "labels = { 17 = \"muscle/soleus\", 5 = \"muscle/vastus_lateralis\" }\nfibre = [1, 0, 0]\n"
                   "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"0.1 mm\", 0, 0]\n")
            .string();
  }
  std::string out(const std::string& name) const { return (folder_.path() / name).string(); }
  const test::TemporaryFolder folder_;
  std::string labels_, scene_;
};

TEST_F(WarpCommandContract, WritesImagesFieldsSurfacesAndATable) {
  const Outcome run = test::done("warp " + scene_ + " --image " + labels_ +
                                 " --also mha,nrrd --surface stl,ply,vtp --out " + out("out") + " --json");
  const json result = json::parse(run.out)["results"][0];
  EXPECT_EQ(result["method"], "coupled");
  EXPECT_EQ(result["voxels_at_rest"], 3 * 2 * 3 + 1);
  EXPECT_EQ(result["folded_cells"], 0);
  ASSERT_EQ(result["labels"].size(), 2U);
  EXPECT_EQ(result["labels"][0]["label"], 5);
  EXPECT_EQ(result["labels"][1]["voxels"], 3 * 3);
  EXPECT_GT(result["labels"][0]["integral_of_det_f_m3"], 0);
  const auto files = result["files"].get<std::vector<std::string>>();
  for (const char* name : {"warped.nii.gz", "warped.mha", "warped.nrrd", "labels_warped.nii.gz",
                           "pull.nii.gz", "pull.mha", "pull.nrrd", "push.nrrd", "jacobian.nii.gz",
                           "labels.csv", "surface_5.stl", "surface_17.stl", "surface.ply", "surface.vtp"}) {
    EXPECT_NE(std::ranges::find(files, name), files.end()) << name;
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "out" / name)) << name;
  }
  const Image field = read_image(folder_.path() / "out" / "pull.nii.gz");
  EXPECT_EQ(field.info.components, 3);
  EXPECT_EQ(field.info.size, (Index3{5, 4, 3}));
  const Outcome vectors =
      test::done("warp " + scene_ + " --image " + out("out") + "/pull.nii.gz --out " + out("vectors"));
  EXPECT_TRUE(test::has(vectors.out + vectors.err, "vectors and tensors do not turn with the tissue"));
}

TEST_F(WarpCommandContract, RunWritesTheSameBesideItsOtherFiles) {
  const Outcome run = test::done("run " + scene_ + " --warp --out " + out("run"));
  const Outcome warp = test::done("warp " + scene_ + " --out " + out("warp"));
  for (const char* name : {"labels_warped.nii.gz", "pull.nii.gz"})
    EXPECT_EQ(read_image(folder_.path() / "run" / (std::string("scene_coupled_") + name)).values,
              read_image(folder_.path() / "warp" / name).values)
        << name;
  EXPECT_TRUE(test::has(warp.out, "integral of det F"));
}

TEST_F(WarpCommandContract, SaysWhatIsWrong) {
  test::refused("warp " + scene_); // no --out
  test::refused("warp " + scene_ + " --also png --out " + out("a"));
  test::refused("warp " + scene_ + " --image " + out("none.nii") + " --out " + out("a"));
  const auto box =
      folder_.write("box.toml", "[specimen]\nshape = \"box\"\ncells = [2, 2, 2]\nspacing = \"1 mm\"\n"
                                "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n");
  const Outcome none = test::refused("warp " + box.string() + " --out " + out("a"));
  EXPECT_TRUE(test::has(none.err, "--image or --labels"));
}

TEST_F(WarpCommandContract, NewScenesAreReadyToRun) {
  for (const std::string& kind : {std::string("strip"), "image " + labels_}) {
    const std::string file = out(kind.substr(0, 5) + ".toml");
    const Outcome made = test::done("new " + kind + " --out " + file);
    test::done("check " + file);
    const Outcome run = test::done("run " + file);
    EXPECT_EQ(maille_command("new " + kind + " --out " + file).code, 2) << "it is there";
    test::done("new " + kind + " --overwrite --out " + file);
  }
  const std::string world = out("press.toml");
  test::done("new world --out " + world);
  const Outcome played = test::done("play " + world + " " + out("press_path.toml") + " --json");
  EXPECT_EQ(json::parse(played.out)["frames"].size(), 20U);
  test::refused("new image");
  test::refused("new strip " + labels_ + " --out " + out("b.toml"));
}

TEST_F(WarpCommandContract, SaysWhatHasLeftTheImage) {
  test::LabelArray block = test::bent_body();
  block.size = {14, 14, 12}; // room at its sides, none at its ends
  block.values.assign(14 * 14 * 12, 0);
  for (int k = 0; k < 12; ++k)
    for (int j = 2; j < 12; ++j)
      for (int i = 2; i < 12; ++i)
        block.values[static_cast<std::size_t>(i + 14 * (j + 14 * k))] = 17;
  folder_.write("block.nii", test::nifti_of(block));
  const auto pulled = [&](const char* by) {
    return folder_
        .write(
            "block.toml",
            std::string("[specimen]\nshape = \"image\"\nimage = \"block.nii\"\nlabels = { 17 = "
                        "\"muscle/soleus\" }\nfibre = [0, 0, 1]\n[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = "
                        "\"z+\"\nby = [0, 0, \"") +
                by + "\"]\n")
        .string();
  };
  const Outcome out_of_it = test::done("warp " + pulled("6 mm") + " --out " + out("a"));
  EXPECT_TRUE(test::has(out_of_it.out, "label 17's volume is not in the warped image"));
  const Outcome within = maille_command("warp " + pulled("-6 mm") + " --out " + out("b"));
  EXPECT_FALSE(test::has(within.out, "not in the warped image"));
}

// Two legs, further apart than they are long: pulled along themselves, both of them.
TEST_F(WarpCommandContract, ANewSceneOfPartsThatDoNotTouchHoldsThemAll) {
  test::LabelArray legs = test::bent_body();
  legs.size = {24, 3, 8};
  legs.values.assign(24 * 3 * 8, 0);
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 3; ++j)
      for (const int i : {0, 1, 2, 21, 22, 23})
        legs.values[static_cast<std::size_t>(i + 24 * (j + 3 * k))] = i < 3 ? 3 : 4;
  const std::string file = out("legs.toml");
  const std::string image = folder_.write("legs.nii", test::nifti_of(legs)).string();
  test::done("new image " + image + " --out " + file);
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.specimen.n_matter_cells(), 2 * 3 * 3 * 8);
  EXPECT_TRUE(scene.left_out.empty());
  EXPECT_EQ(scene.prescribed.size(), std::size_t{3 * 2 * 2 * 4 * 4}) << "both ends of both legs";
}

} // namespace
} // namespace maille
