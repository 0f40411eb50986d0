/// What an answer makes of measures, held against formulas and against sums written out here.

#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/scenes.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

#include <Eigen/Dense>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::measure_text;

Vector3d vec(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

const std::string box = R"(
[specimen]
shape = "box"
cells = [5, 4, 3]
spacing = ["1 mm", "2 mm", "1.5 mm"]
material = { E_fibre = "40 kPa", E_cross = "10 kPa", G_fibre = "4 kPa", nu_fibre = 0.3, nu_cross = 0.4 }
fibre = [3, 0, 4]
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["1 mm", 0, 0]
)";

const std::string tip_face_and_ball =
    measure_text("tip", R"(displacement = { at = ["3.3 mm", "4.1 mm", "0.2 mm"] })") +
    measure_text("face", R"(displacement = { mean = { where = "x+" } })") +
    measure_text(
        "ball",
        R"(displacement = { mean = { sphere = { centre = ["2.5 mm", "4 mm", "2.25 mm"], radius = "3 mm" } } })");

const std::array<Vec3, 3> gradient{{{0.02, -0.01, 0.03}, {0.04, -0.03, 0.005}, {0.01, 0.02, 0.015}}};
const Vec3 shift{1e-3, -2e-3, 5e-4};

Matrix3d matrix(const std::array<Vec3, 3>& g) {
  Matrix3d m;
  m << g[0][0], g[0][1], g[0][2], g[1][0], g[1][1], g[1][2], g[2][0], g[2][1], g[2][2];
  return m;
}

/// The measures of a file, of an answer with a uniform strain.
struct Uniform {
  SceneAndMeasures read;
  Answer answer;
  std::vector<MeasuredValue> values;

  explicit Uniform(const std::string& measures) : read(parse_scene_and_measures(box + measures)) {
    answer.method = "coupled";
    answer.displacement = test::affine_displacement<Displacement>(read.scene, gradient, shift);
    values = measured(read.scene, read.measures, answer);
  }
  const MeasuredValue& of(const std::string& name) const {
    return *std::ranges::find(values, name, &MeasuredValue::name);
  }
  double value(const std::string& name) const { return of(name).value.value(); }
};

// Truth: P = mu (F - F^-T) + lambda ln J F^-T of neo-Hookean matter, F = R U; principal values.
TEST(MeasureAnalytic, FiniteStrainByEachName) {
  std::string text = "strain = \"finite\"\n" + box;
  text.replace(text.find("{ E_fibre"), text.find("}") - text.find("{ E_fibre") + 1,
               "{ law = \"neo_hookean\", E = \"10 kPa\", nu = 0.3 }");
  for (const char* name : {"stretch", "green_lagrange", "logarithmic", "nominal"})
    text += measure_text(name, std::string(name == std::string("nominal") ? "stress" : "strain") +
                                   " = { mean = \"body\" }\nkind = \"" + name + "\"");
  const SceneAndMeasures read = parse_scene_and_measures(text);
  Matrix3d U;
  U << 1.3, 0.1, 0, 0.1, 0.9, -0.05, 0, -0.05, 1.1;
  const Matrix3d R = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized()).toRotationMatrix(), F = R * U,
                 G = F - Matrix3d::Identity(), transposed = F.inverse().transpose();
  Answer answer;
  answer.method = "coupled";
  answer.displacement = test::affine_displacement<Displacement>(
      read.scene, {{{G(0, 0), G(0, 1), G(0, 2)}, {G(1, 0), G(1, 1), G(1, 2)}, {G(2, 0), G(2, 1), G(2, 2)}}},
      {});
  const double mu = 1e4 / 2.6, lambda = 1e4 * 0.3 / (1.3 * 0.4);
  const Matrix3d P = mu * (F - transposed) + lambda * std::log(F.determinant()) * transposed;
  const Vector3d stretches = U.selfadjointView<Eigen::Lower>().eigenvalues(),
                 stresses = (R.transpose() * P).selfadjointView<Eigen::Lower>().eigenvalues();
  const std::vector<MeasuredValue> found = measured(read.scene, read.measures, answer);
  const double l = stretches[2];
  const std::array<double, 4> truths{l, (l * l - 1) / 2, std::log(l), stresses[2]};
  for (std::size_t i = 0; i < truths.size(); ++i)
    EXPECT_NEAR(found[i].value.value(), truths[i], 1e-9 * truths[i]) << found[i].name;
}

Vector3d displaced(const Vector3d& x) {
  return matrix(gradient) * x + vec(shift);
}

