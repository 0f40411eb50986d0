#include "maille/deform/solve.hpp"
#include "maille/scene/fibre/fibre_field.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

namespace maille::deform {
namespace {

Scene pulled_box() {
  Scene scene = test::lattice_box({4, 2}, test::even_limits(1.5, 0.5, 0.25));
  for (const Index3& at : test::face(scene, 0, false))
    test::hold(scene, at);
  for (const Index3& at : test::face(scene, 0, true))
    test::move(scene, at, {0.5, 0, 0});
  return scene;
}

TEST(SolveContract, EveryMethodRefusesASceneOfNothing) {
  for (const std::string_view method : methods()) {
    const Answer answer = solve(Scene{}, method);
    EXPECT_EQ(answer.status, Status::refused) << method;
    EXPECT_TRUE(test::has(answer.message, "no cells"));
  }
}

TEST(SolveContract, EveryMethodAnswersAScene) {
  for (const std::string_view method : methods()) {
    const Answer answer = solve(pulled_box(), method);
    EXPECT_EQ(answer.method, method);
    EXPECT_EQ(answer.status, Status::done) << method;
    EXPECT_EQ(answer.message, "") << method;
    EXPECT_FALSE(answer.algorithm.empty()) << method;
    EXPECT_GT(answer.iterations, 0) << method;
    EXPECT_GT(answer.bytes, 0) << method;
    EXPECT_GT(answer.seconds.total(), 0) << method;
    for (const Prescribed& p : pulled_box().prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), p.value) << method;
  }
}

TEST(SolveContract, AnUnknownMethodIsRefusedWithTheKnownOnes) {
  const Answer answer = solve(pulled_box(), "magic");
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.method, "magic");
  EXPECT_TRUE(test::has(answer.message, "`magic`"));
  for (const std::string_view method : methods())
    EXPECT_TRUE(test::has(answer.message, method));
}

TEST(SolveContract, LoadsAreRefused) {
  Scene heavy = pulled_box();
  heavy.gravity = {0, -9.81, 0};
  Scene loaded = pulled_box();
  loaded.tractions.push_back({0, 0, true, {1, 0, 0}});
  for (const std::string_view method : methods())
    for (const Scene* scene : {&heavy, &loaded}) {
      if (method == "relaxed" || method == "coupled") { // elastic methods
        EXPECT_EQ(solve(*scene, method).status, Status::done);
        continue;
      }
      const Answer answer = solve(*scene, method);
      EXPECT_EQ(answer.status, Status::refused);
      EXPECT_TRUE(answer.message.starts_with(std::string(method) + " carries no loads")) << answer.message;
      EXPECT_TRUE(answer.displacement.empty());
    }
}

TEST(SolveContract, MovesThatAreNotFiniteAreRefused) {
  for (const double value :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    Scene scene = pulled_box();
    test::move(scene, {4, 0, 0}, {value, 0, 0});
    for (const std::string_view method : methods())
      EXPECT_EQ(solve(scene, method).status, Status::refused) << method;
  }
}

TEST(SolveContract, ACallerCanStopEveryMethodThatIsLong) {
  Control stop;
  stop.stop_requested = [] { return true; };
  Control no_time;
  no_time.seconds_budget = 0.0;
  for (const char* method :
       {"limits", "dijkstra", "sweep"}) { // literal is short, relaxers have tests of their own
    EXPECT_EQ(solve(pulled_box(), method, stop).status, Status::interrupted) << method;
    const Answer answer = solve(pulled_box(), method, no_time);
    EXPECT_EQ(answer.status, Status::budget_reached) << method;
    const Scene scene = pulled_box();
    EXPECT_EQ(largest_violation(scene, LinkLimits(scene), answer.displacement), 0) << method;
  }
}

// The ways to ask: a file or a builder, a name or an enumeration. Truth: the other way, to the bit.

void expect_same_answers(const Scene& a, const Scene& b) {
  for (const Method method : every_method) {
    const Answer one = solve(a, method), other = solve(b, to_string(method));
    EXPECT_EQ(one.status, other.status) << to_string(method);
    EXPECT_EQ(one.displacement, other.displacement) << to_string(method);
    EXPECT_EQ(one.reaction, other.reaction) << to_string(method);
    EXPECT_EQ(one.method, to_string(method));
  }
}

TEST(WaysInConsistent, ABuiltBoxIsAnsweredAsItsText) {
  const Scene by_text = parse_scene(R"(units = "m"
[specimen]
shape = "box"
cells = [6, 4, 3]
spacing = 0.001
material = "muscle/soleus"
fibre = [1, 1, 0]
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [0.0003, 0.0001, 0]
)");
  const Scene built = SceneBuilder()
                          .box(3, {6, 4, 3}, {1e-3, 1e-3, 1e-3})
                          .material("muscle/soleus")
                          .fibre({1, 1, 0})
                          .hold("x-")
                          .move("x+", {3e-4, 1e-4, 0})
                          .build();
  EXPECT_EQ(solve(built, Method::coupled).status, Status::done);
  expect_same_answers(built, by_text);
}

