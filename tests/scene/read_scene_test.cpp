#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"

#include "maille/scene/link_limits.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

/// A whole scene around a `[specimen]` table's lines.
std::string scene_with(const std::string& specimen, const std::string& rest = "[[hold]]\nwhere = \"x-\"\n") {
  return "[specimen]\n" + specimen + "\n" + rest;
}

const std::string box = R"(shape = "box"
cells = [4, 2, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 })";

TEST(ReadSceneContract, TheDesignsExampleReads) {
  const Scene scene = parse_scene(R"(
title = "a strip of muscle, pulled"
[specimen]
shape    = "box"
cells    = [32, 8, 8]
spacing  = "1 mm"
material = "muscle/vastus_lateralis"
fibre    = [1, 0, 0]
[[hold]]
where = "x-"
axes  = "xyz"
[[move]]
where = "x+"
by    = ["2 mm", 0, 0]
axes  = "xyz"
[[load]]
where = "x+"
traction = ["1 kPa", 0, 0]
[[load]]
gravity = [0, 0, -9.81]
[limits]
from = "given"
stretch = [1.3, 1.1, 1.1]
compress = [0.8, 0.95, 0.95]
shear = 0.3
)");
  EXPECT_EQ(scene.title, "a strip of muscle, pulled");
  EXPECT_EQ(scene.dimension(), 3);
  EXPECT_EQ(scene.specimen.n_matter_cells(), 32 * 8 * 8);
  EXPECT_EQ(scene.specimen.n_matter_nodes(), 33 * 9 * 9);
  EXPECT_TRUE(scene.specimen.material_id.empty())
      << "a full box of one material pays for no material numbers";
  EXPECT_EQ(scene.materials.at(0).name, "muscle/vastus_lateralis");
  EXPECT_EQ(scene.prescribed.size(), 2u * 3 * 81);
  EXPECT_DOUBLE_EQ(scene.largest_prescribed(), 2e-3);
  EXPECT_EQ(scene.tractions.size(), 64u);
  EXPECT_DOUBLE_EQ(scene.tractions.front().traction[0], 1000);
  EXPECT_DOUBLE_EQ(scene.gravity[2], -9.81);
  EXPECT_EQ(scene.limits.from, LimitSource::given);
  EXPECT_DOUBLE_EQ(scene.limits.given.stretch[0], 1.3);
  EXPECT_DOUBLE_EQ(scene.limits.given.shear[2][1], 0.3);
}

TEST(ReadSceneContract, OneTwoAndThreeNumbersOfCellsGiveTheDimension) {
  const std::string head =
      "shape = \"box\"\nspacing = \"0.5 m\"\nmaterial = { youngs_modulus = 1, poisson_ratio = 0 }\ncells = ";
  EXPECT_EQ(parse_scene(scene_with(head + "[7]")).dimension(), 1);
  EXPECT_EQ(parse_scene(scene_with(head + "7")).specimen.n_matter_nodes(), 8);
  EXPECT_EQ(parse_scene(scene_with(head + "[7, 3]")).specimen.n_matter_nodes(), 8 * 4);
  EXPECT_EQ(parse_scene(scene_with(head + "[7, 3, 2]")).specimen.n_matter_nodes(), 8 * 4 * 3);
}

// Truth: the scene below and the file of the library.
TEST(ReadSceneContract, LawsOfLargeStrain) {
  const std::string head = "shape = \"box\"\ncells = [4, 2, 2]\nspacing = \"1 mm\"\nmaterial = ";
  const Scene neo = parse_scene(scene_with(head + "{ law = \"neo_hookean\", E = \"10 kPa\", nu = 0.25 }"));
  EXPECT_EQ(neo.materials.at(0).law, Law(NeoHookean{4e3, 4e3}));
  EXPECT_FALSE(neo.has_fibres());
  const Scene heart = parse_scene(scene_with(head + "\"heart/land_2015\"\nfibre = [0, 1, 0]"));
  EXPECT_EQ(heart.materials.at(0).law, Law(Guccione{2e3, 8, 2, 4, 4e5}));
  EXPECT_TRUE(heart.has_fibres());
  EXPECT_TRUE(test::says_only(
      test::faults_found_by([&] {
        parse_scene(
            scene_with(head + "{ law = \"mooney_rivlin\", parameters = { c1 = 1, c2 = 0, k = 1, bf = 8 } }"));
      }),
      {.key = "specimen.material.parameters.bf"}));
}