// Truth: u = G x + t at any point, mean and line; a mean is the field at the centroid.
TEST(MeasureAnalytic, DisplacementOfAUniformStrain) {
  const Uniform uniform(
      tip_face_and_ball +
      measure_text("part", R"(displacement = { at = ["3.3 mm", "4.1 mm", "0.2 mm"] })"
                           "\ncomponent = [0, 3, 4]") +
      measure_text("size", R"(displacement = { at = ["5 mm", "8 mm", "4.5 mm"] })"
                           "\ncomponent = \"magnitude\"") +
      measure_text("mean", R"(displacement = { mean = "body" })") +
      measure_text("along",
                   R"(displacement = { along = [[0, 0, 0], ["5 mm", "8 mm", "4.5 mm"]], points = 7 })"));
  const Vector3d tip = displaced({3.3e-3, 4.1e-3, 0.2e-3});
  EXPECT_LT((vec(*uniform.of("tip").vector) - tip).norm(), 1e-15);
  EXPECT_NEAR(uniform.value("tip"), tip.norm(), 1e-15);
  EXPECT_EQ(uniform.of("tip").unit, "m");
  EXPECT_NEAR(uniform.value("part"), 0.6 * tip.y() + 0.8 * tip.z(), 1e-15);
  EXPECT_NEAR(uniform.value("size"), displaced({5e-3, 8e-3, 4.5e-3}).norm(), 1e-15);
  const Vector3d middle = displaced({2.5e-3, 4e-3, 2.25e-3});
  EXPECT_LT((vec(*uniform.of("mean").vector) - middle).norm(), 1e-15);
  EXPECT_LT((vec(*uniform.of("face").vector) - displaced({5e-3, 4e-3, 2.25e-3})).norm(), 1e-15);
  EXPECT_NEAR(uniform.of("ball").vector.value()[1], middle.y(), 1e-15);
  const MeasuredValue& line = uniform.of("along");
  EXPECT_FALSE(line.value || line.vector);
  ASSERT_EQ(line.line.size(), 7u);
  for (std::size_t i = 0; i < 7; ++i) {
    const Vector3d x = double(i) / 6 * Vector3d(5e-3, 8e-3, 4.5e-3);
    EXPECT_NEAR(line.line[i].along, x.norm(), 1e-15);
    EXPECT_LT((vec(*line.line[i].vector) - displaced(x)).norm(), 1e-15) << i;
    EXPECT_NEAR(line.line[i].value.value(), displaced(x).norm(), 1e-15) << i;
  }
}

// Truth: E = sym G everywhere; its eigenvalues by Eigen; Hooke's law by the material's own stiffness.
TEST(MeasureAnalytic, StrainAndStressOfAUniformStrain) {
  std::string text;
  for (const char* kind : {"fibre", "largest", "smallest", "xx", "yy", "zz", "xy", "yz", "xz"})
    text += fmt::format("[[measure]]\nname = \"e_{0}\"\nstrain = {{ mean = \"body\" }}\nkind = \"{0}\"\n"
                        "[[measure]]\nname = \"s_{0}\"\nstress = {{ at = [\"1 mm\", \"1 mm\", \"1 mm\"] }}\n"
                        "kind = \"{0}\"\n",
                        kind);
  text += "[[measure]]\nname = \"by_default\"\nstrain = { mean = { where = { box = [[0, 0, 0], [\"2 mm\", "
          "\"8 mm\", \"4.5 mm\"]] } } }\n"
          "[[measure]]\nname = \"mises\"\nstress = { mean = \"body\" }\nkind = \"von_mises\"\n"
          "[[measure]]\nname = \"squeezed\"\nstress = { mean = \"body\" }\nkind = \"pressure\"\n";
  const Uniform uniform(text);
  const Matrix3d E = (matrix(gradient) + matrix(gradient).transpose()) / 2;
  Eigen::Matrix<double, 6, 1> strain;
  strain << E(0, 0), E(1, 1), E(2, 2), 2 * E(1, 2), 2 * E(0, 2), 2 * E(0, 1);
  const Eigen::Matrix<double, 6, 1> s = uniform.read.scene.object_stiffness(0) * strain;
  Matrix3d S;
  S << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
  const Vector3d fibre(0.6, 0, 0.8);
  for (const auto& [prefix, tensor, unit] : {std::tuple{"e_", E, ""}, {"s_", S, "Pa"}}) {
    const Vector3d principal = Eigen::SelfAdjointEigenSolver<Matrix3d>(tensor).eigenvalues();
    const double tolerance = 1e-12 * tensor.norm();
    const auto value = [&](const char* kind) { return uniform.value(std::string(prefix) + kind); };
    EXPECT_NEAR(value("fibre"), fibre.dot(tensor * fibre), tolerance);
    EXPECT_NEAR(value("largest"), principal(2), tolerance);
    EXPECT_NEAR(value("smallest"), principal(0), tolerance);
    EXPECT_NEAR(value("xx"), tensor(0, 0), tolerance);
    EXPECT_NEAR(value("yy"), tensor(1, 1), tolerance);
    EXPECT_NEAR(value("zz"), tensor(2, 2), tolerance);
    EXPECT_NEAR(value("xy"), tensor(0, 1), tolerance);
    EXPECT_NEAR(value("yz"), tensor(1, 2), tolerance);
    EXPECT_NEAR(value("xz"), tensor(0, 2), tolerance);
    EXPECT_EQ(uniform.of(std::string(prefix) + "xx").unit, unit);
  }
  EXPECT_NEAR(uniform.value("by_default"), fibre.dot(E * fibre), 1e-14);
  const Matrix3d deviator = S - S.trace() / 3 * Matrix3d::Identity();
  EXPECT_NEAR(uniform.value("mises"), std::sqrt(1.5) * deviator.norm(), 1e-10 * S.norm());
  EXPECT_NEAR(uniform.value("squeezed"), -S.trace() / 3, 1e-10 * S.norm());
}

