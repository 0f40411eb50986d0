// The way in for programs. Truth: the reader of files (Oracle: the same question as text), what the message
// promises (Contract), geometry (Analytic).

#include "maille/scene/measure/measure.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"
#include "support/same_scene.hpp"

namespace maille {
namespace {

using test::expect_same_scene;
using test::LabelArray;
using test::Orientation;

Material soft() {
  Material material;
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  return material;
}

/// A box of 4 x 2 x 2 cells of 1 mm, held at one end and drawn at the other.
SceneBuilder pulled() {
  return SceneBuilder()
      .box(3, {4, 2, 2}, {1e-3, 1e-3, 1e-3})
      .material(soft())
      .hold("x-")
      .move("x+", {1e-4, 0, 0});
}

TEST(SceneBuilderConsistent, ABoxIsTheSceneThatItsTextIs) {
  const Scene by_text = parse_scene(R"(title = "everything"
units = "m"
[specimen]
shape = "box"
cells = [4, 3, 2]
spacing = [0.001, 0.002, 0.003]
fibre = [1, 2, -2]
[specimen.material]
name = "own"
youngs_modulus = 10000
poisson_ratio = 0.3
density = 1100
stretch = 1.5
compress = 0.5
shear = 0.25
relaxed_weights = [1, 2, 3]
damage = { stretch = 1.4 }
[[hold]]
where = "x-"
[[hold]]
where = "y-"
axes = "y"
[[move]]
where = { box = [[0.004, 0.006, 0.003], [0.004, 0.002, 0]] }
by = [0.0003, 0, 0.0001]
axes = "xz"
[[load]]
where = "z+"
traction = [100, 0, -50]
[[load]]
gravity = [0, 0, -9.81]
[[load]]
gravity = [1, 0, 0]
[[load]]
contraction = 300
where = { box = [[0, 0, 0], [0.002, 0.006, 0.006]] }
[limits]
from = "given"
stretch = [1.3, 1.1, 1.2]
compress = 0.5
shear = 0.3
cut = "allowed"
[relaxation]
mode = "deformable"
frame = "blocks"
increments = 3
tolerance = 0.001
sweeps = 77
extrapolation = "nested"
)");
  Material own = soft();
  own.name = "own";
  own.density = 1100;
  own.limits = NeighbourLimits{
      {1.5, 1.5, 1.5}, {0.5, 0.5, 0.5}, {{{0, 0.25, 0.25}, {0.25, 0, 0.25}, {0.25, 0.25, 0}}}};
  own.relaxed_weights = {1, 2, 3};
  own.damage = Damage{{1.4, 1.4, 1.4}, {}, {}, "", "", false};
  LimitSettings limits;
  limits.from = LimitSource::given;
  limits.given = {{1.3, 1.1, 1.2}, {0.5, 0.5, 0.5}, {{{0, 0.3, 0.3}, {0.3, 0, 0.3}, {0.3, 0.3, 0}}}};
  limits.cut_is_allowed = true;
  const RelaxationSettings relaxation{RelaxationMode::deformable, 3, 0.001, 77, Extrapolation::nested};
  const Scene built = SceneBuilder()
                          .title("everything")
                          .box(3, {4, 3, 2}, {1e-3, 2e-3, 3e-3})
                          .material(own)
                          .fibre({1, 2, -2})
                          .hold("x-")
                          .hold("y-", "y")
                          .move(BoxRegion{{4e-3, 6e-3, 3e-3}, {4e-3, 2e-3, 0}}, {3e-4, 0, 1e-4}, "xz")
                          .traction("z+", {100, 0, -50})
                          .gravity({0, 0, -9.81})
                          .gravity({1, 0, 0})
                          .contraction(300, BoxRegion{{0, 0, 0}, {2e-3, 6e-3, 6e-3}})
                          .limits(limits)
                          .relaxation(relaxation)
                          .strain(Strain::finite)
                          .build();
  expect_same_scene(built, by_text);
  EXPECT_FALSE(built.tractions.empty());
  EXPECT_GT(built.active_stress.size(), 0u);
}

TEST(SceneBuilderConsistent, BoxesOfOneAndTwoDimensionsAreTheScenesOfTheirTexts) {
  const std::string material = "material = \"muscle/soleus\"\n", hold = "[[hold]]\nwhere = \"x-\"\n";
  expect_same_scene(SceneBuilder()
                        .box(1, {7, 1, 1}, {0.5, 0.5, 0.5})
                        .material("muscle/soleus")
                        .hold("x-")
                        .move("x+", {0.25, 0, 0})
                        .build(),
                    parse_scene("units = \"m\"\n[specimen]\nshape = \"box\"\ncells = 7\nspacing = 0.5\n" +
                                material + hold + "[[move]]\nwhere = \"x+\"\nby = 0.25\n"));
  expect_same_scene(SceneBuilder()
                        .box(2, {7, 3, 1}, {0.5, 0.25, 0.125})
                        .material("muscle/soleus")
                        .plane(PlaneAssumption::stress)
                        .hold("x-")
                        .move("x+", {0, 0.25, 0}, "y")
                        .build(),
                    parse_scene("units = \"m\"\n[specimen]\nshape = \"box\"\ncells = [7, 3]\nplane = "
                                "\"stress\"\nspacing = [0.5, 0.25, 0.125]\n" +
                                material + hold +
                                "[[move]]\nwhere = \"x+\"\nby = [0, 0.25]\naxes = \"y\"\n"));
}

TEST(SceneBuilderConsistent, ALabelArrayOfAnyOrientationIsTheSceneOfItsImage) {
  const image_tests::TemporaryFolder folder;
  for (const Orientation& to : test::all_orientations()) {
    const LabelArray array = turned(test::bent_body(), to);
    SCOPED_TRACE(testing::Message() << "axes " << to.axis[0] << to.axis[1] << to.axis[2] << ", flipped "
                                    << to.flipped[0] << to.flipped[1] << to.flipped[2]);
    const Scene by_file = test::label_scene_by_file(folder, array);
    const std::vector<std::uint8_t> labels(array.values.begin(), array.values.end());
    expect_same_scene(
        test::label_scene().labels(labels, ArrayLayout::x_fastest(array.size), array.affine).build(),
        by_file);
    EXPECT_FALSE(by_file.specimen.placement.is_identity());
    EXPECT_EQ(by_file.specimen.label.size(), 27u);
  }
}

template<class Label>
void expect_any_order(const LabelArray& array) {
  const std::vector<Label> labels(array.values.begin(), array.values.end());
  const Scene plain =
      test::label_scene().labels(labels, ArrayLayout::x_fastest(array.size), array.affine).build();
  for (const Orientation& order : test::all_orientations()) {
    const auto memory = test::stored<Label>(array, order);
    expect_same_scene(test::label_scene().labels(memory.elements, memory.layout, array.affine).build(),
                      plain);
  }
}

TEST(SceneBuilderContract, OrderInMemoryStridesAndTypesChangeNothing) {
  const LabelArray array = test::bent_body();
  expect_any_order<std::uint8_t>(array);
  expect_any_order<std::uint16_t>(array);
  expect_any_order<std::int16_t>(array);
  expect_any_order<std::int32_t>(array);
  expect_any_order<std::int64_t>(array);
}

TEST(SceneBuilderContract, TheLayoutsWithNamesAreTheOrdersOfTheirLanguages) {
  // Truth: C++ itself lays out array[x][y][z] with z fastest, and array[z][y][x] with x fastest.
  std::int32_t by_x[2][3][4], by_z[4][3][2];
  for (const auto& [z, y, x] : test::all_below({4, 3, 2}))
    by_x[x][y][z] = by_z[z][y][x] = 100 * x + 10 * y + z;
  for (const auto& [z, y, x] : test::all_below({4, 3, 2})) {
    EXPECT_EQ((&by_x[0][0][0])[ArrayLayout::z_fastest({2, 3, 4}).element({x, y, z})], 100 * x + 10 * y + z);
    EXPECT_EQ((&by_z[0][0][0])[ArrayLayout::x_fastest({2, 3, 4}).element({x, y, z})], 100 * x + 10 * y + z);
  }
}

TEST(SceneBuilderAnalytic, MatterLiesWhereTheAffinePutsIt) {
  // Truth: the affine times the indices of the body's voxels. 1e-7 m: affines are of float32 numbers.
  const LabelArray body = test::bent_body();
  for (const Orientation& to : test::all_orientations()) {
    const LabelArray array = turned(body, to);
    const Scene scene = test::label_scene()
                            .labels(std::vector<std::int32_t>(array.values.begin(), array.values.end()),
                                    ArrayLayout::x_fastest(array.size), array.affine)
                            .build();
    const Specimen& found = scene.specimen;
    int matched = 0;
    for (int v = 0; v < 60; ++v) {
      const Index3 at{v % 5, v / 5 % 4, v / 20};
      for (std::int64_t cell = 0; body.at(at) != 0 && cell < found.grid.n_cells(); ++cell) {
        const Vec3 corner = found.position(found.grid.cell_at(cell));
        double distance = 0;
        for (std::size_t r = 0; r < 3; ++r) {
          double x = found.placement.origin[r], wanted = body.affine[r][3];
          for (std::size_t a = 0; a < 3; ++a) {
            x += found.placement.direction[r][a] * (corner[a] + found.grid.spacing()[a] / 2);
            wanted += body.affine[r][a] * at[a];
          }
          distance = std::max(distance, std::abs(x - wanted));
        }
        if (distance < 1e-7) {
          ++matched;
          EXPECT_EQ(found.label[static_cast<std::size_t>(cell)], body.at(at));
        }
      }
    }
    EXPECT_EQ(matched, 19); // 3 x 2 x 3 and one more
    EXPECT_EQ(found.n_matter_cells(), 19);
  }
}

TEST(SceneBuilderConsistent, OneMaterialForAllThatIsNotZeroIsTheSceneOfItsImage) {
  const image_tests::TemporaryFolder folder;
  const LabelArray array = test::bent_body();
  folder.write("labels.nii", test::nifti_of(array));
  const Scene by_file = read_scene(
      folder.write("scene.toml", "[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nmaterial "
                                 "= \"muscle/soleus\"\nfibre = [1, 0, 0]\n[[hold]]\nwhere = \"z-\"\n"));
  const std::vector<std::int16_t> labels(array.values.begin(), array.values.end());
  expect_same_scene(SceneBuilder()
                        .labels(labels, ArrayLayout::x_fastest(array.size), array.affine)
                        .material("muscle/soleus")
                        .hold("z-")
                        .build(),
                    by_file);
}

TEST(SceneBuilderContract, OneSliceIsATwoDimensionalSceneAndEqualMaterialsAreOne) {
  const std::vector<std::uint8_t> labels{0, 1, 2, 1, 2, 3};
  const Scene scene = SceneBuilder()
                          .labels(labels, ArrayLayout::x_fastest({3, 2, 1}), affine_of({1e-3, 1e-3, 1e-3}))
                          .material(1, soft())
                          .material(2, "muscle/soleus")
                          .material(3, soft())
                          .hold("x-")
                          .build();
  EXPECT_EQ(scene.dimension(), 2);
  // Two objects without a name are called by their labels, so they differ; the same with a name are one.
  EXPECT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].name, "specimen.labels.1");
  Material named = soft();
  named.name = "soft";
  const Scene two = SceneBuilder()
                        .labels(labels, ArrayLayout::x_fastest({3, 2, 1}), affine_of({1e-3, 1e-3, 1e-3}))
                        .material(1, named)
                        .material(2, "muscle/soleus")
                        .material(3, named)
                        .hold("x-")
                        .build();
  EXPECT_EQ(two.materials.size(), 2u);
  EXPECT_EQ(two.specimen.material_id, (std::vector<std::uint8_t>{no_material, 0, 1, 0, 1, 0}));
  Material lawful = named;
  lawful.law = NeoHookean{1e3, 1e3};
  EXPECT_EQ(SceneBuilder()
                .labels(labels, ArrayLayout::x_fastest({3, 2, 1}), affine_of({1e-3, 1e-3, 1e-3}))
                .material(1, named)
                .material(2, lawful)
                .material(3, named)
                .hold("x-")
                .build()
                .materials.size(),
            2u)
      << "a law makes a difference";
}