TEST(ReadSceneContract, RegionsSelectFacesAndBoxesInclusively) {
  const Scene scene = parse_scene(scene_with(box, R"(
[[hold]]
where = "x-"
axes = "x"
[[move]]
where = { box = [["4 mm", 0, "1 mm"], ["3 mm", "1 mm", "1 mm"]] }
by = ["1 mm", 0, 0]
axes = "xy"
)"));
  std::int64_t held = 0, moved = 0;
  for (const Prescribed& p : scene.prescribed)
    (p.held ? held : moved)++;
  EXPECT_EQ(held, 9);          // 3 x 3 nodes, one component
  EXPECT_EQ(moved, 2 * 2 * 2); // nodes x = 3, 4; y = 0, 1; z = 1; two components
}

TEST(ReadSceneContract, UnrequestedLimitsServeLimitMethodsOnly) {
  // Truth: docs/scene.md.
  const Scene plain = parse_scene(scene_with(box));
  EXPECT_EQ(plain.limits.from, LimitSource::none);
  EXPECT_EQ(plain.limit_source(), LimitSource::taut) << "the material has none of its own";
  const std::string own = R"(shape = "box"
cells = [4]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3, stretch = 1.2, compress = 0.9, shear = 0.1 })";
  const Scene scene = parse_scene(scene_with(own));
  EXPECT_EQ(scene.limits.from, LimitSource::none);
  EXPECT_FALSE(scene.limits_bind_relaxed() || scene.limits_bind_coupled());
  EXPECT_EQ(scene.limit_source(), LimitSource::material);
  EXPECT_NEAR(LinkLimits(scene).intervals({0, 0, 0}, 0)->high[0], 0.2e-3, 1e-15);
  const std::string hold = "[[hold]]\nwhere = \"x-\"\n[limits]\n";
  const Scene none = parse_scene(scene_with(own, hold + "from = \"none\"\n")),
              material = parse_scene(scene_with(own, hold + "from = \"material\"\n")),
              taut = parse_scene(scene_with(own, hold + "from = \"taut\"\ncut = \"allowed\"\n"));
  EXPECT_EQ(none.limits.from, LimitSource::none);
  EXPECT_TRUE(material.limits_bind_relaxed() && material.limits_bind_coupled());
  EXPECT_TRUE(taut.limits_bind_relaxed() && !taut.limits_bind_coupled());
  EXPECT_TRUE(taut.limits.cut_is_allowed && !material.limits.cut_is_allowed);
}

TEST(ReadSceneContract, StepsOfASceneWithoutLimitsSearchForNoScale) {
  // Truth: with_limits, which is asked to. The scale is that of the whole move, of a step or not.
  const Scene scene = parse_scene(
      scene_with(box, "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n"));
  EXPECT_FALSE(scaled(scene, 0.5).limits.taut_scale);
  const Scene limited = with_limits(scene);
  EXPECT_EQ(limited.limits.from, LimitSource::taut);
  ASSERT_TRUE(limited.limits.taut_scale);
  EXPECT_EQ(scaled(limited, 0.5).limits.taut_scale, limited.limits.taut_scale);
}

TEST(ReadSceneContract, NumbersWithoutUnitsAreInThoseOfTheFileOrRefused) {
  // Truth: 2 mm, 30 degrees, however they are written; 0 is 0 in any unit.
  const std::string
      head = "[specimen]\nshape = \"box\"\ncells = [4, 2, 2]\nmaterial = { youngs_modulus = \"10 kPa\", "
             "poisson_ratio = 0.3 }\n",
      hold = "[[hold]]\nwhere = \"x-\"\n";
  const std::string bare = head + "spacing = 2\nfibre = { angle = 30, plane = \"xz\" }\n" + hold;
  for (const char* units : {"mm, deg", " mm , deg ", "deg,mm"}) {
    const Scene scene = parse_scene("units = \"" + std::string(units) + "\"\n" + bare, "scene.toml");
    EXPECT_DOUBLE_EQ(scene.specimen.grid.spacing()[1], 2e-3) << units;
    EXPECT_NEAR(scene.specimen.fibre[2], 0.5, 1e-15) << units;
  }
  const auto faults = test::faults_found_by([&] { parse_scene(bare, "scene.toml"); });
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_TRUE(test::says(faults[0], {.line = 5, .key = "specimen.spacing", .expected = "\"2 mm\""}));
  EXPECT_TRUE(test::has(faults[0].expected, "units = \"m\""));
  EXPECT_EQ(faults[1].key, "specimen.fibre.angle");
  for (const char* wrong : {"kPa", "mm, m", "mm deg", "", "mm,", "0"}) {
    const std::string text = fmt::format("units = \"{}\"\n{}spacing = \"2 mm\"\n{}", wrong, head, hold);
    EXPECT_TRUE(test::says_only(test::faults_found_by([&] { parse_scene(text); }), {.key = "units"}));
  }
  const auto digits =
      test::faults_found_by([&] { parse_scene(head + "spacing = \"2\"\n" + hold, "scene.toml"); });
  EXPECT_EQ(digits.size(), 1u) << "quotes are no unit";
}

