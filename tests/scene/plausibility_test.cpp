// What a question asks for, in proportion to its body.

#include "maille/scene/look.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

/// A strip of 60 x 20 x 20 mm, held at x-.
std::string strip(const std::string& rest, const std::string& spacing = "5 mm",
                  const std::string& material = "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }") {
  return "[specimen]\nshape = \"box\"\ncells = [12, 4, 4]\nspacing = \"" + spacing +
         "\"\nmaterial = " + material + "\n[[hold]]\nwhere = \"x-\"\n" + rest;
}

std::string pulled(const std::string& by) {
  return "[[move]]\nwhere = \"x+\"\nby = [\"" + by + "\", 0, 0]\n";
}

Plausibility of(const std::string& text) {
  return plausibility(parse_scene(text));
}

// Truth: lengths and quotients of the numbers in the texts.
TEST(PlausibilityAnalytic, SizesMovesAndStrainsAreThoseOfTheText) {
  const Scene scene = parse_scene(strip(pulled("3 mm")));
  const Plausibility found = plausibility(scene);
  EXPECT_DOUBLE_EQ(found.size[0], 60e-3);
  EXPECT_NEAR(found.largest_move, 3e-3, 1e-15);
  EXPECT_NEAR(found.move_over_length, 0.05, 1e-12);
  EXPECT_NEAR(found.mean_strain.value(), 0.05, 1e-12);
  EXPECT_FALSE(found.strain_of_loads);
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  EXPECT_EQ(in_words(scene, found),
            "size 60 x 20 x 20 mm; largest move 3 mm, 5 % of the length; mean strain 5 %");

  // A poke of 2 mm from the side, 20 mm above the nearest held node.
  const Plausibility poke =
      of("[specimen]\nshape = \"box\"\ncells = [12, 4, 4]\nspacing = \"5 mm\"\nmaterial = \"muscle/soleus\"\n"
         "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = { box = [[\"30 mm\", \"10 mm\", \"20 mm\"], [\"30 "
         "mm\", \"10 mm\", "
         "\"20 mm\"]] }\nby = [0, 0, \"-2 mm\"]\n");
  EXPECT_NEAR(poke.mean_strain.value(), 0.1, 1e-12);

  // A plane of symmetry along the pull holds nothing against it.
  const Plausibility symmetric = of(strip(pulled("3 mm") + "[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n"));
  EXPECT_NEAR(symmetric.mean_strain.value(), 0.05, 1e-12);

  // Nothing is held: both ends go apart by 2 mm.
  const Plausibility apart =
      of("[specimen]\nshape = \"box\"\ncells = [10]\nspacing = \"2 mm\"\nmaterial = \"muscle/soleus\"\n"
         "[[move]]\nwhere = \"x-\"\nby = \"-1 mm\"\n[[move]]\nwhere = \"x+\"\nby = \"1 mm\"\n");
  EXPECT_NEAR(apart.mean_strain.value(), 0.1, 1e-12);
}

TEST(PlausibilityContract, WhatIsOutOfProportionIsSaid) {
  const auto warns = [](const std::string& text, const std::string& of_what) {
    for (const std::string& warning : of(text).warnings)
      if (warning.find(of_what) != std::string::npos)
        return true;
    return false;
  };
  EXPECT_TRUE(warns(strip(pulled("60 mm")), "mean strain of 100 %"));
  EXPECT_TRUE(warns(strip(pulled("6 m")), "is it in the unit that was meant"));
  EXPECT_TRUE(warns(strip("", "2 m"), "cells of 2 m"));
  EXPECT_TRUE(warns(strip("", "2 m"), "a body of 24 m"));
  EXPECT_TRUE(warns(strip("[[load]]\ncontraction = \"20 kPa\"\n"), "contraction is 200 %"));
  EXPECT_TRUE(warns(strip("[[load]]\nwhere = \"x+\"\ntraction = [\"2 kPa\", 0, 0]\n"), "traction is 20 %"));
  EXPECT_TRUE(warns(strip(pulled("30 mm"), "5 mm", "\"liver/parenchyma\""), "fails at a stretch"));
  EXPECT_TRUE(warns(strip(pulled("30 mm") + "[relaxation]\nframe = \"blocks\"\n"), "linear in strain"));
  EXPECT_TRUE(warns(strip("[[load]]\ncontraction = \"20 kPa\"\n[relaxation]\nframe = \"blocks\"\n"),
                    "turn inside out"));
}

