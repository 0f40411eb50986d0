// What SceneBuilder refuses. Truth (Contract): the rules of scene files, and the key that a file would have.

#include "maille/scene/scene_builder.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();

Material soft() {
  Material material;
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  return material;
}

SceneBuilder box() {
  return SceneBuilder().box(3, {4, 2, 2}, {1e-3, 1e-3, 1e-3}).hold("x-");
}

SceneBuilder good_box() {
  return box().material(soft()).move("x+", {1e-4, 0, 0});
}

const std::vector<std::uint8_t> voxels{0, 1, 1, 2, 2, 0, 1, 1};

SceneBuilder image() {
  return SceneBuilder()
      .labels(voxels, ArrayLayout::x_fastest({2, 2, 2}), affine_of({1e-3, 1e-3, 1e-3}))
      .hold("x-");
}

SceneBuilder good_image() {
  return image().material(1, soft()).material(2, "muscle/soleus");
}

Affine with_number(std::size_t row, std::size_t column, double number) {
  Affine affine = affine_of({1e-3, 1e-3, 1e-3});
  affine[row][column] = number;
  return affine;
}

SceneBuilder placed(const Affine& affine) {
  return good_image().labels(voxels, ArrayLayout::x_fastest({2, 2, 2}), affine);
}

SceneBuilder laid_out(const ArrayLayout& layout) {
  return good_image().labels(voxels, layout, affine_of({1e-3, 1e-3, 1e-3}));
}

SceneBuilder of_matter(const std::function<void(Material&)>& change) {
  Material material = soft();
  change(material);
  return box().material(material);
}

SceneBuilder limited(const std::function<void(LimitSettings&)>& change) {
  LimitSettings limits;
  limits.from = LimitSource::given;
  change(limits);
  return good_box().limits(limits);
}

SceneBuilder relaxed(const std::function<void(RelaxationSettings&)>& change) {
  RelaxationSettings relaxation;
  change(relaxation);
  return good_box().relaxation(relaxation);
}

struct Slip {
  const char* name;
  SceneBuilder builder;
  const char* key;
  const char* text; ///< somewhere in the message
};

