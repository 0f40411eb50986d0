/// The bytes that plans, answers, bodies and drags count, against what heap and system really gave them.

#include "control/method.hpp"
#include "elastic/elastic_methods.hpp"
#include "lattice/body.hpp"
#include "maille/base/arena.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/link_limits.hpp"
#include "oracle/literal.hpp"
#include "oracle/sweep.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/heap_meter.hpp"
#include "support/kit.hpp"

#include <Eigen/Core>

namespace maille::deform {
namespace {

using test::even_limits;
using test::heap_is_counted;
using test::HeapMeter;
using test::hold;
using test::lattice_box;
using test::move;

/// What counts need not know of: 64 KiB for texts, threads' own bookkeeping and lists of a few entries,
/// and 1 % for what the allocator adds to each array (its head, whole pages, room for alignment).
std::int64_t slack(std::int64_t bytes) {
  return 65536 + bytes / 100;
}

void expect_counts(std::int64_t on_the_heap, std::int64_t counted) {
  EXPECT_LE(on_the_heap, counted + slack(counted));
  EXPECT_GE(on_the_heap, counted - slack(counted));
}

/// A forecast is an upper bound, and no refusal out of caution. @param caution how much more it may be
void expect_foreseen(std::int64_t on_the_heap, std::int64_t forecast, int caution = 2) {
  EXPECT_LE(on_the_heap, forecast + 65536);
  EXPECT_LE(forecast, caution * on_the_heap);
}

/// Twice what was needed; of an elastic answer that its limits leave alone four times: whether they bind is
/// seen in the answer.
int caution_for(const Scene& scene, const Answer& answer) {
  const bool may_bind = (answer.method == "relaxed" && scene.limits_bind_relaxed()) ||
                        (answer.method == "coupled" && scene.limits_bind_coupled());
  return may_bind && answer.algorithm.find("multipliers") == std::string::npos ? 4 : 2;
}

#define SKIP_UNLESS_COUNTED                                                                                  \
  if (!heap_is_counted())                                                                                    \
  GTEST_SKIP() << "allocations cannot be counted here"

/// A question and its name, for messages.
struct Question {
  std::string name;
  Scene scene;
};

Scene box_with_handles(int n_handles) {
  Scene scene = lattice_box({63, 63, 63}, even_limits(1.25, 0.75, 0.25));
  hold(scene, {0, 0, 0});
  for (int k = 0; k < n_handles; ++k)
    move(scene, {7 * k % 64, 31 * k % 64, k % 64}, {0.125, 0.125, 0.125});
  return scene;
}

Scene impossible(Scene scene) {
  for (Prescribed& p : scene.prescribed)
    p.value *= p.held ? 1 : 1 + 100.0 * double(p.node % 7);
  return scene;
}

std::vector<Question> homogeneous_questions() {
  return {{"closed form", box_with_handles(1)},
          {"scans", box_with_handles(300)},
          {"many", box_with_handles(5000)}};
}

std::vector<Question> inhomogeneous_questions() {
  std::vector<Question> questions;
  for (const std::string_view name : named_bodies()) {
    questions.push_back({std::string(name), named_body(name, 48)});
    for (int k = 0; k < 40; ++k)
      move(questions.back().scene, {k, 47 - k, 0}, {0.1, 0.1, 0.1 * (k % 3)});
  }
  return questions;
}

// ---- plans and answers ----

TEST(FootprintContract, APlanIsTheSumOfItsArrays) {
  for (const auto& questions : {homogeneous_questions(), inhomogeneous_questions()})
    for (const Question& question : questions) {
      const Plan plan = plan_limits(question.scene, LinkLimits(question.scene));
      EXPECT_EQ(bytes_of(plan.arrays), plan.bytes);
      for (const ArrayBytes& array : plan.arrays)
        EXPECT_GE(array.bytes, 0) << question.name << " " << array.name;
    }
}

TEST(FootprintContract, AnswersMatchTheHeapAndThePlan) {
  SKIP_UNLESS_COUNTED;
  for (const bool is_homogeneous : {true, false})
    for (const Question& possible : is_homogeneous ? homogeneous_questions() : inhomogeneous_questions())
      for (const bool is_cut : {false, true})
        for (const int threads : {1, 2}) {
          if (is_homogeneous && is_cut)
            continue;
          const Scene scene = is_cut ? impossible(possible.scene) : possible.scene;
          SCOPED_TRACE(possible.name + (is_cut ? " cut" : "") + " threads " + std::to_string(threads));
          Control control;
          control.threads = threads;
          const Plan plan = plan_limits(scene, LinkLimits(scene), threads);
          const HeapMeter heap;
          const Answer answer =
              is_homogeneous ? solve(scene, "limits", control)
                             : solve_by_cheapest_way(scene, control); // in the frame that the plan is for
          EXPECT_TRUE(is_homogeneous ? answer.status == Status::done : answer.algorithm == "tiled wavefront");
          expect_counts(heap.peak(), answer.bytes);
          expect_foreseen(heap.peak(), plan.bytes);
        }
}

/// Small bodies of every dimension.
std::vector<Question> slow_questions() {
  std::vector<Question> questions;
  for (const std::string_view name : named_bodies())
    questions.push_back({std::string(name), named_body(name, 24)});
  questions.push_back({"box", lattice_box({30, 20, 10}, even_limits(1.25, 0.75, 0.25))});
  questions.push_back({"sheet", lattice_box({120, 100}, even_limits(1.25, 0.75, 0.25))});
  questions.push_back({"chain", lattice_box({20000}, even_limits(1.25, 0.75, 0.25))});
  for (std::size_t i = questions.size() - 3; i < questions.size(); ++i) {
    hold(questions[i].scene, {0, 0, 0});
    move(questions[i].scene,
         questions[i].scene.specimen.grid.node_at(questions[i].scene.specimen.grid.n_nodes() / 2),
         {3000, -3000, 3000});
  }
  return questions;
}

/// Asks a method: the heap is within the forecast. @param name  of the question, for the record
Answer expect_forecast(const Scene& scene, const char* method, const std::string& name) {
  SCOPED_TRACE(name + " " + method);
  const std::int64_t needed = bytes_needed(scene, method);
  const HeapMeter heap;
  Answer answer = solve(scene, method);
  EXPECT_TRUE(has_displacement(answer.status)) << answer.message;
  expect_foreseen(heap.peak(), needed, caution_for(scene, answer));
  testing::Test::RecordProperty(name + " " + method,
                                std::to_string(heap.peak()) + " of " + std::to_string(needed));
  return answer;
}

TEST(FootprintContract, ShortestPathsAreForecast) {
  SKIP_UNLESS_COUNTED;
  for (const Question& question : slow_questions())
    for (const bool from_all : {false, true}) {
      const LinkLimits limits(question.scene);
      const Grid& grid = question.scene.specimen.grid;
      std::vector<PathEnd> ends;
      for (std::int64_t node = 0; node < (from_all ? grid.n_nodes() : 1); ++node)
        if (question.scene.specimen.is_node(grid.node_at(node)))
          ends.push_back({node, double(node % 11)});
      const HeapMeter heap;
      shortest_paths(question.scene, limits, 0, ends, PathDirection::from_ends);
      EXPECT_LE(heap.peak(), bytes_of_shortest_paths(grid, std::ssize(ends)) + 65536) << question.name;
    }
}

TEST(FootprintContract, SlowMethodsAreForecast) {
  SKIP_UNLESS_COUNTED;
  for (const Question& question : slow_questions())
    for (const char* method : {"dijkstra", "literal", "sweep", "relaxed"}) {
      Scene scene = question.scene;
      scene.relaxation.sweeps = 5;
      expect_forecast(scene, method, question.name);
    }
}

// Fields of sizes that share large pages badly, well, and not at all.
TEST(FootprintContract, RelaxedIsForecastForFieldsOfAnySize) {
  SKIP_UNLESS_COUNTED;
  for (const Index3& cells : {Index3{31, 31, 31}, {63, 63, 43}, {63, 63, 63}, {63, 63, 99}}) {
    Scene scene = lattice_box({cells[0], cells[1], cells[2]}, even_limits(1.25, 0.75, 0.25));
    scene.limits.from = LimitSource::none;
    hold(scene, {0, 0, 0});
    move(scene, {cells[0], 0, 0}, {1, 0, 0});
    expect_forecast(scene, "relaxed", "nodes along z " + std::to_string(cells[2] + 1));
  }
}

/// A body with a hole, every cell of which has a fibre of its own.
Scene body_of_turning_fibres(LimitSource from) {
  Scene scene = lattice_box({28, 24, 20}, even_limits(1.25, 0.75, 0.25));
  Material& muscle = scene.materials[0];
  muscle.elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 4e3, 0.3, 0.4);
  muscle.limits = scene.limits.given;
  muscle.damage.emplace();
  muscle.damage->stretch = {1.3, 1.5, 1.5};
  const Grid& grid = scene.specimen.grid;
  std::mt19937 lot(1);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    Eigen::Vector3f fibre = Eigen::Vector3f::UnitX();
    for (int a = 0; a < 3; ++a)
      fibre[a] += float(lot()) / float(std::mt19937::max());
    fibre.normalize();
    scene.specimen.fibres.push_back({fibre[0], fibre[1], fibre[2]});
    const Index3 at = grid.cell_at(cell);
    scene.specimen.material_id.push_back(at[0] > 10 && at[1] > 12 ? no_material : 0);
  }
  scene.limits.from = from;
  for (const Index3& at : test::face(scene, 2, false))
    hold(scene, at);
  move(scene, {3, 4, 20}, {2e-4, -1e-4, 3e-4});
  return scene;
}