// Truth: each text states something of no effect, or other than it seems; the first has nothing of the kind.
TEST(PlausibilityContract, StatementsWithoutTheirEffectAreSaid) {
  const std::string block = "[specimen]\nshape = \"box\"\ncells = [12, 4, 4]\nspacing = \"5 mm\"\n",
                    hold = "[[hold]]\nwhere = \"x-\"\n",
                    soft = "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n";
  const auto turned = [&](const std::string& angle) {
    return strip("[[move]]\nwhere = \"x+\"\nturn = { angle = \"" + angle + "\", axis = [1, 0, 0] }\n");
  };
  EXPECT_TRUE(of(turned("14 deg")).warnings.empty());
  const std::vector<std::pair<std::string, std::string>> said{
      {turned("16 deg"), "move[1] turns by 16 degrees"},
      {turned("360 deg"), "move[1] is zero"},
      {strip(pulled("0 mm")), "move[1] is zero"},
      {strip("[[load]]\nwhere = \"x+\"\npressure = 0\n"), "load[1] is zero"},
      {strip("[[load]]\ngravity = [0, 0, 0]\n"), "load[1] is zero"},
      {strip("[[load]]\ncontraction = 0\n"), "contraction of 0"},
      {strip("[[load]]\ncontraction = \"1 kPa\"\ncourse = [[0, 0], [0.5, 1], [1, 0]]\n"),
       "ends at 0 by its course"},
      {strip("[[drive]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\ncourse = [[0, 0], [0.5, 1], [1, 0]]\n"),
       "ends where it began"},
      {strip(pulled("1 mm") + hold), "hold[2] has no effect"},
      {"[specimen]\nshape = \"box\"\ncells = [6, 4]\nspacing = \"1 mm\"\nfibre = [0, 0, 1]\n" + soft + hold +
           "[[load]]\ncontraction = \"1 kPa\"\n",
       "its fibres lie across the plane"},
      {strip("[[move]]\nwhere = { box = [[\"60 mm\", 0, 0], [\"60 mm\", 0, 0]] }\nby = [\"1 mm\", 0, 0]\n"),
       "moves a single node"},
      {strip("[[load]]\nwhere = { box = [[\"60 mm\", 0, 0], [\"60 mm\", \"5 mm\", \"5 mm\"]] }\n"
             "pressure = \"1 Pa\"\n"),
       "face of a single cell"},
      {strip("[[load]]\nwhere = \"x-\"\npressure = \"1 Pa\"\n"), "nothing but the forces there"},
      {block + soft +
           "[test]\nkind = \"axial\"\naxis = \"x\"\nstrain = 0.01\n[[load]]\ngravity = [0, 0, \"1 m/s^2\"]\n",
       "[test] beside loads"},
      {block + "material = { youngs_modulus = 60, poisson_ratio = 0.3 }\n" + hold, "modulus 60 to 60 Pa"},
      {block + "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, density = 1.06 }\n" + hold,
       "density 1.06 kg/m^3"},
  };
  for (const auto& [text, words] : said) {
    const auto warnings = of(text).warnings;
    EXPECT_TRUE(std::ranges::any_of(
        warnings, [&](const std::string& warning) { return warning.find(words) != std::string::npos; }))
        << words << " in\n"
        << text << (warnings.empty() ? "nothing" : warnings.front());
  }
}

// Truth: docs/keys.md says whose each setting is.
TEST(PlausibilityContract, SettingsThatNoMethodReadsAreSaid) {
  const Scene scene =
      parse_scene(strip("[relaxation]\nframe = \"blocks\"\nsweeps = 7\nmode = \"deformable\"\n"));
  EXPECT_EQ(unused_settings(scene, {"coupled", "sweep"}).size(), 1U) << "it asks nothing";
  EXPECT_EQ(unused_settings(scene, {"relaxed"}).size(), 3U);
  EXPECT_EQ(unused_settings(scene, {"fem_q1", "limits"}).size(), 3U) << "fem_q1 knows finite strain";
  EXPECT_EQ(unused_settings(parse_scene(strip(pulled("1 mm"))), {"coupled"}).size(), 0U);
}