TEST(SceneBuilderContract, ListsOfNodesSelectWhatTheyNameInAnyOrderAndOnce) {
  // Truth: the faces that the lists are of.
  const Scene by_faces = pulled().force("x+", {1, 0, 0}).build();
  const Grid grid = pulled().grid();
  NodeList low, high;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (const int i = grid.node_at(node)[0]; i == 0 || i == 4)
      (i == 0 ? low : high).nodes.insert((i == 0 ? low : high).nodes.end(), {node, node});
  std::mt19937 dice(1);
  std::ranges::shuffle(low.nodes, dice);
  std::ranges::shuffle(high.nodes, dice);
  const Scene by_lists = SceneBuilder()
                             .box(3, {4, 2, 2}, {1e-3, 1e-3, 1e-3})
                             .material(soft())
                             .hold(low)
                             .move(high, {1e-4, 0, 0})
                             .force(high, {1, 0, 0})
                             .build();
  expect_same_scene(by_lists, by_faces);
  EXPECT_EQ(by_lists.tractions.size(), 4u);
  for (std::size_t i = 1; i < by_lists.prescribed.size(); ++i) {
    const Prescribed &p = by_lists.prescribed[i - 1], &q = by_lists.prescribed[i];
    EXPECT_TRUE(std::pair(p.component, p.node) < std::pair(q.component, q.node)) << i;
  }
}