// Truth: the heap. What such bodies hold beside the lattice (tables for every cell) was once not counted.
TEST(FootprintContract, BodiesWithFibresAreForecast) {
  SKIP_UNLESS_COUNTED;
  for (const LimitSource from : {LimitSource::taut, LimitSource::material, LimitSource::failure})
    for (const char* method : {"dijkstra", "literal", "sweep", "relaxed", "coupled"}) {
      Scene scene = body_of_turning_fibres(from);
      scene.relaxation.sweeps = 5;
      expect_forecast(scene, method, "limits " + std::to_string(int(from)));
    }
}

/// Pressed down in the middle of its upper face, or as a whole, and held at its foot.
Scene pressed(Scene scene, double depth, bool as_a_whole) {
  const Grid& grid = scene.specimen.grid;
  const Index3& n = grid.cells();
  const std::size_t up = std::size_t(scene.dimension()) - 1;
  for (int component = 0; component < scene.dimension(); ++component)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      const auto is_near = [&](std::size_t a) { return std::abs(8 * at[a] - 4 * n[a]) <= n[a]; };
      const bool is_pressed = at[up] == n[up] && (as_a_whole || (is_near(0) && (up == 1 || is_near(1))));
      if (scene.specimen.is_node(at) && (at[up] == 0 || is_pressed))
        scene.prescribed.push_back(
            {node, component, is_pressed && component == int(up) ? -depth * n[up] : 0.0, at[up] == 0});
    }
  return scene;
}