TEST(ReadSceneContract, OneNumberIsNoVector) {
  const std::string hold = "[[hold]]\nwhere = \"x-\"\n";
  for (const char* more : {"[[move]]\nwhere = \"x+\"\nby = \"1 mm\"\n", "[[load]]\ngravity = 9.81\n",
                           "[[load]]\nwhere = \"x+\"\ntraction = \"1 kPa\"\n"}) {
    const auto faults = test::faults_found_by([&] { parse_scene(scene_with(box, hold + more)); });
    EXPECT_TRUE(test::says_only(faults, {.expected = "one for each axis"})) << more;
  }
  EXPECT_NO_THROW(parse_scene(scene_with(box, hold + "[[move]]\nwhere = \"x+\"\nby = 0\naxes = \"y\"\n")));
  const auto left_out = test::faults_found_by([&] {
    parse_scene(
        scene_with(box, hold + "[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", \"1 mm\", 0]\naxes = \"x\"\n"));
  });
  EXPECT_TRUE(test::says_only(left_out, {.key = "move[1].by", .expected = "0 along y"}));
  const auto empty = test::faults_found_by([&] {
    parse_scene(scene_with(
        box, "[[hold]]\nwhere = { any = [\"x-\", { box = [[\"1 m\", 0, 0], [\"2 m\", 0, 0]] }] }\n"));
  });
  EXPECT_TRUE(test::says_only(empty, {.key = "hold[1].where.any[2]", .expected = "at least one node"}));
}

TEST(ReadSceneContract, LimitsOfFailureNeedMatterWhoseFailureIsKnown) {
  const std::string from = "[[hold]]\nwhere = \"x-\"\n[limits]\nfrom = \"failure\"\n",
                    head = "shape = \"box\"\ncells = [4]\nspacing = \"1 mm\"\nmaterial = ";
  const Scene liver = parse_scene(scene_with(head + "\"liver/parenchyma\"", from));
  EXPECT_EQ(liver.limits.from, LimitSource::failure);
  EXPECT_NEAR(LinkLimits(liver).intervals({0, 0, 0}, 0)->high[0], 0.462e-3,
              1e-15); // PMC6925591: true strain 0.38
  const Scene own = parse_scene(scene_with(
      head + "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, damage = { stretch = 1.5 } }", from));
  EXPECT_NEAR(LinkLimits(own).intervals({0, 0, 0}, 0)->high[0], 0.5e-3, 1e-15);
  // Nothing is known of where fat fails.
  const auto faults =
      test::faults_found_by([&] { parse_scene(scene_with(head + "\"fat/subcutaneous\"", from)); });
  EXPECT_TRUE(test::says_only(
      faults,
      {.line = 9, .key = "limits.from", .expected = "liver/parenchyma", .found = "fat/subcutaneous"}));
}

TEST(ReadSceneContract, ATendonOfTheBellysMaterialIsThatMaterial) {
  const std::string same = "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }";
  const Scene scene =
      parse_scene(scene_with("shape = \"muscle\"\ncells = [10]\nspacing = \"1 mm\"\nmaterial = " + same +
                             "\ntendon = { fraction = 0.2, material = " + same + " }"));
  ASSERT_EQ(scene.materials.size(), 1u);
  for (std::int64_t cell = 0; cell < 10; ++cell)
    EXPECT_EQ(scene.specimen.material(cell), 0) << "no cell may name a material that there is none of";
}

TEST(ReadSceneAnalytic, FibreByAngleLiesInItsPlane) {
  const Scene scene = parse_scene(scene_with(box + "\nfibre = { angle = \"30 deg\", plane = \"xz\" }"));
  EXPECT_NEAR(scene.specimen.fibre[0], std::sqrt(3.0) / 2, 1e-15);
  EXPECT_NEAR(scene.specimen.fibre[2], 0.5, 1e-15);
}