// Truth: F = 1 + G maps lines, angles and volumes.
TEST(MeasureAnalytic, LengthAngleAndVolumeOfAUniformStrain) {
  const std::string line = "[[\"1 mm\", \"1 mm\", \"1 mm\"], [\"4 mm\", \"3 mm\", \"2 mm\"], [\"4 mm\", \"7 "
                           "mm\", \"2 mm\"]]",
                    corner = "[[\"1 mm\", 0, 0], [0, 0, 0], [0, \"3 mm\", \"1 mm\"]]",
                    lines = "[[0, 0, 0], [\"5 mm\", 0, 0], [\"1 mm\", \"1 mm\", \"1 mm\"], [\"2 mm\", \"3 "
                            "mm\", \"1 mm\"]]";
  std::string text;
  for (const char* kind : {"value", "change", "relative"})
    text += fmt::format("[[measure]]\nname = \"length_{0}\"\nlength = {1}\nkind = \"{0}\"\n"
                        "[[measure]]\nname = \"volume_{0}\"\nvolume = {{ where = {{ box = [[0, 0, 0], [\"3 "
                        "mm\", \"4 mm\", \"3 mm\"]] }} }}\nkind = \"{0}\"\n",
                        kind, line);
  text += fmt::format("[[measure]]\nname = \"corner\"\nangle = {}\n[[measure]]\nname = \"opens\"\nangle = "
                      "{}\nkind = \"change\"\n[[measure]]\nname = \"lines\"\nangle = {}\n",
                      corner, corner, lines);
  const Uniform uniform(text);
  const Matrix3d F = Matrix3d::Identity() + matrix(gradient);
  const double rest = Vector3d(3e-3, 2e-3, 1e-3).norm() + 4e-3,
               deformed = (F * Vector3d(3e-3, 2e-3, 1e-3)).norm() + (F * Vector3d(0, 4e-3, 0)).norm();
  EXPECT_NEAR(uniform.value("length_value"), deformed, 1e-15);
  EXPECT_NEAR(uniform.value("length_change"), deformed - rest, 1e-15);
  EXPECT_NEAR(uniform.value("length_relative"), deformed / rest - 1, 1e-13);
  EXPECT_EQ(uniform.of("length_relative").unit, "");
  EXPECT_NEAR(uniform.value("volume_value"), 36e-9 * F.determinant(), 1e-20);
  EXPECT_NEAR(uniform.value("volume_change"), 36e-9 * (F.determinant() - 1), 1e-20);
  EXPECT_NEAR(uniform.value("volume_relative"), F.determinant() - 1, 1e-12);
  EXPECT_EQ(uniform.of("volume_value").unit, "m^3");
  const auto angle = [&](const Vector3d& a, const Vector3d& b) {
    return std::acos((F * a).normalized().dot((F * b).normalized()));
  };
  EXPECT_NEAR(uniform.value("corner"), angle({1, 0, 0}, {0, 3, 1}), 1e-12);
  EXPECT_NEAR(uniform.value("opens"), angle({1, 0, 0}, {0, 3, 1}) - std::acos(0.0), 1e-12);
  EXPECT_NEAR(uniform.value("lines"), angle({1, 0, 0}, {1, 2, 0}), 1e-12);
}