std::vector<Question> elastic_questions() {
  const auto box = [](std::initializer_list<int> cells, LimitSource from, bool is_carved) {
    Scene scene = lattice_box(cells, even_limits(1.25, 0.75, 0.125));
    scene.limits.from = from;
    scene.relaxation.tolerance = 1e-3;
    const Grid& grid = scene.specimen.grid;
    for (std::int64_t cell = 0; is_carved && cell < grid.n_cells(); ++cell) {
      const Index3 at = grid.cell_at(cell);
      const bool is_out = 2 * at[0] > grid.cells()[0] && 2 * at[1] > grid.cells()[1];
      scene.specimen.material_id.push_back(is_out ? no_material : 0);
    }
    return scene;
  };
  std::vector<Question> questions;
  for (const bool is_carved : {false, true}) {
    const std::string of = is_carved ? "carved " : "box ";
    questions.push_back({of + "free", pressed(box({48, 40, 32}, LimitSource::none, is_carved), 0.05, true)});
    questions.push_back(
        {of + "within limits", pressed(box({48, 40, 32}, LimitSource::given, is_carved), 0.125, false)});
    questions.push_back(questions[questions.size() - 2]);
    questions.back().name = of + "with weight";
    questions.back().scene.gravity = {0, 0, -9.81};
  }
  questions.push_back({"slender", pressed(box({12, 12, 200}, LimitSource::none, false), 0.02, true)});
  questions.push_back({"sheet", pressed(box({500, 400}, LimitSource::none, false), 0.05, true)});
  return questions;
}