TEST(SlipContract, IsTheOneFault) {
  const std::vector<Slip> slips{
      // Body
      {"nothing", SceneBuilder().hold("x-"), "specimen", "a box, or an array"},
      {"four_dimensions", good_box().box(4, {4, 2, 2}, {1, 1, 1}), "specimen.dimension", "1, 2 or 3"},
      {"no_cells", good_box().box(3, {4, 0, 2}, {1, 1, 1}), "specimen.cells", "along y"},
      {"cells_beyond", box().material(soft()).box(2, {4, 2, 2}, {1, 1, 1}), "specimen.cells", "2 dimensions"},
      {"negative_spacing", good_box().box(3, {4, 2, 2}, {1, -1, 1}), "specimen.spacing", "along y"},
      {"spacing_nan", good_box().box(3, {4, 2, 2}, {1, 1, not_a_number}), "specimen.spacing", "nan"},
      {"spacing_inf", good_box().box(3, {4, 2, 2}, {infinity, 1, 1}), "specimen.spacing", "inf"},
      {"beyond_memory", good_box().box(3, {900000, 900000, 900000}, {1, 1, 1}), "specimen.cells", "MiB"},
      {"no_matter", box(), "specimen.material", "nothing"},
      {"two_of_a_box", box().material(soft()).material(soft()), "specimen.material", "2 of them"},
      {"label_of_a_box", box().material(soft()).material(3, soft()), "specimen.labels.3", "no label"},
      {"plane_in_3d", good_box().plane(PlaneAssumption::stress), "specimen.plane", "two-dimensional"},
      {"fibre_zero", good_box().fibre({0, 0, 0}), "specimen.fibre", "not zero"},
      {"fibre_nan", good_box().fibre({1, not_a_number, 0}), "specimen.fibre", "finite"},
      {"fibres_few",
       good_box().fibres(std::vector<std::array<float, 3>>(8), ArrayLayout::x_fastest({2, 2, 2})),
       "specimen.fibre", "4 x 2 x 2"},
      {"fibres_out_of_the_array",
       good_box().fibres(std::vector<std::array<float, 3>>(8), ArrayLayout::x_fastest({4, 2, 2})),
       "specimen.fibre", "8 elements"},
      {"fibres_zero",
       good_box().fibres(std::vector<std::array<float, 3>>(16), ArrayLayout::x_fastest({4, 2, 2})),
       "specimen.fibre", "none in 16 cells, the first (0, 0, 0)"},
      // Labels
      {"array_too_short", laid_out(ArrayLayout::x_fastest({2, 2, 3})), "specimen.layout", "8 elements"},
      {"one_past_the_end", laid_out({{2, 2, 2}, {1, 2, 4}, 1}), "specimen.layout", "from element 1 on"},
      {"before_the_array", laid_out({{2, 2, 2}, {-1, 2, 4}, 0}), "specimen.layout", "strides -1"},
      {"huge_stride", laid_out({{2, 2, 2}, {1, INT64_MAX, INT64_MAX}, 0}), "specimen.layout", "strides"},
      {"no_voxels", laid_out({{2, 0, 2}, {1, 2, 4}, 0}), "specimen.layout", "2 x 0 x 2"},
      {"affine_nan", placed(with_number(1, 3, not_a_number)), "specimen.affine", "nan"},
      {"affine_last_row", placed(with_number(3, 0, 1)), "specimen.affine", "0 0 0 1"},
      {"affine_sheared", placed(with_number(0, 1, 5e-4)), "specimen.affine", "perpendicular"},
      {"no_materials", image(), "specimen.labels", "neither"},
      {"both_kinds", good_image().material(soft()), "specimen.labels", "both"},
      {"two_for_all", image().material(soft()).material("muscle/soleus"), "specimen.labels", "more than one"},
      {"label_without_voxels", good_image().material(99, soft()), "specimen.labels.99", "which has 1, 2"},
      {"label_twice", good_image().material(2, soft()), "specimen.labels", "overlap"},
      {"label_too_large",
       good_image().labels(std::vector<std::int32_t>{1, 2, 16777217}, ArrayLayout::x_fastest({3, 1, 1}),
                           affine_of({1e-3, 1e-3, 1e-3})),
       "specimen.labels", "16777217"},
      {"label_asked_too_large", good_image().material(16777217, soft()), "specimen.labels", "16777216"},
      {"fewer_elements_than_voxels", laid_out({{3, 3, 3}, {0, 0, 0}, 0}), "specimen.layout", "8 elements"},
      {"nothing_but_zero",
       image().material(soft()).labels(std::vector<std::uint8_t>(8), ArrayLayout::x_fastest({2, 2, 2}),
                                       affine_of({1e-3, 1e-3, 1e-3})),
       "specimen.labels", "no voxel"},
      // Matter
      {"unknown_name", box().material("muscle/soleuss"), "specimen.material", "muscle/soleus"},
      {"no_modulus", of_matter([](Material& m) { m.elasticity.youngs_modulus[1] = 0; }),
       "specimen.material.E", "E2 > 0"},
      {"modulus_nan", of_matter([](Material& m) { m.elasticity.G13 = not_a_number; }), "specimen.material.G",
       "G13"},
      {"incompressible", of_matter([](Material& m) { m.elasticity = ElasticConstants::isotropic(1e4, 0.5); }),
       "specimen.material.nu", "infinite"},
      {"density_zero", of_matter([](Material& m) { m.density = 0; }), "specimen.material.density", "> 0"},
      {"density_inf", of_matter([](Material& m) { m.density = infinity; }), "specimen.material.density",
       "inf"},
      {"weight", of_matter([](Material& m) { m.relaxed_weights[2] = -1; }),
       "specimen.material.relaxed_weights", "factor"},
      {"stretch_below_1", of_matter([](Material& m) {
         m.limits = NeighbourLimits{{1, 0.9, 1}, {1, 1, 1}, {}};
       }),
       "specimen.material.stretch", "0.9"},
      {"damage", of_matter([](Material& m) {
         m.damage = Damage{{1.4, 1, 1.4}, {}, {}, "", "", false};
       }),
       "specimen.material.damage.stretch", "> 1"},
      // Conditions
      {"loose", SceneBuilder().box(3, {4, 2, 2}, {1, 1, 1}).material(soft()), "hold", "keeps the body"},
      {"unknown_face", good_box().hold("w-"), "hold[2].where", "x-"},
      {"face_beyond", SceneBuilder().box(1, {4, 1, 1}, {1, 1, 1}).material(soft()).hold("y-"),
       "hold[1].where", "x-"},
      {"empty_box", good_box().move(BoxRegion{{1, 1, 1}, {2, 2, 2}}, {}), "move[2].where",
       "at least one node"},
      {"box_nan", good_box().move(BoxRegion{{1, not_a_number, 1}, {2, 2, 2}}, {}), "move[2].where", "finite"},
      {"empty_list", good_box().hold(NodeList{}), "hold[2].where", "a list of 0 nodes"},
      {"node_too_large", good_box().hold(NodeList{{0, 45, 46}}), "hold[2].where", "2 others, the first 45"},
      {"node_negative", good_box().hold(NodeList{{-1, 0}}), "hold[2].where", "1 other, the first -1"},
      {"node_without_matter", good_image().hold(NodeList{{0, 1, 3}}), "hold[2].where", "the first 0"},
      {"axes_unknown", good_box().hold("x-", "xw"), "hold[2].axes", "xyz"},
      {"axes_twice", good_box().hold("x-", "xx"), "hold[2].axes", "each once"},
      {"axes_none", good_box().hold("x-", ""), "hold[2].axes", "at least one"},
      {"by_nan", good_box().move("y+", {0, not_a_number, 0}), "move[2].by", "finite"},
      {"by_beyond",
       SceneBuilder().box(2, {4, 2, 1}, {1, 1, 1}).material(soft()).hold("x-").move("x+", {0, 0, 1}),
       "move[1].by", "0 along z: the scene has 2 dimensions"},
      {"held_and_moved", good_box().move("x-", {1e-4, 0, 0}, "x"), "move[2]", "held or moved, not both"},
      {"moved_to_two_places", good_box().move("x+", {2e-4, 0, 0}, "x"), "move[2]", "agree"},
      {"traction_nan", good_box().traction("y+", {0, infinity, 0}), "load[1].traction", "finite"},
      {"traction_inside", good_box().traction(NodeList{{0, 1}}, {1, 0, 0}), "load[1].where",
       "whole outer face"},
      {"force_nan", good_box().force("y+", {0, not_a_number, 0}), "load[1].force", "finite"},
      {"force_nowhere", good_box().force(BoxRegion{{1, 1, 1}, {2, 2, 2}}, {1, 0, 0}), "load[1].where",
       "whole outer face"},
      {"gravity_nan", good_box().gravity({0, not_a_number, 0}), "load[1].gravity", "finite"},
      {"contraction_negative", good_box().contraction(-1), "load[1].contraction", ">= 0"},
      {"contraction_nan", good_box().contraction(not_a_number), "load[1].contraction", "nan"},
      {"contraction_nowhere", good_box().contraction(1, "x-"), "load[1].where", "whole cell"},
      // Settings
      {"own_limits_unknown", limited([](LimitSettings& l) { l.from = LimitSource::material; }), "limits.from",
       "taut"},
      {"failure_unknown", limited([](LimitSettings& l) { l.from = LimitSource::failure; }), "limits.from",
       "failure"},
      {"given_stretch", limited([](LimitSettings& l) { l.given.stretch[0] = 0.5; }), "limits.stretch",
       ">= 1"},
      {"given_shear", limited([](LimitSettings& l) { l.given.shear[0][1] = not_a_number; }),
       "limits.shear[0][1]", ">= 0"},
      {"given_unasked", limited([](LimitSettings& l) {
         l.from = LimitSource::taut;
         l.given.stretch[0] = 2;
       }),
       "limits.given", "unless"},
      {"taut_scale", limited([](LimitSettings& l) { l.taut_scale = -1; }), "limits.taut_scale", "> 0"},
      {"tolerance", relaxed([](RelaxationSettings& r) { r.tolerance = 1; }), "relaxation.tolerance",
       "between 0 and 1"},
      {"tolerance_nan", relaxed([](RelaxationSettings& r) { r.tolerance = not_a_number; }),
       "relaxation.tolerance", "nan"},
      {"sweeps", relaxed([](RelaxationSettings& r) { r.sweeps = 0; }), "relaxation.sweeps", "from 1"},
      {"increments", relaxed([](RelaxationSettings& r) { r.increments = -1; }), "relaxation.increments",
       "from 1"},
  };
  for (const Slip& slip : slips) {
    SCOPED_TRACE(slip.name);
    const Fault fault = test::only_fault_of([&] { slip.builder.build(); });
    EXPECT_EQ(fault.key, slip.key) << to_string(fault);
    EXPECT_TRUE(test::has(to_string(fault), slip.text));
    EXPECT_TRUE(fault.file.empty());
    EXPECT_EQ(fault.line, 0);
  }
}

