/// What a program asks for in the words of scene files, held against a file.
#include "maille/scene/measure/measure.hpp"

#include "support/label_scene.hpp"
#include "support/mistake.hpp"
#include "support/same_scene.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::LabelArray;

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
TEST(SceneBuilderMeasuresOracle, AreThoseOfAFile) {
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
TEST(SceneBuilderMeasuresOracle, RegionsInWordsAreThoseOfAFile) {
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
    EXPECT_NE(all.find(part), std::string::npos) << part << "\n" << all;
}

SceneBuilder block() {
  return SceneBuilder().box(3, {4, 2, 2}, {1e-3, 1e-3, 1e-3}).hold("x-");
}

TEST(SceneBuilderOracle, WordsAreThoseOfFiles) {
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