/// Beside lists that no arena sees (bits, numbers by plane, scratch of threads).
constexpr double share_unseen = 0.08;

TEST(FootprintContract, ElasticMethodsMatchTheHeapAndTheForecast) {
  SKIP_UNLESS_COUNTED;
  for (const Question& question : elastic_questions())
    for (const char* method : {"relaxed", "coupled"}) {
      SCOPED_TRACE(question.name + " " + method);
      const std::int64_t needed = bytes_needed(question.scene, method);
      const HeapMeter heap;
      const Answer answer = solve(question.scene, method);
      ASSERT_TRUE(has_displacement(answer.status)) << answer.message;
      EXPECT_EQ(question.name.find("within limits") != std::string::npos,
                answer.algorithm.find("multipliers") != std::string::npos);
      expect_foreseen(heap.peak(), needed, caution_for(question.scene, answer));
      EXPECT_NEAR(double(answer.bytes), double(heap.peak()), share_unseen * double(heap.peak()) + 65536);
      RecordProperty(question.name + " " + method, std::to_string(heap.peak()) + " of " +
                                                       std::to_string(needed) + ", counted " +
                                                       std::to_string(answer.bytes));
    }
}

// ---- bodies and drags ----

std::vector<Question> drag_questions() {
  std::vector<Question> questions = homogeneous_questions();
  for (Question& question : questions)
    std::erase_if(question.scene.prescribed, [](const Prescribed& p) { return !p.held; });
  for (const std::string_view name : named_bodies())
    questions.push_back({std::string(name), named_body(name, 48)});
  questions.push_back({"sheet", lattice_box({300, 200}, even_limits(1.25, 0.75, 0.25))});
  return questions;
}

TEST(FootprintContract, BodiesAreWhatTheHeapGave) {
  SKIP_UNLESS_COUNTED;
  for (const Question& question : drag_questions()) {
    const HeapMeter heap;
    const Arena arena;
    const Arena::Open open(arena);
    const Body body(question.scene);
    EXPECT_EQ(arena.present(), bytes_of(Body::footprint(question.scene))) << question.name;
    SCOPED_TRACE(question.name);
    expect_counts(heap.live(), arena.present());
  }
}

TEST(FootprintContract, DragsAreWhatTheHeapGaveAtRestAndAfterMoves) {
  SKIP_UNLESS_COUNTED;
  for (const Question& question : drag_questions())
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(question.name + " threads " + std::to_string(threads));
      const LinkLimits limits(question.scene);
      const Grid& grid = question.scene.specimen.grid;
      const HeapMeter heap;
      Drag drag(question.scene, limits, threads);
      expect_foreseen(drag.bytes(), bytes_of(Drag::footprint(question.scene, limits)));
      const auto expect_true = [&](const char* when) {
        SCOPED_TRACE(when);
        expect_counts(heap.live(), drag.bytes());
      };
      expect_true("at rest");
      EXPECT_LE(heap.peak(), drag.bytes() + slack(drag.bytes()));
      drag.move_to(5, {30, -20, 10});
      expect_true("after one move");
      drag.move_to(5, {-30000, 20000, 10000});
      expect_true("far away");
      std::vector<Drag::Move> moves;
      for (int k = 0; k < 20; ++k)
        moves.push_back({grid.node({k, 0, 0}), {-30000, 20000 + 0.01 * k, 10000 + 5.0 * k}});
      drag.move_to(moves);
      expect_true("after moves of many handles");
      const auto is_tiled = [](const std::string& way) { return way == "tiled wavefront"; };
      if (limits.is_homogeneous() !=
          is_tiled(drag.algorithm())) { // else the state was handed over in float64 in between
        EXPECT_LE(heap.peak(), drag.bytes() + slack(drag.bytes()));
      }
    }
}

/// What moves allocate after their first use: nothing. And the largest body that shall fit.

/// Homogeneous and tiled, large enough for two threads; something is held.
std::vector<Question> bodies() {
  std::vector<Question> all{{"box", lattice_box({40, 40, 40}, even_limits(1.25, 0.75, 0.25))},
                            {"sheet", lattice_box({300, 200}, even_limits(1.25, 0.75, 0.25))}};
  for (const std::string_view name : named_bodies())
    all.push_back({std::string(name), named_body(name, 40)});
  for (Question& body : all) {
    body.scene.prescribed.clear();
    hold(body.scene, {0, 0, 0});
  }
  return all;
}