// Truth: the mean of a figure over the cells that share a point, and sums over nodes, written out here.
TEST(MeasureIndependent, ForcesAreSumsOfReactions) {
  const SceneAndMeasures read = parse_scene_and_measures(
      box + measure_text("pull", "force = \"move[1]\"") +
      measure_text("stay", "force = \"hold[1]\"\ncomponent = \"x\"") +
      measure_text("edge", R"(force = { where = { box = [[0, 0, 0], ["5 mm", 0, "4.5 mm"]] } })") +
      measure_text("cut", R"(force = { section = { point = ["2.2 mm", 0, 0], normal = [2, 1, 0] } })"
                          "\ncomponent = \"normal\""));
  Answer answer;
  answer.method = "coupled";
  answer.displacement = Displacement(read.scene.specimen.grid);
  std::mt19937 random(5);
  test::Dice dice{random};
  for (std::size_t i = 0; i < read.scene.prescribed.size(); ++i)
    answer.reaction.push_back(dice.between(-1, 1));
  Vector3d pull = Vector3d::Zero(), stay = pull, edge = pull, cut = pull;
  const Vector3d normal = Vector3d(2, 1, 0).normalized();
  for (std::size_t i = 0; i < read.scene.prescribed.size(); ++i) {
    const Prescribed& p = read.scene.prescribed[i];
    const Vector3d x = vec(read.scene.specimen.position(read.scene.specimen.grid.node_at(p.node)));
    Vector3d force = Vector3d::Zero();
    force(p.component) = answer.reaction[i];
    (p.held ? stay : pull) += force;
    if (std::abs(x.y()) < 1e-9)
      edge += force;
    if (normal.dot(x - Vector3d(2.2e-3, 0, 0)) > 0)
      cut += force;
  }
  const auto values = measured(read.scene, read.measures, answer);
  EXPECT_LT((vec(*values[0].vector) - pull).norm(), 1e-12);
  EXPECT_NEAR(*values[0].value, pull.norm(), 1e-12);
  EXPECT_NEAR(*values[1].value, stay.x(), 1e-12);
  EXPECT_LT((vec(*values[2].vector) - edge).norm(), 1e-12);
  EXPECT_NEAR(*values[3].value, normal.dot(cut), 1e-12);
  EXPECT_EQ(values[0].unit, "N");

  answer.method = "limits";
  answer.reaction.clear();
  for (const MeasuredValue& value : measured(read.scene, read.measures, answer)) {
    EXPECT_FALSE(value.value || value.vector);
    EXPECT_EQ(value.why_not, "limits knows no forces");
  }
}

// Truth: two bars side by side under one plate share its force by E A; parts of the plate, by label, by what
// is not of it, add up to the whole, as volumes of labels do, of which a cell has the part that is tissue.
TEST(MeasureAnalytic, PartsByLabelAddUpToTheWhole) {
  image_tests::TemporaryFolder folder;
  test::LabelArray bars{
      {6, 3, 4}, {}, affine_of({1e-3, 1e-3, 1e-3}, {0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}})};
  for (int voxel = 0; voxel < 72; ++voxel)
    bars.values.push_back(voxel % 6 < 4 ? 1 : 2);
  folder.write("labels.nii", test::nifti_of(bars));
  const auto read = [&](const std::string& keys) {
    return read_scene_and_measures(folder.write(
        "scene.toml",
        R"(units = "m"
[specimen]
shape = "image"
image = "labels.nii"
labels = { 1 = { youngs_modulus = 1e9, poisson_ratio = 0 }, 2 = { youngs_modulus = 1e10, poisson_ratio = 0 } }
)" + keys + R"(
[[hold]]
where = "z-"
[[move]]
where = "z+"
by = [0, 0, -4e-5]
)" + measure_text("one", "force = { where = { all = [\"z+\", { label = 1 }] } }\ncomponent = \"z\"") +
            measure_text(
                "two", "force = { where = { all = [\"z+\", { not = { label = 1 } }] } }\ncomponent = \"z\"") +
            measure_text("volume_1", "volume = { label = 1 }") +
            measure_text("volume_2", "volume = { label = 2 }")));
  };
  const auto values_of = [](const SceneAndMeasures& asked) {
    // Of uniaxial strain of 1 %: a cell presses its four corners with E a / 4 each.
    Answer answer;
    answer.method = "coupled";
    answer.displacement = Displacement(asked.scene.specimen.grid);
    for (const Prescribed& p : asked.scene.prescribed) {
      double force = 0;
      asked.scene.specimen.for_each_cell_at(
          asked.scene.specimen.grid.node_at(p.node), [&](std::int64_t cell) {
            force -= 0.01 *
                     asked.scene.materials[asked.scene.specimen.material(cell)].elasticity.youngs_modulus[0] *
                     1e-6 / 4;
          });
      answer.reaction.push_back(p.component == 2 && !p.held ? force : 0);
    }
    return measured(asked.scene, asked.measures, answer);
  };
  const auto values = values_of(read(""));
  EXPECT_NEAR(*values[0].value, -12e-6 * 1e9 * 0.01, 1e-9);
  EXPECT_NEAR(*values[1].value, -6e-6 * 1e10 * 0.01, 1e-9);
  EXPECT_NEAR(*values[2].value, 48e-9, 1e-13);
  const auto in_part = values_of(read("coarsen = [1, 2, 1]\npartial_volume = true"));
  EXPECT_NEAR(*in_part[2].value + *in_part[3].value, 72e-9, 1e-13);
}