TEST(WaysInConsistent, ABuiltLabelArrayIsAnsweredAsItsImage) {
  const image_tests::TemporaryFolder folder;
  const auto array = turned(test::bent_body(), {{2, 0, 1}, {true, false, true}});
  const auto memory = test::stored<std::int32_t>(array, {{1, 2, 0}, {false, true, true}});
  const Scene built = test::label_scene().labels(memory.elements, memory.layout, array.affine).build();
  EXPECT_EQ(solve(built, Method::coupled).status, Status::done);
  expect_same_answers(built, test::label_scene_by_file(folder, array));
}

TEST(WaysInContract, MethodsOfOtherModulesAreRefusedByName) {
  const Scene scene =
      SceneBuilder().box(1, {4, 1, 1}, {1, 1, 1}).material("muscle/soleus").hold("x-").build();
  std::vector<std::string_view> here;
  for (const Method method : every_method)
    if (bytes_needed(scene, method) > 0)
      here.push_back(to_string(method));
  EXPECT_EQ(here, methods());
  for (const Method method : {Method::fem_q1, Method::fem_q2, Method::calculix}) {
    const Answer answer = solve(scene, method);
    EXPECT_EQ(answer.status, Status::refused);
    EXPECT_TRUE(test::has(answer.message, to_string(method)));
  }
}

/// Methods on a lattice that is turned to the fibre.

Scene bent_box(const std::string& lattice, const std::string& tissue = "muscle/vastus_lateralis") {
  return parse_scene(fmt::format("[specimen]\nshape = \"box\"\nlattice = \"{}\"\ncells = [8, 4, 4]\nspacing "
                                 "= \"1 mm\"\nmaterial = \"{}\"\n"
                                 "fibre = [0, 0, 1]\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby "
                                 "= [\"0.5 mm\", \"0.2 mm\", \"-1 mm\"]\n"
                                 "[limits]\nfrom = \"taut\"\n[relaxation]\ntolerance = 1e-7\n",
                                 lattice, tissue));
}

// Oracle: the lattice along the axes, which after a quarter turn has the same cells, nodes and links.
TEST(FibreLatticeConsistent, AQuarterTurnChangesNoAnswer) {
  const Scene grid = bent_box("grid"), turned = bent_box("fibre");
  ASSERT_FALSE(turned.specimen.placement.is_identity());
  const double move = grid.largest_prescribed();
  for (const char* method : {"limits", "relaxed", "coupled"}) {
    const Displacement expected = solve(grid, method).displacement,
                       found = solve(turned, method).displacement;
    double worst = 0;
    for (std::int64_t node = 0; node < grid.specimen.grid.n_nodes(); ++node) {
      // x, y, z of the turned lattice are z, y, -x of the world; its nodes count x from the other end.
      const Index3 at = grid.specimen.grid.node_at(node);
      const std::int64_t there = turned.specimen.grid.node({at[2], at[1], 8 - at[0]});
      worst = std::max({worst, std::abs(found(0, there) - expected(2, node)),
                        std::abs(found(1, there) - expected(1, node)),
                        std::abs(found(2, there) + expected(0, node))});
    }
    EXPECT_LT(worst, 1e-5 * move) << method; // what the relaxers settle to
  }
}

// Analytic: a body that is moved as a whole moves as a whole, stairs or not.
TEST(FibreLatticeAnalytic, AShiftIsAShift) {
  const Scene scene = parse_scene(
      "[specimen]\nshape = \"ellipsoid\"\nlattice = \"fibre\"\ncells = [16, 8, 8]\nspacing = \"1 mm\"\n"
      "material = \"muscle/soleus\"\nfibre = { angle = \"33 deg\", plane = \"xy\" }\n"
      "[[move]]\nwhere = \"x-\"\nby = [\"1 mm\", \"2 mm\", \"3 mm\"]\n[[move]]\nwhere = \"x+\"\nby = [\"1 "
      "mm\", \"2 mm\", \"3 mm\"]\n"
      "[limits]\nfrom = \"given\"\nstretch = 1\ncompress = 1\nshear = 0\n");
  const Answer answer = solve(scene, "limits");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const Specimen& body = scene.specimen;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    if (!body.is_node(body.grid.node_at(node)))
      continue;
    for (std::size_t r = 0; r < 3; ++r) {
      double world = 0;
      for (std::size_t c = 0; c < 3; ++c)
        world += body.placement.direction[r][c] * answer.displacement(static_cast<int>(c), node);
      EXPECT_NEAR(world, 1e-3 * static_cast<double>(r + 1), 1e-9);
    }
  }
}

} // namespace
} // namespace maille::deform