// Truth: an end of 4 x 4 cells of 5 mm; the whole of it, and a patch of one cell's width.
TEST(PlausibilityAnalytic, PartsHaveTheirNodesAreaAndShare) {
  const auto parts = stated_parts(
      parse_scene(strip("[[load]]\nwhere = { box = [[\"60 mm\", 0, 0], [\"60 mm\", \"20 mm\", \"5 mm\"]] }\n"
                        "pressure = \"1 Pa\"\n")));
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].nodes, 25);
  EXPECT_NEAR(parts[0].area, 400e-6, 1e-15);
  EXPECT_NEAR(parts[0].share, 1, 1e-12);
  EXPECT_EQ(parts[1].nodes, 10);
  EXPECT_NEAR(parts[1].area, 100e-6, 1e-15);
  EXPECT_NEAR(parts[1].share, 0.25, 1e-12);
}

// Truth: `low` stands on the world's floor, `up` above it.
TEST(PlausibilityContract, ObjectsAtTheBorderOfTheirWorldAreNamed) {
  const auto of_world = [](const std::string& z) {
    return world_warnings(parse_world_scene(
        "[world]\ncells = [10, 10, 24]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n[[object]]\nname = "
        "\"low\"\nkind = \"deformable\"\nshape = \"box\"\ncells = [4, 4, 8]\nmaterial = { youngs_modulus "
        "= \"5 kPa\", poisson_ratio = 0.0 }\nposition = [\"3 mm\", \"3 mm\", \"" +
        z + "\"]\n"));
  };
  EXPECT_TRUE(of_world("1 mm").empty());
  ASSERT_EQ(of_world("0 mm").size(), 1U);
  EXPECT_TRUE(test::has(of_world("0 mm").front(), "low: it lies at the world's border z-"));
}

// Truth: shipped scenes are examples of what to write.
TEST(PlausibilityContract, ShippedScenesDrawNoWarning) {
  int shipped_warnings = 0;
  for (const char* folder : {"", "render", "world"})
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(MAILLE_SCENES) / folder)) {
      if (entry.path().extension() != ".toml")
        continue;
      std::vector<std::string> warnings;
      try {
        warnings = is_world_scene(entry.path()) ? world_warnings(read_world_scene(entry.path()))
                                                : plausibility(read_scene(entry.path())).warnings;
      } catch (const InputError&) {
        continue; // a trajectory, or an image of MAILLE_DATA
      }
      shipped_warnings += static_cast<int>(warnings.size());
      for (const std::string& warning : warnings)
        ADD_FAILURE() << entry.path() << ": " << warning;
    }
  std::cout << "shipped_warnings " << shipped_warnings << '\n';
}

// Truth: an image that is stored superior, right, anterior-reversed.
TEST(PlausibilityOracle, FibresAndGravityPointInThePatient) {
  const auto words = [](const std::string& fibre, const std::string& load, WorldAxes world) {
    const Affine affine{{{0, 1e-3, 0, 0}, {0, 0, -1e-3, 0}, {1e-3, 0, 0, 0}, {0, 0, 0, 1}}};
    const Scene scene =
        SceneBuilder()
            .labels(std::vector<std::uint8_t>(27, 1), ArrayLayout::x_fastest({3, 3, 3}), affine)
            .world(world)
            .keys("[specimen]\nmaterial = \"muscle/soleus\"\n" + fibre +
                  "\n[[hold]]\nwhere = \"x-\"\n[[load]]\n" + load)
            .build();
    return in_words(scene, plausibility(scene));
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_TRUE(test::has(text, part));
  };
  const std::string plain = words("fibre = [1, 0, 0]", "gravity = [9.81, 0, 0]", WorldAxes::ras);
  has(plain, "\nfibres along x of the grid: inferior-superior");
  has(plain, "\ngravity points to superior (x of the grid)");
  const std::string asked = words("fibre = { direction = [0, 3, 0], frame = \"lps\" }",
                                  "gravity = [0, 1, 0]\nframe = \"lps\"", WorldAxes::ras);
  has(asked, "fibres along z of the grid: anterior-posterior");
  has(asked, "gravity points to posterior (z of the grid)");
  has(words("fibre = { angle = \"30 deg\", plane = \"zx\", frame = \"world\" }", "gravity = [0, -1, 0]",
            WorldAxes::lps),
      "inferior-superior, 30 deg off");
  has(words("fibre = [1, 0, 0]", "gravity = [0, -1, 0]", WorldAxes::lps),
      "gravity points to right (-y of the grid)");
  has(words("fibre = [1, 0, 0]", "gravity = [0, -1, 0]", WorldAxes::unknown),
      "gravity points along -y of the grid");
  EXPECT_THROW(
      words("fibre = { direction = [0, 3, 0], frame = \"ras\" }", "gravity = [1, 0, 0]", WorldAxes::unknown),
      InputError);
  EXPECT_THROW(
      words("fibre = { direction = [0, 0, 0], frame = \"ras\" }", "gravity = [1, 0, 0]", WorldAxes::ras),
      InputError);
}