// Truth: two boxes side by side, a ball and what is outside of it, two labels, two faces with an edge: of
// pressures and of any reactions the parts add up to the whole, and a hold's own box bears all of its force.
// Nodes of an edge bear on both faces: there parts add up to the whole and the edge.
TEST(MeasureIndependent, RandomPartsAddUpToTheWhole) {
  std::mt19937 random(41);
  test::Dice dice{random};
  double resultant_error = 0;
  for (int n = 0; n < 300; ++n) {
    image_tests::TemporaryFolder folder;
    const bool is_partial = n % 2 == 1;
    test::LabelArray body{{6 + 2 * dice.below(3), 8, 6 + 2 * dice.below(2)}, {}, {}};
    body.affine = affine_of({1e-3, 2e-3, 1e-3}, {0.0123, -0.02, 0.005}, {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}});
    const int high = 5, wide = 5; // on no plane between the boxes: an outer face there is in both
    for (const auto& [i, j, k] : test::all_below(body.size))
      body.values.push_back(i < wide ? 1 : k < high ? 2 : 0);
    folder.write("labels.nii", test::nifti_of(body));
    const int axis = dice.below(3);
    const double step = (axis == 0 ? 2 : 1) * (is_partial ? 2 : 1);
    const double at = std::array{11.3, -19.5, 4.5}[std::size_t(axis)] +
                      (axis == 1 ? -step : step) * (1 + dice.below(is_partial ? 2 : 3));
    const auto half = [&](bool is_upper) {
      Vec3 low{-99, -99, -99}, top{99, 99, 99};
      (is_upper ? low : top)[axis] = at;
      return fmt::format("{{ box = [[{}, {}, {}], [{}, {}, {}]] }}", low[0], low[1], low[2], top[0], top[1],
                         top[2]);
    };
    const std::string ball = fmt::format("{{ sphere = {{ centre = [{}, {}, 5], radius = {} }} }}",
                                         11.3 + 2 * dice.below(5), -19.5 - dice.below(6), 3 + dice.below(4));
    const std::array<std::array<std::string, 2>, 4> pairs{{{half(false), half(true)},
                                                           {ball, "{ not = " + ball + " }"},
                                                           {"{ label = 1 }", "{ label = 2 }"},
                                                           {"\"x-\"", "\"z-\""}}};
    std::string text =
        "units = \"mm\"\n[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = { 1 = { "
        "youngs_modulus = \"1 kPa\", poisson_ratio = 0 }, 2 = { youngs_modulus = \"9 kPa\", poisson_ratio = "
        "0 } }\n" +
        std::string(is_partial ? "coarsen = 2\npartial_volume = true\n" : "") +
        "[[hold]]\nwhere = \"z-\"\n[[hold]]\nframe = \"world\"\nwhere = " + pairs[0][0] + "\n";
    const auto& pair = pairs[static_cast<std::size_t>(n / 2 % 4)];
    const bool are_faces = &pair == &pairs.back();
    const std::array<std::string, 3> parts{pair[0], pair[1], "{ any = [" + pair[0] + ", " + pair[1] + "] }"};
    for (std::size_t part = 0; part < 3; ++part)
      text +=
          fmt::format("[[load]]\nframe = \"world\"\npressure = \"1 kPa\"\nwhere = {1}\n[[measure]]\nframe = "
                      "\"world\"\nname = \"part{0}\"\nforce = {{ where = {1} }}\n",
                      part, parts[part]);
    text += "[[measure]]\nframe = \"world\"\nname = \"held\"\nforce = { where = " + pairs[0][0] + " }\n";
    if (are_faces)
      text +=
          "[[hold]]\nwhere = \"x-\"\n[[measure]]\nframe = \"world\"\nname = \"edge\"\nforce = { where = { "
          "all = [\"x-\", \"z-\"] } }\n";
    try {
      const auto asked = read_scene_and_measures(folder.write("scene.toml", text));
      Answer answer;
      answer.method = "coupled";
      answer.displacement = Displacement(asked.scene.specimen.grid);
      Vector3d all = Vector3d::Zero(), in_box = all;
      for (const Prescribed& p : asked.scene.prescribed) {
        answer.reaction.push_back(dice.between(-1, 1));
        Vec3 force{};
        force[std::size_t(p.component)] = answer.reaction.back();
        (p.condition == 0 ? all : in_box) += vec(to_world(asked.scene.specimen.placement, force));
      }
      const auto values = measured(asked.scene, asked.measures, answer);
      const auto error = [&](const Vector3d& difference) {
        resultant_error = std::max(resultant_error, difference.norm());
        EXPECT_LT(difference.norm(), 1e-9) << text;
      };
      error(vec(*values[0].vector) + vec(*values[1].vector) - vec(*values[2].vector) -
            (are_faces ? vec(*values[4].vector) : Vector3d::Zero()));
      if (!are_faces)
        error(vec(*values[2].vector) - all - in_box);
      std::map<std::int32_t, Vector3d> loads;
      for (const FaceLoad& face : asked.scene.tractions)
        loads.try_emplace(face.condition, Vector3d::Zero()).first->second +=
            vec(face.traction) * (face.axis == 1 ? 1 : 2);
      ASSERT_EQ(loads.size(), 3U);
      auto load = loads.begin();
      const Vector3d one = (load++)->second, other = (load++)->second;
      error((one + other - load->second) / 1e3);
    } catch (const InputError& fault) {
      EXPECT_TRUE(fault.faults().front().key.ends_with("where") || is_partial) << fault.what() << text;
    }
  }
  std::cout << "resultant_error " << resultant_error << '\n';
}