TEST(SceneBuilderContract, GoodScenesOfTheseTestsHaveNoFault) {
  for (const SceneBuilder& builder :
       {good_box(), good_image(), placed(affine_of({1, 1, 1})), laid_out(ArrayLayout::z_fastest({2, 2, 2})),
        limited([](LimitSettings&) {}), relaxed([](RelaxationSettings&) {}), of_matter([](Material&) {})})
    EXPECT_NO_THROW(builder.build());
}

TEST(SceneBuilderContract, AllFaultsComeAtOnce) {
  Material bad = soft();
  bad.density = -1;
  RelaxationSettings relaxation;
  relaxation.sweeps = 0;
  const SceneBuilder builder = SceneBuilder()
                                   .box(3, {4, 0, 2}, {1, 1, not_a_number})
                                   .material(bad)
                                   .hold("w-")
                                   .move("x+", {infinity, 0, 0}, "q")
                                   .traction("x+", {not_a_number, 0, 0})
                                   .contraction(-1)
                                   .relaxation(relaxation);
  const auto tried = builder.try_build();
  ASSERT_TRUE(std::holds_alternative<std::vector<Fault>>(tried));
  const auto& faults = std::get<std::vector<Fault>>(tried);
  EXPECT_EQ(test::keys_of(faults),
            (std::vector<std::string>{"specimen.material.density", "specimen.cells", "specimen.spacing",
                                      "relaxation.sweeps", "hold[1].where", "move[1].axes", "move[1].by",
                                      "load[1].traction", "load[2].contraction"}));
  EXPECT_EQ(test::faults_found_by([&] { builder.build(); }).size(), faults.size());
}

} // namespace
} // namespace maille