PartMechanics strained_by(double percentile_5, double percentile_95) {
  PartMechanics body;
  body.von_mises = Spread{};
  body.smallest_strain = Spread{.percentile_5 = percentile_5};
  body.largest_strain = Spread{.percentile_95 = percentile_95};
  return body;
}

// Truth: small strains end at 10 %, and a fifth of 60 mm is 12 mm.
TEST(PlausibilityContract, AnswersThatSmallStrainsDoNotAllowAreSaid) {
  const Scene loaded = parse_scene(strip("[[load]]\ngravity = [0, 0, \"-9.81 m/s^2\"]\n", "5 mm",
                                         "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, density = "
                                         "\"1000 kg/m^3\" }"));
  const auto warnings = [&](double displacement, const PartMechanics& body) {
    return implausible_answer(loaded, plausibility(loaded), "coupled", displacement, body).size();
  };
  EXPECT_EQ(warnings(11.9e-3, strained_by(-0.09, 0.09)), 0U);
  EXPECT_EQ(warnings(12.1e-3, strained_by(-0.09, 0.09)), 1U) << "far";
  EXPECT_EQ(warnings(1e-3, strained_by(-0.11, 0.01)), 1U) << "pressed";
  EXPECT_EQ(warnings(1e-3, strained_by(-0.01, 0.11)), 1U) << "stretched";
  EXPECT_EQ(warnings(30e-3, strained_by(-0.3, 0.3)), 2U);
  PartMechanics without_stress = strained_by(-0.3, 0.3);
  without_stress.von_mises.reset();
  EXPECT_EQ(warnings(30e-3, without_stress), 0U) << "limits know no small strains";

  const auto warnings_of = [](const std::string& text, double displacement) {
    return implausible_answer(parse_scene(text), of(text), "coupled", displacement, strained_by(-0.3, 0.3))
        .size();
  };
  EXPECT_EQ(warnings_of(strip(pulled("20 mm")), 20e-3), 0U) << "the question is warned of already";
  EXPECT_EQ(warnings_of(strip(pulled("3 mm")), 3e-3), 1U);
  EXPECT_EQ(warnings_of(strip(pulled("3 mm") + "[relaxation]\nframe = \"blocks\"\n"), 3e-3), 0U);
}

// Truth: columns at the end of the bar of 12 x 16 cells are strained alone, each a twelfth of it.
TEST(PlausibilityAnalytic, AnAnswerThatIsInsideOutFails) {
  const Scene scene = parse_scene(strip(pulled("3 mm")));
  const Grid& grid = scene.specimen.grid;
  const auto checked = [&](const char* method, double strain, int columns) {
    Answer answer;
    answer.method = method;
    answer.status = Status::done;
    answer.displacement = Displacement(grid);
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      answer.displacement(0, node) = strain * 5e-3 * std::max(0, grid.node_at(node)[0] - (12 - columns));
    fail_where_inside_out(scene, answer);
    return answer;
  };
  EXPECT_EQ(checked("coupled", -0.99, 12).status, Status::done);
  EXPECT_EQ(checked("fem_q2", 1.99, 12).status, Status::done);
  EXPECT_TRUE(checked("fem_q2", -1.01, 1).displacement.empty());
  EXPECT_TRUE(checked("coupled", 2.01, 1).message.starts_with("16 of 192 cells are turned inside out"));
  EXPECT_EQ(checked("limits", -1.01, 12).status, Status::done) << "knows no strains";
}

// Analytic: nu 0, so a stretch by 10 % has the Cauchy stress G (1.1 - 1 / 1.1), which is 0.095 E.
TEST(PlausibilityAnalytic, AStressThatNoMatterBearsFails) {
  const auto status = [](const std::string& modulus) {
    const Scene scene = parse_scene(
        "strain = \"finite\"\n" +
        strip(pulled("6 mm"), "5 mm", "{ law = \"neo_hookean\", E = \"" + modulus + "\", nu = 0 }"));
    Answer answer;
    answer.method = "coupled";
    answer.status = Status::done;
    answer.displacement = Displacement(scene.specimen.grid);
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      answer.displacement(0, node) = 0.1 * 5e-3 * scene.specimen.grid.node_at(node)[0];
    fail_where_inside_out(scene, answer);
    EXPECT_EQ(answer.displacement.empty(), answer.status == Status::failed);
    return answer.status;
  };
  EXPECT_EQ(status("5000 GPa"), Status::done);
  EXPECT_EQ(status("20000 GPa"), Status::failed);
}