// Truth: the energies of cells, added up here.
TEST(MeasureIndependent, EnergyOfAPartIsTheSumOfItsCells) {
  const SceneAndMeasures read = parse_scene_and_measures(
      box + "[[measure]]\nname = \"half\"\nenergy = { where = { box = [[0, 0, 0], [\"2 mm\", \"8 mm\", \"4.5 "
            "mm\"]] } }\n[[measure]]\nname = \"all\"\nenergy = \"body\"\n");
  Answer answer;
  answer.method = "fem_q1";
  answer.displacement = Displacement(read.scene.specimen.grid);
  double half = 0, all = 0;
  for (int cell = 0; cell < 60; ++cell) {
    answer.cell_energy.push_back(cell * cell);
    all += cell * cell;
    half += cell % 5 < 2 ? cell * cell : 0;
  }
  const auto values = measured(read.scene, read.measures, answer);
  EXPECT_NEAR(*values[0].value, half, 1e-9);
  EXPECT_NEAR(*values[1].value, all, 1e-9);
  answer.cell_energy.clear();
  EXPECT_EQ(measured(read.scene, read.measures, answer)[0].why_not, "fem_q1 keeps no energies of cells");
}

// Truth: a line through matter with a hole has values where there is matter.
TEST(MeasureContract, ALineHasNoValueOutsideOfTheMatter) {
  const SceneAndMeasures read = parse_scene_and_measures(R"(
units = "mm"
[specimen]
shape = "ellipsoid"
cells = [8, 8, 8]
spacing = 1
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[measure]]
name = "slant"
strain = { along = [[-1, 4, 4], [9, 4, 4]], points = 11 }
)");
  Answer answer;
  answer.method = "coupled";
  answer.displacement = test::affine_displacement<Displacement>(read.scene, gradient, shift);
  const MeasuredValue value = measured(read.scene, read.measures, answer)[0];
  ASSERT_EQ(value.line.size(), 11u);
  EXPECT_FALSE(value.line.front().value || value.line.back().value);
  const double largest =
      Eigen::SelfAdjointEigenSolver<Matrix3d>((matrix(gradient) + matrix(gradient).transpose()) / 2)
          .eigenvalues()(2);
  for (std::size_t i = 1; i < 10; ++i)
    EXPECT_NEAR(value.line[i].value.value(), largest, 1e-12) << "isotropic: no fibres";
}

// Truth: |v - r| / |r| by hand.
TEST(MeasureAnalytic, RelativeErrors) {
  MeasuredValue value, reference;
  value.value = 1.1;
  reference.value = 1;
  reference.scale = 2;
  EXPECT_NEAR(relative_error(value, reference).value(), 0.1, 1e-15);
  reference.value = 1e-7;
  EXPECT_FALSE(relative_error(value, reference)) << "rounding beside what was summed";
  value.is_vector = reference.is_vector = true;
  value.value = reference.value = 5;
  value.vector = Vec3{3, 4, 0};
  reference.vector = Vec3{4, 3, 0};
  EXPECT_NEAR(relative_error(value, reference).value(), std::sqrt(2.0) / 5, 1e-15);
  value.vector.reset();
  EXPECT_FALSE(relative_error(value, reference));
  MeasuredValue line, other;
  line.is_line = other.is_line = true;
  line.line = {{0, {}, 1.0, {}}, {1, {}, {}, {}}, {2, {}, 2.0, {}}};
  other.line = {{0, {}, 2.0, {}}, {1, {}, 7.0, {}}, {2, {}, 1.0, {}}};
  EXPECT_NEAR(relative_error(line, other).value(), std::sqrt(2.0 / 5), 1e-15);
}

