/// No option of any command writes over a file that a command opens. Which files those are, the system says
/// (MAILLE_OPENED of support/faulty_files.cpp), not a list.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <cstring>

namespace maille {
namespace {

namespace fs = std::filesystem;

/// An element of explicit VR, little endian; values have even lengths.
std::string element(std::uint16_t group, std::uint16_t number, const std::string& kind, std::string value) {
  const auto two = [](std::size_t n) {
    return std::string{static_cast<char>(n & 255U), static_cast<char>(n >> 8U & 255U)};
  };
  if (value.size() % 2 != 0)
    value += kind == "UI" ? '\0' : ' ';
  const std::string length = kind == "OW" ? two(0) + two(value.size()) + two(0) : two(value.size());
  return two(group) + two(number) + kind + length + value;
}

std::string number_of(int n) {
  return {static_cast<char>(n), '\0'};
}

/// Three slices of 4 x 3 pixels of 1.
void write_series(const test::TemporaryFolder& folder, const std::string& name) {
  fs::create_directory(folder / name);
  const std::string syntax = element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  const std::string size{static_cast<char>(syntax.size()), '\0', '\0', '\0'};
  std::string pixels;
  for (int i = 0; i < 12; ++i)
    pixels += number_of(1);
  for (int slice = 0; slice < 3; ++slice)
    folder.write(fmt::format("{}/s{}.dcm", name, slice),
                 std::string(128, '\0') + "DICM" + element(2, 0, "UL", size) + syntax +
                     element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(8, 0x60, "CS", "CT") +
                     element(0x20, 0xe, "UI", "1.2.3") +
                     element(0x20, 0x32, "DS", fmt::format("0\\0\\{}", slice)) +
                     element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + element(0x28, 2, "US", number_of(1)) +
                     element(0x28, 4, "CS", "MONOCHROME2") + element(0x28, 0x10, "US", number_of(3)) +
                     element(0x28, 0x11, "US", number_of(4)) + element(0x28, 0x30, "DS", "1\\1") +
                     element(0x28, 0x100, "US", number_of(16)) + element(0x28, 0x101, "US", number_of(16)) +
                     element(0x28, 0x102, "US", number_of(15)) + element(0x28, 0x103, "US", number_of(0)) +
                     element(0x7fe0, 0x10, "OW", pixels));
}

/// 4 x 3 x 3 voxels of 1 in 8 bits, by the ending; of headers with the data beside.
void write_voxels(const test::TemporaryFolder& folder, const std::string& name) {
  if (name == "series")
    return write_series(folder, name);
  const std::string data(36, '\1');
  const std::string stem = name.substr(0, name.find('.'));
  const bool is_apart = name.ends_with("hdr") || name.ends_with("mhd");
  const std::string nrrd =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 3\nspace: left-posterior-superior\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n";
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 3\nElementSpacing = 1 1 1\nAnatomicalOrientation = RAI\n"
      "ElementType = MET_UCHAR\nElementDataFile = ";
  if (is_apart)
    folder.write(stem + ".raw", data);
  if (name.ends_with(".nii")) {
    std::string header(352, '\0');
    const auto put = [&](std::size_t at, auto value) {
      std::memcpy(header.data() + at, &value, sizeof value);
    };
    put(0, std::int32_t{348});
    put(40, std::array<std::int16_t, 8>{3, 4, 3, 3, 1, 1, 1, 1});
    put(70, std::array<std::int16_t, 2>{2, 8}); // uint8
    put(76, std::array<float, 4>{1, 1, 1, 1});
    put(108, std::array<float, 2>{352, 1});
    header[123] = 2;           // mm
    put(254, std::int16_t{1}); // sform: as RAI of the others, so LPS turned to RAS
    put(280, std::array<float, 12>{-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0});
    folder.write(name, header.replace(344, 3, "n+1") + data);
    return;
  }
  if (name.ends_with(".nhdr"))
    folder.write(name, nrrd + "data file: " + stem + ".raw\n");
  else if (name.ends_with(".nrrd"))
    folder.write(name, nrrd + "\n" + data);
  else
    folder.write(name, meta + (is_apart ? stem + ".raw\n" : "LOCAL\n" + data));
}

constexpr const char* patch =
    "solid p SPACE=LPS\nfacet normal 1 0 0\nouter loop\nvertex 3 0 0\nvertex 3 3 0\nvertex 3 0 3\n"
    "endloop\nendfacet\nendsolid p\n";

/// A body of a file, moved where another file says. @return the scene
fs::path scene_of(const test::TemporaryFolder& folder, const std::string& labels, const std::string& region) {
  write_voxels(folder, labels);
  folder.write("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  std::string where = "{ image = \"" + region + "\" }";
  if (region.ends_with(".stl")) {
    folder.write(region, patch);
    where = "{ surface = \"" + region + "\", within = \"1 mm\" }";
  } else if (region.ends_with(".fcsv")) {
    folder.write(region, "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = "
                         "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                         "1,3,1,1,0,0,0,1,1,1,0,F-1,,\n");
    where = "{ points = \"" + region + "\", within = \"2 mm\" }";
  } else if (region.ends_with(".json")) {
    folder.write(region, R"({"markups": [{"coordinateSystem": "LPS", "controlPoints": [)"
                         R"({"id": "1", "label": "F-1", "position": [3, 1, 1]}]}]})");
    where = "{ points = \"" + region + "\", within = \"2 mm\" }";
  } else {
    write_voxels(folder, region);
  }
  return folder.write("scene.toml",
                      "[specimen]\nshape = \"image\"\nimage = \"" + labels +
                          "\"\nlabels = { 1 = \"soft.toml\" }\n[[hold]]\nwhere = \"x-\"\n[[move]]\n"
                          "where = { all = [\"x+\", " +
                          where + "] }\nby = [\"0.1 mm\", 0, 0]\n");
}

TEST(OpenedInputsContract, NoOptionWritesOverWhatACommandOpens) {
  const std::vector<std::string> options{
      "check IN --json FILE",
      "check --why IN --json FILE",
      "check --why IN --picture FILE",
      "run IN --methods limits --json FILE",
      "run IN --methods limits --picture FILE",
      "run IN --methods limits --steps 2 --film FILE",
      "compare IN --methods limits --reference limits --csv FILE",
      "compare IN --methods limits --reference limits --json FILE",
      "compare IN --methods limits --reference limits --picture FILE",
      "play IN FILE --json FILE",
      "play IN FILE --picture FILE",
      "study FILE --out OUT --json FILE",
      "run IN --write FILE",
      "study trade IN --methods limits --spacings 1 --tolerances 0.1 --reference limits --repetitions 1 "
      "--csv FILE",
      "study trade IN --methods limits --spacings 1 --tolerances 0.1 --reference limits --repetitions 1 "
      "--json "
      "FILE",
      "study choose IN --error 90% --time 60s --json FILE",
      "study choose IN --error 90% --time 60s --table FILE --json FILE",
      "fit IN --test IN --reference relaxed --trials 2 --out FILE",
      "fit IN --test IN --reference relaxed --trials 2 --json FILE",
      "fit IN FILE --json FILE",
      "fit IN --measured FILE --unknown specimen.labels.1.youngs_modulus --out FILE",
      "render IN --out FILE",
      "render IN --json FILE",
      "report OUT --out FILE",
      "play IN FILE --csv FILE",
      "warp IN --methods limits --out OUT/w_ --json FILE"};
  int n_scenes = 0, n_files = 0, n_tried = 0;
  std::size_t option = 0;
  for (const std::string labels :
       {"labels.nrrd", "labels.nhdr", "labels.mhd", "labels.mha", "labels.nii", "series"})
    for (const std::string region :
         {"mask.nhdr", "mask.mhd", "mask.nii", "patch.stl", "points.fcsv", "points.mrk.json"}) {
      if (labels == "series" && region.starts_with("mask"))
        continue; // stands elsewhere
      const test::TemporaryFolder folder;
      const std::string scene = scene_of(folder, labels, region).string(),
                        log = (folder / "opened.log").string();
      const test::Outcome read = test::shell(
          fmt::format("ASAN_OPTIONS=verify_asan_link_order=0 MAILLE_FAULT_UNDER={} MAILLE_OPENED={} "
                      "LD_PRELOAD={} {} check {}",
                      folder.path().string(), log, MAILLE_FAULTY_FILES, MAILLE_COMMAND, scene));
      ASSERT_EQ(read.code, 0) << labels << " " << region << read.err << read.out;
      std::set<std::string> opened;
      std::ifstream stream(log);
      for (std::string line; std::getline(stream, line);)
        if (fs::is_regular_file(line))
          opened.insert(line);
      EXPECT_GE(opened.size(), 4U) << "scene, labels, material and region";
      ++n_scenes;
      fs::create_directory(folder / "out");
      for (const std::string& file : opened) {
        ++n_files;
        for (int i = 0; i < 2; ++i, ++option) {
          const std::string name = i == 1 ? (folder / "link.png").string() : file; // by another name, too
          fs::remove(folder / "link.png");
          if (i == 1)
            fs::create_hard_link(file, name);
          const std::string line =
              test::with_paths(options[option % options.size()],
                               {{"IN", scene}, {"FILE", name}, {"OUT", (folder / "out").string()}});
          const std::string before = test::text_of(file);
          const test::Outcome run = test::maille_command(line);
          ++n_tried;
          ASSERT_TRUE(fs::is_regular_file(file) && test::text_of(file) == before) << line << file;
          const bool is_told = run.err.find("this command reads") != std::string::npos;
          EXPECT_TRUE(run.code == 2 && (!is_told || std::ranges::count(run.err, '\n') == 1))
              << line << run.err;
        }
      }
    }
  fmt::print("inputs_lost = 0 ({} scenes, {} files, {} runs)\n", n_scenes, n_files, n_tried);
  EXPECT_GE(n_scenes, 30);
  EXPECT_GE(n_tried, 300);
}

const std::string world = test::world_text("[12, 8]") +
                          test::object_text("wall", "fixed", "[1, 8]", "position = [\"9 mm\", 0]\n") +
                          test::object_text("a box", "rigid", "[2, 2]", "position = [\"2 mm\", \"3 mm\"]\n");
constexpr const char* pushed =
    "frame_time = \"100 ms\"\n[[drive]]\nobject = \"a box\"\nby = [\"3 mm\", 0]\nframes = 2\n";

// Every file that a command writes, replaced by another program's file, which may speak of Maille, and by a
// link to one.
TEST(ForeignResultsContract, NoCommandReplacesThem) {
  const std::vector<std::string> commands{
      "run IN --methods limits --steps 2 --overwrite --out OUT",
      "run IN --methods limits --maps --warp --surface stl,ply,vtp --also mha,nrrd --out OUT",
      "compare IN --methods limits --reference limits --overwrite --out OUT",
      "study trade IN --methods limits,relaxed --spacings 1 --tolerances 0.1 --reference relaxed "
      "--repetitions 1 "
      "--out OUT",
      "warp IN --methods limits --surface stl,ply,vtp --also mha,nrrd --out OUT",
      "play WORLD --out OUT"};
  const std::vector<std::string> foreign{
      "a,b\n1,2\n",
      "of maille\n# maille\nComment = maille\n{\"a\": {\"maille\": \"1\"}}\n" + std::string(99, '.')};
  int n_tried = 0, n_lost = 0;
  for (const std::string& command : commands) {
    const test::TemporaryFolder folder;
    const fs::path out = folder / "out", kept = folder / "kept";
    const std::string played =
        folder.write("world.toml", world).string() + " " + folder.write("pushed.toml", pushed).string();
    const std::string line =
        test::with_paths(command, {{"IN", scene_of(folder, "labels.mha", "mask.nhdr").string()},
                                   {"WORLD", played},
                                   {"OUT", out.string()}});
    test::done(line);
    test::done(line); // replaces its own files
    fs::copy(out, kept);
    for (const auto& entry : fs::directory_iterator(kept))
      for (const bool is_link : {false, true}) {
        const std::string text = foreign[static_cast<unsigned>(n_tried) / 2 % 2];
        const fs::path mine = folder.write("mine.csv", text);
        fs::remove_all(out);
        fs::copy(kept, out);
        const fs::path file = out / entry.path().filename();
        fs::remove(file);
        is_link ? fs::create_symlink(mine, file) : fs::copy(mine, file);
        EXPECT_TRUE(test::has(test::refused(line).err, file.filename().string())) << line << file;
        n_lost +=
            test::text_of(mine) != text || test::text_of(file) != text || fs::is_symlink(file) != is_link;
        ++n_tried;
      }
  }
  fmt::print("foreign_results_replaced = {} of {}\n", n_lost, n_tried);
  EXPECT_EQ(n_lost, 0);
  EXPECT_GE(n_tried, 100);
}

TEST(ForeignResultsContract, NamesOfNoneThatIsAskedForAreLeftAlone) {
  const test::TemporaryFolder folder;
  const std::string scene = scene_of(folder, "labels.mha", "mask.nhdr").string();
  const std::vector<std::string> names{
      "scene_relaxed_0001.vti",  "scene_relaxed.vti", "scene_limits_0007.vti", "scene_fem_q1_0000.vtu",
      "scene_play_results.json", "scene.pvd",         "scene_trade.json",      "scene_fem_q1_labels.nii.gz"};
  for (const std::string& name : names)
    folder.write("out/" + name, "mine");
  const std::string asked = " " + scene + " --methods limits --out " + (folder / "out").string();
  test::done("run" + asked);
  test::done("compare" + asked + " --reference limits");
  for (const std::string& name : names)
    EXPECT_EQ(test::text_of(folder / ("out/" + name)), "mine") << name;
}

TEST(OpenedInputsContract, AChangedSliceIsAnotherScene) {
  const test::TemporaryFolder folder;
  scene_of(folder, "series", "patch.stl");
  const fs::path study =
      folder.write("study.toml", "scene = \"scene.toml\"\nmethods = [\"limits\"]\nreference = \"none\"\n"
                                 "[[parameter]]\nkey = \"move.0.by.0\"\nvalues = [\"0.1 mm\"]\n");
  const std::string line = "study " + study.string() + " --out " + (folder / "out").string() + " --resume";
  test::done(line);
  EXPECT_TRUE(test::has(test::done(line).out, "1 rows were there"));
  std::string slice = test::text_of(folder / "series/s1.dcm");
  slice[slice.size() - 2] = 0; // a pixel
  folder.write("series/s1.dcm", slice);
  EXPECT_FALSE(test::has(test::done(line).out, "rows were there"));
}

} // namespace
} // namespace maille