TEST(SceneBuilderContract, NodesOfAnArrayAreThoseOfTheWholeArray) {
  const LabelArray array = test::bent_body();
  const std::vector<std::uint8_t> labels(array.values.begin(), array.values.end());
  SceneBuilder builder = SceneBuilder()
                             .labels(labels, ArrayLayout::x_fastest(array.size), array.affine)
                             .material("muscle/soleus");
  const Grid grid = builder.grid();
  EXPECT_EQ(grid.cells(), (Index3{5, 4, 3}));
  const Scene scene = builder.hold(NodeList{{grid.node({1, 0, 0}), grid.node({4, 2, 3})}}).build();
  EXPECT_EQ(first_cell(scene.specimen), (Index3{1, 0, 0}));
  ASSERT_EQ(scene.prescribed.size(), 6u);
  EXPECT_EQ(scene.specimen.grid.node_at(scene.prescribed[0].node), (Index3{0, 0, 0}));
  EXPECT_EQ(scene.specimen.grid.node_at(scene.prescribed[1].node), (Index3{3, 2, 3}));
}

TEST(SceneBuilderContract, PiecesThatNothingHoldsAreLeftOutWithTheirNodes) {
  const std::vector<std::uint8_t> labels{1, 1, 0, 1};
  const SceneBuilder builder =
      SceneBuilder()
          .labels(labels, ArrayLayout::x_fastest({4, 1, 1}), affine_of({1e-3, 1e-3, 1e-3}))
          .material(1, soft())
          .hold("x-")
          .move(NodeList{{2, 3, 4}}, {1e-4, 0, 0})
          .traction(NodeList{{2, 7, 3, 8, 4, 9}}, {1, 0, 0});
  const Scene scene = builder.build();
  ASSERT_EQ(scene.left_out.size(), 1u);
  EXPECT_EQ(scene.left_out[0].cells, 1);
  EXPECT_EQ(std::ranges::count_if(scene.prescribed, [](const Prescribed& p) { return !p.held; }), 2);
  EXPECT_EQ(scene.tractions.size(), 1u);
}