// Truth: halving cells changes no mean, volume or length of a uniform strain, and no set of places.
TEST(MeasureAnalytic, OnARefinedLatticeTheyAreTheSame) {
  const Uniform uniform(
      tip_face_and_ball +
      measure_text("bulk", R"(volume = { where = { box = [[0, 0, 0], ["3 mm", "4 mm", "3 mm"]] } })") +
      measure_text("fibre_strain", R"(strain = { mean = "body" })"));
  const Scene fine = refined(uniform.read.scene);
  Answer answer;
  answer.method = "coupled";
  answer.displacement = test::affine_displacement<Displacement>(fine, gradient, shift);
  const auto finer = refined(uniform.read.measures, uniform.read.scene, fine);
  EXPECT_EQ(finer[1].nodes.size(), 9u * 7u) << "a whole face";
  const auto values = measured(fine, finer, answer);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(*values[i].value, *uniform.values[i].value, 1e-12 * std::abs(*values[i].value)) << i;
    if (values[i].vector) {
      EXPECT_LT((vec(*values[i].vector) - vec(*uniform.values[i].vector)).norm(), 1e-15) << i;
    }
  }
}

// Truth: units in two dimensions, per metre of thickness.
TEST(MeasureContract, UnitsInTwoDimensions) {
  const SceneAndMeasures read = parse_scene_and_measures(
      test::box_text("[4, 2]") + test::hold_text() + measure_text("area", "volume = \"body\"") +
      measure_text("held", "force = \"hold[1]\"") + measure_text("stored", "energy = \"body\""));
  EXPECT_EQ(unit_of(read.measures[0], 2), "m^2");
  EXPECT_EQ(unit_of(read.measures[1], 2), "N/m");
  EXPECT_EQ(unit_of(read.measures[2], 2), "J/m");
}

/// Measures of oriented images: the same in the world whichever way the image is stored.

Matrix3d gradient_in_world() {
  Matrix3d m;
  m << 0.02, -0.01, 0.03, 0.04, -0.03, 0.005, 0.01, 0.02, 0.015;
  return m;
}