/// There, back, and beyond what the hold permits.
const std::array<Vec3, 4> places{{{1, -0.5, 0.75}, {6, 2, -3}, {0, 0, 0}, {1000, -1000, 1000}}};

TEST(AllocationContract, HandlesAllocateNothingAfterTheirFirstUse) {
  SKIP_UNLESS_COUNTED;
  for (const Question& body : bodies())
    for (const int n_handles : {1, 3, 40})
      for (const int threads : {1, 2}) {
        SCOPED_TRACE(fmt::format("{} threads {} handles {}", body.name, threads, n_handles));
        const LinkLimits limits(body.scene);
        Drag drag(body.scene, limits, threads);
        const Grid& grid = body.scene.specimen.grid;
        std::vector<Drag::Move> moves;
        for (int k = 0; k < n_handles; ++k)
          moves.push_back({grid.node({grid.nodes()[0] - 1, k, 0}), {}});
        std::vector<Vec3> clipped(moves.size());
        for (int round = 0; round < 3; ++round) {
          const HeapMeter heap;
          for (const Vec3& place : places) {
            for (std::size_t k = 0; k < moves.size(); ++k) // the last of them contradict each other
              moves[k].displacement = {place[0] + double(k % 3) * place[0] / 8, place[1], place[2]};
            if (n_handles == 1)
              drag.move_to(moves[0].node, place);
            else
              drag.move_to(moves, clipped);
          }
          if (round > 0)
            EXPECT_EQ(heap.allocations(), 0) << "round " << round;
          else
            EXPECT_GE(heap.allocations(), 1) << "a new handle is stored, and that is seen";
        }
      }
}

TEST(AllocationContract, AHandleOfAHomogeneousBodyNeedsOneMoveOnly) {
  SKIP_UNLESS_COUNTED;
  const Scene scene = bodies().front().scene;
  const LinkLimits limits(scene);
  for (const int threads : {1, 2}) {
    Drag drag(scene, limits, threads);
    drag.move_to(77, {0.1, 0, 0});
    const HeapMeter heap;
    for (const Vec3& place : places) // it has been to none of them
      drag.move_to(77, place);
    EXPECT_EQ(heap.allocations(), 0);
  }
}

TEST(AllocationContract, ABodyOf512CubedNodesIsDraggedWithin2GiB) {
  SKIP_UNLESS_COUNTED;
  constexpr std::int64_t gib = std::int64_t{1} << 30;
  if (const std::int64_t available = available_memory(); available < 3 * gib)
    GTEST_SKIP() << "needs 3 GiB of free memory, there are " << bytes_in_words(double(available));
  Scene scene = lattice_box({511, 511, 511}, even_limits(1.25, 0.75, 0.25));
  hold(scene, {0, 0, 0});
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  const HeapMeter heap;
  Drag drag(scene, limits, 2);
  const Vec3 to{383, -383, 127}; // dyadic; the farthest corner is reached: its slack is 3 * 511 / 4 = 383.25
  EXPECT_FALSE(drag.move_to(grid.node({511, 511, 511}), to).is_cut);
  EXPECT_LE(heap.peak(), 2 * gib);
  EXPECT_LE(drag.bytes(), 2 * gib);
  EXPECT_GE(heap.peak(), 12 * grid.n_nodes()); // it was counted
  std::printf("512^3 nodes: %s at the peak, %.3f bytes a node\n", bytes_in_words(double(heap.peak())).c_str(),
              double(heap.peak()) / double(grid.n_nodes()));
  // Theorem 2: a cone of slope 1/4 along every axis, to the bit.
  for (const Index3& at :
       {Index3{511, 511, 511}, {511, 0, 511}, {300, 200, 100}, {0, 0, 1}, {510, 509, 507}, {256, 256, 256}})
    for (int b = 0; b < 3; ++b) {
      const double by = to[std::size_t(b)], drop = 0.25 * (3 * 511 - at[0] - at[1] - at[2]);
      EXPECT_EQ(drag.displacement(b, grid.node(at)), std::copysign(std::max(0.0, std::abs(by) - drop), by));
    }
}

} // namespace
} // namespace maille::deform