TEST(SceneBuilderAnalytic, AForceIsSpreadOverTheAreaOfItsFaces) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    const Index3 cells{4, dimension > 1 ? 3 : 1, dimension > 2 ? 2 : 1};
    const Scene scene = SceneBuilder()
                            .box(dimension, cells, {1e-3, 2e-3, 3e-3})
                            .material(soft())
                            .hold("x-")
                            .force("x+", {6, 0, 0})
                            .build();
    const double face = dimension == 1 ? 1 : dimension == 2 ? 2e-3 : 2e-3 * 3e-3;
    double total = 0;
    for (const FaceLoad& load : scene.tractions)
      total += load.traction[0] * face;
    EXPECT_NEAR(total, 6, 1e-12) << dimension;
    EXPECT_EQ(scene.tractions.size(), static_cast<std::size_t>(cells[1] * cells[2]));
  }
}

TEST(SceneBuilderAnalytic, FibresOfCellsHaveLengthOneAndGoWithTheirCells) {
  const LabelArray array = test::bent_body();
  std::vector<std::array<float, 3>> fibres;
  for (int v = 0; v < 60; ++v) // along x, y or z by the voxel's column; none where there is no matter
    fibres.push_back(array.values[static_cast<std::size_t>(v)] == 0 ? std::array<float, 3>{NAN, 0, 0}
                     : v % 5 == 1                                   ? std::array<float, 3>{7, 0, 0}
                     : v % 5 == 2                                   ? std::array<float, 3>{0, -1e30F, 0}
                                                                    : std::array<float, 3>{0, 3, 4});
  const std::vector<std::uint8_t> labels(array.values.begin(), array.values.end());
  const Scene scene = SceneBuilder()
                          .labels(labels, ArrayLayout::x_fastest(array.size), array.affine)
                          .material("muscle/soleus")
                          .fibres(fibres, ArrayLayout::x_fastest(array.size))
                          .hold("x-")
                          .build();
  const Specimen& body = scene.specimen;
  ASSERT_EQ(body.fibres.size(), 27u);
  for (std::int64_t cell = 0; cell < 27; ++cell) {
    const std::array<std::array<float, 3>, 3> wanted{{{1, 0, 0}, {0, -1, 0}, {0, 0.6F, 0.8F}}};
    if (body.is_matter(cell)) {
      EXPECT_EQ(body.fibres[static_cast<std::size_t>(cell)], wanted[static_cast<std::size_t>(cell % 3)]);
    }
  }
  EXPECT_EQ(body.fibre_report.cells, 19);
}