TEST(PlausibilityContract, WorldsNameTheirOwnKeys) {
  const auto warnings = [](const std::string& more) {
    std::string all;
    for (const std::string& warning : world_warnings(parse_world_scene(
             test::world_text("[20, 20, 20]") +
             test::object_text("body", "deformable", "[6, 6, 6]",
                               "material = { law = \"neo_hookean\", E = \"10 kPa\", nu = 0.3 }\n"
                               "position = [\"6 mm\", \"6 mm\", \"6 mm\"]\n" +
                                   more))))
      all += warning + "\n";
    return all;
  };
  EXPECT_TRUE(test::has(warnings(""), "relaxation = { frame = \"blocks\" }"));
  EXPECT_FALSE(test::has(warnings(""), "strain ="));
  EXPECT_EQ(warnings("relaxation = { frame = \"blocks\" }\n"), "");
}

// Looks of scene files: what they mean, and every fault in them.

/// A scene of an image of 4 x 4 x 4 voxels with the values 0 to 63.
class LooksContract : public testing::Test {
protected:
  LooksContract() {
    std::string values(64, '\0');
    std::iota(values.begin(), values.end(), '\0');
    folder_.write("grey.mha", test::meta_image({4, 4, 4}, values, "ElementSpacing = 1 1 2\n"));
  }
  std::filesystem::path scene(const std::string& look) {
    const auto file = folder_.path() / "scene.toml";
    std::ofstream(file)
        << "[specimen]\nshape = \"image\"\nimage = \"grey.mha\"\nthreshold = 30\nmaterial = { "
           "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
        << look << "\n[[hold]]\nwhere = \"z-\"\n";
    return file;
  }
  std::vector<Fault> faults_of(const std::string& look) {
    return test::faults_found_by([&] { read_looks(scene(look)); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(LooksContract, NoLookNoByte) {
  const auto looks = read_looks(scene(""));
  ASSERT_EQ(looks.size(), 1u);
  EXPECT_FALSE(looks[0]);
}

TEST_F(LooksContract, GreyValuesAreCutDownToWhatIsSeen) {
  const auto looks = read_looks(scene("look = { colours = [[0, \"#000000\"], [63, \"#ffffff\"]], opacity = "
                                      "[[40, 0], [48, 0.5]] }"));
  const Seen& seen = *looks.at(0);
  EXPECT_EQ(seen.grey.info.size, (Index3{4, 4, 3})); // values from 40 on, and a voxel more
  EXPECT_EQ(seen.grey.values.front(), 16);
  EXPECT_EQ(seen.bytes(), 48 * 4);
  EXPECT_NEAR(seen.look.opacity_at(44), 0.25, 1e-12);
  EXPECT_NEAR(seen.look.colour_at(31.5)[1], 0.5, 1e-6);
  EXPECT_EQ(seen.largest, 63);
}

TEST_F(LooksContract, AWindowStretchesAPreset) {
  const auto looks = read_looks(scene("look = { preset = \"grey\", window = [10, 50] }"));
  EXPECT_NEAR(looks.at(0)->look.colour_at(30)[0], 0.5, 1e-6);
  EXPECT_TRUE(looks.at(0)->look.shading.on);
}

TEST_F(LooksContract, ColourMapsOfParaView) {
  std::ofstream(folder_.path() / "map.json")
      << R"([{"Name": "mine", "RGBPoints": [0, 0, 0, 1, 2, 1, 0, 0], "Points": [0, 0, 0.5, 0, 2, 1, 0.5, 0]}])";
  const auto looks = read_looks(scene("look = { colours = \"map.json\", window = [20, 60] }"));
  EXPECT_NEAR(looks.at(0)->look.colour_at(40)[0], 0.5, 1e-6);
  EXPECT_NEAR(looks.at(0)->look.opacity_at(40), 0.5, 1e-12);
  // ParaView's own go from 0 to 1: on the values of an image they say nothing without a window.
  std::ofstream(folder_.path() / "own.json") << R"([{"RGBPoints": [0, 0, 0, 1, 1, 1, 0, 0]}])";
  EXPECT_TRUE(
      test::says_only(faults_of("look = { colours = \"own.json\" }"), {.key = "specimen.look.window"}));
  EXPECT_EQ(faults_of("look = { colours = \"own.json\", window = [0, 63] }").size(), 0u);
}

TEST_F(LooksContract, AnImageIsPutOnTheMiddleOfTheBodysOwn) {
  std::string values(128, '\0');
  std::iota(values.begin(), values.end(), '\0');
  folder_.write("fine.mha",
                test::meta_image({8, 8, 2}, values, "Offset = 100 200 -300\nElementSpacing = 0.5 0.5 2\n"));
  const std::string look = "look = { image = \"fine.mha\", preset = \"grey\", window = [0, 99], "
                           "opacity = [[0, 1], [99, 1]]";
  const Seen by_header = *read_looks(scene(look + " }")).at(0);
  EXPECT_NEAR(by_header.grey.info.origin[1], 0.2, 1e-12);
  const Seen in_the_middle = *read_looks(scene(look + ", place = \"middle\" }")).at(0);
  // Of 4 voxels 1 mm apart from 0 on the middle is at 1.5 mm; 8 voxels 0.5 mm apart reach 1.75 mm from it.
  EXPECT_NEAR(in_the_middle.grey.info.origin[0], -0.25e-3, 1e-12);
  EXPECT_NEAR(in_the_middle.grey.info.origin[2], 2e-3, 1e-12); // 4 voxels 2 mm apart: 3 mm; 2 reach 1 mm
  EXPECT_EQ(faults_of(look + ", place = \"corner\" }").size(), 1u);
  EXPECT_EQ(faults_of("look = { preset = \"grey\", window = [0, 9], place = \"middle\" }").size(), 1u);
}

TEST_F(LooksContract, TheQuestionIsTheSameWithAndWithoutALook) {
  const Scene with = read_scene(scene("look = { preset = \"grey\", window = [10, 50] }"));
  EXPECT_EQ(with.specimen.n_matter_cells(), read_scene(scene("")).specimen.n_matter_cells());
}

TEST_F(LooksContract, FaultsAreToldWithTheirKeys) {
  const std::string grey = "preset = \"grey\", window = [0, 9]";
  const std::vector<std::pair<std::string, std::string>> faulty{
      {"colours = [[5, \"#ffffff\"], [1, \"#000000\"]]", "colours"},
      {"colours = [[nan, \"#ffffff\"]]", "colours"},
      {"colours = [[5, \"white\"]]", "colours"},
      {grey + ", opacity = [[1, 0], [0, 1]]", "opacity"},
      {"preset = \"grey\"", "window"},
      {"preset = \"grey\", window = [5, 5]", "window"},
      {"preset = \"gray\", window = [0, 9]", "preset"},
      {grey + ", gloss = 2", "gloss"},
      {grey + ", shininess = -2", "shininess"},
      {grey + ", mode = \"isosurface\", isovalue = 99", "isovalue"}, // which the image does not have
      {"image = \"absent.mha\", " + grey, "image"},
      {"picture = \"absent.png\"", "picture"}};
  for (const auto& [keys, key] : faulty)
    EXPECT_TRUE(
        test::says_only(faults_of("look = { " + keys + " }"), {.key = "specimen.look." + std::string(key)}))
        << keys;
  EXPECT_TRUE(test::says_only(faults_of("look = { preset = \"ct_bone\" }"), {.expected = "0 to 63"}));
  EXPECT_THROW(read_scene(scene("look = { colour = \"red\" }")), InputError);
}

TEST_F(LooksContract, AnImageWithVoxelsThatAreNoNumbersIsAFault) {
  std::string values;
  for (int v = 0; v < 64; ++v)
    values += test::raw_bytes(v == 6 || v == 40 ? std::nanf("") : static_cast<float>(v));
  folder_.write("odd.mha", test::meta_image({4, 4, 4}, values, "ElementSpacing = 1 1 2\n", "MET_FLOAT"));
  const auto faults = faults_of("look = { image = \"odd.mha\", preset = \"grey\", window = [0, 63] }");
  EXPECT_TRUE(test::says_only(faults, {.key = "specimen.look.image", .found = "2 voxels"}));
  EXPECT_TRUE(test::has(faults[0].found, "[2, 1, 0]"));
}

} // namespace
} // namespace maille