TEST(ReadSceneAnalytic, EllipsoidHasTheVolumeOfAnEllipsoid) {
  const Scene scene = parse_scene(scene_with(R"(shape = "ellipsoid"
cells = [60, 40, 40]
spacing = "1 mm"
material = "muscle/soleus")"));
  const double exact = std::numbers::pi / 6 * 60 * 40 * 40;
  EXPECT_NEAR(static_cast<double>(scene.specimen.n_matter_cells()), exact,
              0.01 * exact); // voxels of 1/40 radius
}

TEST(ReadSceneContract, MuscleHasTendonsAtBothEndsAndPennateFibresBetween) {
  const Scene scene = parse_scene(scene_with(R"(shape = "muscle"
cells = [40, 12, 12]
spacing = "1 mm"
material = "muscle/vastus_lateralis"
tendon = { material = "tendon/tibialis_anterior", fraction = 0.2 }
fibre = { angle = "20 deg", plane = "xz" })"));
  ASSERT_EQ(scene.materials.size(), 2u);
  const Specimen& body = scene.specimen;
  const Index3 size = body.grid.cells();
  const auto middle = body.grid.cell({size[0] / 2, size[1] / 2, size[2] / 2});
  const auto end = body.grid.cell({0, size[1] / 2, size[2] / 2});
  EXPECT_EQ(body.material(middle), 0);
  EXPECT_NEAR(body.fibre_of(middle)[2], std::sin(std::numbers::pi / 9), 1e-7);
  EXPECT_EQ(body.material(end), 1);
  EXPECT_EQ(body.fibre_of(end)[0], 1);
  EXPECT_TRUE(scene.left_out.empty());
}

/// A MetaImage of bytes.
void write_mha(const test::TemporaryFolder& folder, const std::string& name, const Index3& size,
               const std::string& values, const std::string& transform = "1 0 0 0 1 0 0 0 1") {
  folder.write(name, test::meta_image(size, values,
                                      "TransformMatrix = " + transform +
                                          "\nOffset = 10 20 30\nElementSpacing = 2 2 4\n"));
}

TEST(ReadSceneContract, ImageBecomesItsMatterWithItsPlacement) {
  const test::TemporaryFolder folder;
  // Two slices of 4 x 2: label 7 twice, label 9 twice in the second slice.
  write_mha(folder, "labels.mha", {4, 2, 2}, std::string("\0\0\0\0\0\0\0\0\0\7\7\0\0\x9\x9\0", 16));
  const auto file = folder.write("scene.toml", scene_with(R"(shape = "image"
image = "labels.mha"
labels = { 7 = "muscle/soleus", "8..10" = "fat/subcutaneous" }
fibre = [1, 0, 0])"));
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.specimen.grid.cells(), (Index3{2, 2, 1})); // cropped to the matter
  EXPECT_EQ(scene.materials.at(scene.specimen.material(0)).name, "muscle/soleus");
  EXPECT_EQ(scene.materials.at(scene.specimen.material(2)).name, "fat/subcutaneous");
  EXPECT_DOUBLE_EQ(scene.specimen.grid.spacing()[2], 4e-3);
  // Object's frame: origin at the outer corner of voxel 0, half a voxel before its centre.
  EXPECT_NEAR(scene.specimen.origin[0], 2e-3, 1e-12);
  EXPECT_NEAR(scene.specimen.origin[2], 4e-3, 1e-12);
  EXPECT_NEAR(scene.specimen.placement.origin[0], 9e-3, 1e-9);
  EXPECT_NEAR(scene.specimen.placement.origin[2], 28e-3, 1e-9);
}

TEST(ReadSceneContract, LabelsOfCellsAreKeptAndThoseThatNoVoxelHasAreFaults) {
  // Truth: the sixteen bytes below.
  const test::TemporaryFolder folder;
  write_mha(folder, "labels.mha", {4, 2, 2}, std::string("\0\0\0\0\0\0\0\0\0\7\7\0\0\x9\x9\0", 16));
  const auto read = [&](const std::string& labels) {
    return read_scene(folder.write(
        "scene.toml", scene_with("shape = \"image\"\nimage = \"labels.mha\"\nfibre = [1, 0, 0]\n" + labels)));
  };
  const Scene one = read("labels = { \"7..9\" = \"muscle/soleus\" }");
  EXPECT_EQ(one.materials.size(), 1u);
  EXPECT_EQ(one.specimen.label, (std::vector<std::int32_t>{7, 7, 9, 9}));
  EXPECT_EQ(refined(one).specimen.label.size(), 32u);
  EXPECT_TRUE(read("material = \"muscle/soleus\"").specimen.label.empty());
  const Fault fault =
      test::only_fault_of([&] { read("labels = { 7 = \"muscle/soleus\", 99 = \"fat/subcutaneous\" }"); });
  EXPECT_EQ(fault.key, "specimen.labels.99");
  EXPECT_TRUE(test::has(fault.expected, "which has 7, 9"));
}

TEST(ReadSceneContract, BoundsOfRealLabelsMeanTheVoxelsThatAreWrittenSo) {
  // Truth: voxels 3 and 7, scaled by 0.1, are 0.3 and 0.7, which float32 holds a little above and below.
  const test::TemporaryFolder folder;
  folder.write("real.mha", test::meta_image({4, 1, 1}, test::raw_bytes(std::array{0.1F, 0.3F, 0.7F, 1.0F}),
                                            "ElementSpacing = 2 2 4\n", "MET_FLOAT"));
  const auto cells = [&](const std::string& labels) {
    const auto file = folder.write(
        "scene.toml", scene_with("shape = \"image\"\nimage = \"real.mha\"\nfibre = [1, 0, 0]\nlabels = { " +
                                 labels + " }"));
    return read_scene(file).specimen.n_matter_cells();
  };
  EXPECT_EQ(cells("\"0.1..0.3\" = \"muscle/soleus\""), 2);
  EXPECT_EQ(cells("\"0.7..1\" = \"muscle/soleus\""), 2);
  EXPECT_EQ(cells("\"0.1\" = \"muscle/soleus\""), 1);
}

TEST(ReadSceneContract, CoarsenMergesBlocksByMajority) {
  const test::TemporaryFolder folder;
  // One slice pair of 4 x 2: the left 2 x 2 x 2 block holds five voxels of matter, the right one three.
  write_mha(folder, "labels.mha", {4, 2, 2}, std::string("\7\7\7\0\7\0\7\0\7\x9\7\0\0\0\0\0", 16));
  const auto file = folder.write("scene.toml", scene_with(R"(shape = "image"
image = "labels.mha"
coarsen = 2
fibre = [1, 0, 0]
labels = { "7..9" = "muscle/soleus" })"));
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.specimen.n_matter_cells(), 1);
  EXPECT_EQ(scene.materials.at(scene.specimen.material(0)).name, "muscle/soleus");
  EXPECT_DOUBLE_EQ(scene.specimen.grid.spacing()[0], 4e-3);
}

TEST(ReadSceneContract, PiecesThatNothingHoldsAreCountedNamedAndLeftOut) {
  const test::TemporaryFolder folder;
  // A bar along x, a cell that touches it by an edge only, and a far island.
  write_mha(folder, "labels.mha", {5, 2, 2},
            std::string("\7\7\7\0\0"
                        "\0\0\0\7\0"
                        "\0\0\0\0\0"
                        "\7\0\0\0\0",
                        20));
  const auto file = folder.write(
      "scene.toml", scene_with(R"(shape = "image"
image = "labels.mha"
material = "fat/subcutaneous")",
                               "[[hold]]\nwhere = { box = [[0, 0, 0], [0, \"2 mm\", \"4 mm\"]] }\n"));
  const Scene scene = read_scene(file);
  // The island shares only the corner node (0, 1, 1) with the bar, which is held: it stays. The edge-joined
  // cell goes.
  EXPECT_EQ(scene.specimen.n_matter_cells(), 4);
  ASSERT_EQ(scene.left_out.size(), 1u);
  EXPECT_EQ(scene.left_out[0].cells, 1);
  EXPECT_TRUE(test::has(scene.left_out[0].name, "fat/subcutaneous"));
}

TEST(ReadSceneAnalytic, TensorImageGivesItsFirstEigenvector) {
  const test::TemporaryFolder folder;
  write_mha(folder, "labels.mha", {1, 1, 2}, std::string("\7\7", 2));
  // xx yy zz xy xz yz of a tensor whose first eigenvector is (1, 1, 0) / sqrt 2, and of one along z.
  folder.write("tensors.mha",
               test::meta_image({1, 1, 2}, std::string("\2\2\1\1\0\0\1\1\4\0\0\0", 12),
                                "Offset = 10 20 30\nElementSpacing = 2 2 4\nElementNumberOfChannels = 6\n"));
  const auto file = folder.write("scene.toml", scene_with(R"(shape = "image"
image = "labels.mha"
labels = { 7 = "muscle/soleus" }
fibre = { tensor_image = "tensors.mha" })",
                                                          "[[hold]]\nwhere = \"z-\"\n"));
  const Scene scene = read_scene(file);
  EXPECT_NEAR(std::abs(scene.specimen.fibre_of(0)[0] + scene.specimen.fibre_of(0)[1]), std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(std::abs(scene.specimen.fibre_of(1)[2]), 1, 1e-6);
}

TEST(ReadSceneContract, ImagesThatDoNotFitTheirUseAreFaultsOfTheirKeys) {
  const test::TemporaryFolder folder;
  write_mha(folder, "labels.mha", {1, 1, 2}, std::string("\7\7", 2));
  folder.write("colours.mha", test::meta_image({1, 1, 2}, std::string(12, '\1'),
                                               "ElementSpacing = 2 2 4\nElementNumberOfChannels = 6\n"));
  const auto fault_of = [&](const std::string& specimen) {
    const auto file = folder.write("scene.toml", scene_with("shape = \"image\"\n" + specimen));
    return test::only_fault_of([&] { read_scene(file); });
  };
  const std::string labels = "image = \"labels.mha\"\nmaterial = \"fat/subcutaneous\"\n";
  EXPECT_EQ(fault_of("image = \"colours.mha\"\nmaterial = \"fat/subcutaneous\"\n").key, "specimen.image");
  // The tensors have the right size but stand elsewhere: their header has no offset.
  EXPECT_EQ(fault_of(labels + "fibre = { tensor_image = \"colours.mha\" }").key, "specimen.fibre");
  EXPECT_EQ(fault_of(labels + "fibre = { tensor_image = \"none.mha\" }").key, "specimen.fibre");
  EXPECT_EQ(fault_of(labels + "fibre = { tensor_image = \"$MAILLE_NO_SUCH_VARIABLE/t.mha\" }").key,
            "specimen.fibre");
  EXPECT_EQ(fault_of(labels + "fibre = { tensor_image = \"\" }").key, "specimen.fibre.tensor_image");
  EXPECT_EQ(fault_of("image = \"labels.mha\"\nlabels = {}").key, "specimen.labels");
  EXPECT_EQ(fault_of("image = \"labels.mha\"\nlabels = { 8 = \"fat/subcutaneous\" }").key,
            "specimen.labels.8");
}

TEST(ReadSceneAnalytic, FibresOfAnyLengthGiveTheirDirection) {
  for (const char* fibre : {"[1e200, 1e200, 0]", "[1e-200, 1e-200, 0]", "[3, 3, 0]"}) {
    const Scene scene = parse_scene(scene_with(box + "\nfibre = " + fibre));
    EXPECT_NEAR(scene.specimen.fibre[0], std::sqrt(0.5), 1e-15) << fibre;
    EXPECT_NEAR(scene.specimen.fibre[1], std::sqrt(0.5), 1e-15) << fibre;
  }
}

// Truth: by hand: 3 N a millimetre of thickness, over a face of 4 mm.
TEST(ReadSceneContract, ForcesOfTwoDimensionsSayTheirThickness) {
  const auto scene_of = [](const std::string& cells, const std::string& force) {
    return "[specimen]\nshape = \"box\"\ncells = " + cells +
           "\nspacing = \"1 mm\"\nmaterial = \"liver/parenchyma\"\n[[hold]]\nwhere = \"x-\"\n"
           "[[load]]\nwhere = \"x+\"\nforce = [" +
           force + "]\n";
  };
  for (const char* force : {"\"3 N/mm\", 0", "\"3 kN/m\", 0", "\"3 kN\", 0", "\"3000 N\", 0"}) {
    const Scene scene = parse_scene(scene_of("[8, 4]", force));
    ASSERT_EQ(scene.tractions.size(), 4U) << force;
    EXPECT_NEAR(scene.tractions[0].traction[0], 3e3 / 4e-3, 1e-6) << force;
  }
  EXPECT_EQ(test::faults_found_by([&] { parse_scene(scene_of("[8, 4, 4]", "\"3 N/mm\", 0, 0")); }).size(),
            1U);
  EXPECT_EQ(test::faults_found_by([&] { parse_scene(scene_of("[8, 4]", "\"3 g/mm\", 0")); }).size(), 1U);
}

} // namespace
} // namespace maille