std::string in_toml(const Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

// Truth: the field as it is in the world does not depend on how an image is stored; places are taken into
// the image's own coordinates here, by its affine.
TEST(MeasureIndependent, OrientedImagesAnswerAlikeInTheWorld) {
  const test::LabelArray body = test::bent_body();
  const auto affine_of_array = [](const test::LabelArray& array) {
    Matrix3d axes;
    Vector3d origin;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        axes(r, c) = array.affine[std::size_t(r)][std::size_t(c)];
      origin(r) = array.affine[std::size_t(r)][3];
    }
    return std::pair{axes, origin};
  };
  // The middle of voxel (2, 1, 1), a bit off, in the world.
  const auto [axes, origin] = affine_of_array(body);
  const Vector3d point = axes * Vector3d(2.1, 0.8, 1.2) + origin, normal = Vector3d(1, 2, -1).normalized();
  const Vector3d force(0.3, -0.2, 0.5);
  std::vector<std::vector<MeasuredValue>> answers;
  for (const test::Orientation& orientation : test::all_orientations()) {
    const test::LabelArray array = test::turned(body, orientation);
    const auto [to, from] = affine_of_array(array);
    const Vector3d index = to.inverse() * (point - from), size = to.colwise().norm();
    const Vector3d place = (index.array() + 0.5) * size.array();
    const Vector3d across = (to * size.cwiseInverse().asDiagonal()).transpose() * normal;
    image_tests::TemporaryFolder folder;
    folder.write("labels.nii", test::nifti_of(array));
    const std::string where = fmt::format("[{}, {}, {}]", place.x(), place.y(), place.z());
    const std::string text = fmt::format(
        "units = \"m\"\n[specimen]\nshape = \"image\"\nimage = \"labels.nii\"\nlabels = {{ 17 = "
        "\"muscle/soleus\", 5 = {{ youngs_modulus = \"30 kPa\", poisson_ratio = 0.4 }} }}\nfibre = [1, 0, "
        "0]\n"
        "[[hold]]\nwhere = {{ box = [[-1, -1, -1], [1, 1, 1]] }}\n"
        "[[measure]]\nname = \"at\"\ndisplacement = {{ at = {0} }}\n"
        "[[measure]]\nname = \"mean\"\ndisplacement = {{ mean = {{ label = 17 }} }}\n"
        "[[measure]]\nname = \"xx\"\nstrain = {{ mean = {{ label = 17 }} }}\nkind = \"xx\"\n"
        "[[measure]]\nname = \"yz\"\nstrain = {{ at = {0} }}\nkind = \"yz\"\n"
        "[[measure]]\nname = \"volume_17\"\nvolume = {{ label = 17 }}\n"
        "[[measure]]\nname = \"held\"\nforce = \"hold[1]\"\n"
        "[[measure]]\nname = \"cut\"\nforce = {{ section = {{ point = {0}, normal = [{1}, {2}, {3}] }} }}\n"
        "[[measure]]\nname = \"through\"\nforce = {{ section = {{ point = {0}, normal = [{1}, {2}, {3}] }} "
        "}}\ncomponent = \"normal\"\n"
        "[[measure]]\nname = \"at_world\"\ndisplacement = {{ at = {4} }}\nframe = \"world\"\n"
        "[[measure]]\nname = \"at_lps\"\ndisplacement = {{ at = {5} }}\ncomponent = \"x\"\nframe = \"lps\"\n"
        "[[measure]]\nname = \"cut_ras\"\nforce = {{ section = {{ point = {4}, normal = {6} }} }}\n"
        "component = \"normal\"\nframe = \"ras\"\n"
        "[[measure]]\nname = \"near\"\nvolume = {{ sphere = {{ centre = {4}, radius = {7} }} }}\nframe = "
        "\"world\"\n"
        "[[measure]]\nname = \"boxed\"\nvolume = {{ where = {{ sphere = {{ centre = {4}, radius = {7} }} }} "
        "}}\n"
        "frame = \"world\"\n",
        where, across.x(), across.y(), across.z(), in_toml(point),
        in_toml({-point.x(), -point.y(), point.z()}), in_toml(normal), 2.2 * size.maxCoeff());
    const SceneAndMeasures read = read_scene_and_measures(folder.write("scene.toml", text));
    const Specimen& specimen = read.scene.specimen;
    Matrix3d direction;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        direction(r, c) = specimen.placement.direction[std::size_t(r)][std::size_t(c)];
    Answer answer;
    answer.method = "coupled";
    answer.displacement = Displacement(specimen.grid);
    for (std::int64_t node = 0; node < specimen.grid.n_nodes(); ++node) {
      const Vector3d x =
          vec(specimen.placement.origin) + direction * vec(specimen.position(specimen.grid.node_at(node)));
      const Vector3d u = direction.transpose() * (gradient_in_world() * x);
      for (int b = 0; b < 3; ++b)
        answer.displacement(b, node) = u(b);
    }
    for (const Prescribed& p : read.scene.prescribed)
      answer.reaction.push_back((direction.transpose() * force)(p.component));
    answers.push_back(measured(read.scene, read.measures, answer));
  }
  const Matrix3d E = (gradient_in_world() + gradient_in_world().transpose()) / 2;
  constexpr double tolerance = 1e-6; // places of images are those of float32
  for (const auto& values : answers) {
    EXPECT_LT((vec(*values[0].vector) - gradient_in_world() * point).norm(), tolerance * point.norm());
    EXPECT_LT((vec(*values[1].vector) - vec(*answers[0][1].vector)).norm(), tolerance * point.norm());
    EXPECT_NEAR(*values[2].value, E(0, 0), tolerance);
    EXPECT_NEAR(*values[3].value, E(1, 2), tolerance);
    EXPECT_NEAR(*values[4].value / *answers[0][4].value, 1, tolerance);
    const double n_nodes = *answers[0][5].value / force.norm();
    EXPECT_NEAR(n_nodes, std::round(n_nodes), 1e-6);
    EXPECT_LT((vec(*values[5].vector) - std::round(n_nodes) * force).norm(), tolerance * n_nodes);
    EXPECT_LT((vec(*values[6].vector) - vec(*answers[0][6].vector)).norm(), tolerance * n_nodes);
    EXPECT_GT(*values[6].value, 0.0);
    EXPECT_LT(*values[6].value, *values[5].value);
    EXPECT_NEAR(*values[7].value, normal.dot(vec(*values[6].vector)), tolerance * n_nodes);
    // The same places as a viewer shows them: one text for all ways of storing.
    EXPECT_LT((vec(*values[8].vector) - gradient_in_world() * point).norm(), tolerance * point.norm());
    EXPECT_NEAR(*values[9].value, -(gradient_in_world() * point).x(), tolerance * point.norm());
    EXPECT_NEAR(*values[10].value, *values[7].value, tolerance * n_nodes);
    EXPECT_GT(*values[11].value, 0);
    EXPECT_NEAR(*values[11].value / *answers[0][11].value, 1, tolerance);
    EXPECT_GT(*values[12].value, 0);
    EXPECT_NEAR(*values[12].value / *answers[0][12].value, 1, tolerance);
  }
}

} // namespace
} // namespace maille