TEST(SceneBuilderContract, ABuilderIsBuiltAgainAndCopied) {
  const SceneBuilder builder = pulled();
  expect_same_scene(builder.build(), builder.build());
  SceneBuilder further = builder;
  further.move(BoxRegion{{2e-3, 0, 0}, {2e-3, 0, 0}}, {0, 1e-4, 0}, "y");
  EXPECT_GT(further.build().prescribed.size(), builder.build().prescribed.size());
  const auto tried = builder.try_build();
  ASSERT_TRUE(std::holds_alternative<Scene>(tried));
  expect_same_scene(std::get<Scene>(tried), builder.build());
}

/// What a program asks for in the words of scene files, held against a file.

SceneBuilder built(const LabelArray& array) {
  const std::vector<std::uint8_t> labels(array.values.begin(), array.values.end());
  return test::label_scene().labels(labels, ArrayLayout::x_fastest(array.size), array.affine);
}

const std::vector<std::pair<std::string, std::string>> asked{
    {"pull", "force = \"move[1]\"\ncomponent = \"x\""},
    {"cut", "force = { section = { point = [0.005, 0, 0], normal = [1, 0, 0] } }\ncomponent = \"normal\""},
    {"held", "force = { where = \"x-\" }"},
    {"stretch", "strain = { mean = { label = 17 } }"},
    {"middle", "displacement = { at = [0.005, 0.001, 0.006] }"},
    {"fibre", "length = [[0.003, 0.001, 0.006], [0.007, 0.001, 0.006]]\nkind = \"relative\""},
    {"size", "volume = { material = \"firm\" }"}};

// Truth: the same measures in a file, whose reader is tested for itself.
TEST(SceneBuilderMeasuresConsistent, AreThoseOfAFile) {
  const image_tests::TemporaryFolder folder;
  for (const test::Orientation& to : {test::all_orientations()[0], test::all_orientations()[29]}) {
    LabelArray array = turned(test::bent_body(), to);
    std::string text = test::label_scene_text;
    SceneBuilder builder = built(array);
    for (const auto& [name, keys] : asked) {
      // Places lie in the first orientation's matter alone.
      const bool has_place = keys.find("0.00") != std::string::npos;
      if (has_place && to.axis != std::array<std::size_t, 3>{0, 1, 2})
        continue;
      text += "[[measure]]\nname = \"" + name + "\"\n" + keys + "\n";
      builder.measure(name, keys);
    }
    folder.write("labels.nii", test::nifti_of(array));
    const SceneAndMeasures by_file = read_scene_and_measures(folder.write("scene.toml", text));
    const SceneAndMeasures by_program = builder.build_with_measures();
    test::expect_same_scene(by_program.scene, by_file.scene);
    ASSERT_EQ(by_program.measures.size(), by_file.measures.size());
    ASSERT_GE(by_file.measures.size(), 4u);
    for (std::size_t i = 0; i < by_file.measures.size(); ++i) {
      const Measure &a = by_program.measures[i], &b = by_file.measures[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(in_words(a), in_words(b));
      EXPECT_EQ(a.kind, b.kind);
      EXPECT_EQ(a.figure, b.figure);
      EXPECT_EQ(a.direction, b.direction);
      EXPECT_EQ(a.condition, b.condition);
      EXPECT_EQ(a.nodes, b.nodes);
      EXPECT_EQ(a.cells, b.cells);
      EXPECT_EQ(a.section.has_value(), b.section.has_value());
      ASSERT_EQ(a.points.size(), b.points.size());
      for (std::size_t p = 0; p < a.points.size(); ++p) {
        EXPECT_EQ(a.points[p].place, b.points[p].place);
        EXPECT_EQ(a.points[p].cells, b.points[p].cells);
      }
    }
  }
}

// Truth: the same regions in a file.
TEST(SceneBuilderMeasuresConsistent, RegionsInWordsAreThoseOfAFile) {
  const image_tests::TemporaryFolder folder;
  const LabelArray array = test::bent_body();
  folder.write("labels.nii", test::nifti_of(array));
  for (const std::string where : {"{ label = 17 }", "{ label = 17, touching = 5 }",
                                  "{ sphere = { centre = [0.006, 0.003, 0.01], radius = 0.004 } }",
                                  "{ all = [{ label = 5 }, { not = \"z+\" }] }"}) {
    std::string text = test::label_scene_text;
    text.replace(text.find("\"x-\""), std::string::npos, where);
    const Scene by_file = read_scene(folder.write("scene.toml", text));
    const std::vector<std::uint8_t> labels(array.values.begin(), array.values.end());
    Material firm;
    firm.name = "firm";
    firm.elasticity = ElasticConstants::isotropic(30e3, 0.4);
    const Scene by_program = SceneBuilder()
                                 .material(17, "muscle/soleus")
                                 .material(5, firm)
                                 .fibre({0, 3, 4})
                                 .labels(labels, ArrayLayout::x_fastest(array.size), array.affine)
                                 .hold(where)
                                 .build();
    ASSERT_EQ(by_program.prescribed.size(), by_file.prescribed.size()) << where;
    for (std::size_t i = 0; i < by_file.prescribed.size(); ++i) {
      EXPECT_EQ(by_program.prescribed[i].node, by_file.prescribed[i].node);
      EXPECT_EQ(by_program.prescribed[i].value, by_file.prescribed[i].value);
    }
  }
}

TEST(SceneBuilderMeasuresContract, TellsEveryFaultAtOnce) {
  const auto faults = test::faults_found_by([] {
    built(test::bent_body())
        .hold("{ label = 18 }")
        .hold("superior")
        .measure("pull", "force = \"move[2]\"")
        .measure("pull", "volume = { label = 99 }")
        .measure("odd", "force = ")
        .measure("named", "name = \"twice\"\nenergy = \"body\"")
        .build_with_measures();
  });
  std::string all;
  for (const Fault& fault : faults) {
    EXPECT_EQ(fault.line, 0);
    EXPECT_EQ(fault.file, "");
    all += to_string(fault) + "\n";
  }
  for (const char* part : {"hold[2].where.label: expected a label of the body: 5, 17",
                           "hold[3].where: expected an image that says where a patient's",
                           "measure[1].force: expected \"hold[N]\" or \"move[N]\" of 3 holds and 1 moves",
                           "measure[2].volume.label", "measure[3]: expected keys of a [[measure]] in TOML",
                           "measure[4].name: expected a name as the first argument alone"})
    EXPECT_TRUE(test::has(all, part));
}

SceneBuilder block() {
  return SceneBuilder().box(3, {4, 2, 2}, {1e-3, 1e-3, 1e-3}).hold("x-");
}

TEST(SceneBuilderConsistent, WordsAreThoseOfFiles) {
  // Truth: the reader of files, asked the same with the same slips.
  const std::string head = "units = \"m\"\n[specimen]\nshape = \"box\"\ncells = [4, 2, 2]\nspacing = 0.001\n";
  const auto by_file = test::faults_found_by([&] {
    parse_scene(head +
                "material = \"muscle/soleuss\"\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x-\"\nby = [1, "
                "0, 0]\n[[move]]\nwhere = \"y+\"\nby = [0, 1, 0]\naxes = \"yy\"\n");
  });
  const auto built = test::faults_found_by([&] {
    block().material("muscle/soleuss").move("x-", {1, 0, 0}).move("y+", {0, 1, 0}, "yy").build();
  });
  ASSERT_EQ(by_file.size(), 2u); // without a body nothing is placed, so nothing contradicts
  ASSERT_EQ(built.size(), by_file.size());
  for (std::size_t i = 0; i < built.size(); ++i) {
    EXPECT_EQ(built[i].key, by_file[i].key);
    EXPECT_EQ(built[i].expected, by_file[i].expected);
    EXPECT_EQ(built[i].found, by_file[i].found);
  }
  const auto contradiction = test::only_fault_of([&] {
    parse_scene(
        head +
        "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x-\"\nby = [1, 0, "
        "0]\naxes = \"x\"\n");
  });
  const auto same = test::only_fault_of([&] {
    block().material("muscle/soleus").move("x-", {1, 0, 0}, "x").build();
  });
  EXPECT_EQ(same.key, contradiction.key);
  EXPECT_EQ(same.expected, contradiction.expected);
  EXPECT_EQ(same.found, contradiction.found);
}

} // namespace
} // namespace maille
