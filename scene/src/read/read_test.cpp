#include "maille/base/vectors.hpp"
#include "read/reader.hpp"
#include "time_course.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace maille::reader {

namespace {

struct TestRequest {
  StandardTest test;
  bool is_sliding = false;
  double radius = 0; ///< 0: a quarter of the face's shorter side
  double square = 0; ///< squared distance of the outermost nodes of a punch from its centre [m^2]
};

constexpr std::string_view axis_letters = "xyz";

/// One of the scene's axes; nothing and a fault for other words.
std::optional<int> read_axis(TableReader& table, const char* key, int dimension) {
  std::vector<std::string_view> letters;
  for (std::size_t a = 0; a < n_axes(dimension); ++a)
    letters.push_back(axis_letters.substr(a, 1));
  const auto letter = table.choice(key, letters);
  return letter ? std::optional(static_cast<int>(axis_letters.find(*letter))) : std::nullopt;
}

/// Reports keys that the kind does not use as faults.
void refuse_keys_of_others(TableReader& table, TestKind kind) {
  const bool has_second_axis = kind == TestKind::shear || kind == TestKind::bend;
  for (const auto& [key, is_known, of] : {std::tuple("ends", kind == TestKind::axial, "\"axial\""),
                                          {"along", has_second_axis, "\"shear\" or \"bend\""},
                                          {"radius", kind == TestKind::indent, "\"indent\""},
                                          {"failure", kind == TestKind::axial, "\"axial\""}})
    if (!is_known)
      table.refuse(key, fmt::format("no such key unless kind = {}", of));
}

std::optional<TestRequest> read_request(TableReader& table, int dimension) {
  TestRequest request;
  StandardTest& test = request.test;
  const bool has_kind = table.read("kind", test.kind);
  const auto axis = read_axis(table, "axis", dimension);
  const auto strain = table.number("strain");
  const auto along = read_axis(table, "along", dimension);
  table.read("radius", request.radius);
  request.is_sliding = table.choice("ends") == "sliding";
  test.asks_for_failure = table.choice("failure").has_value();
  if (!has_kind || !axis || !table.has("strain"))
    return std::nullopt;
  test.axis = *axis;
  test.strain = strain.value_or(0);
  refuse_keys_of_others(table, test.kind);
  const bool is_line = dimension == 1;
  if (is_line && test.kind != TestKind::axial && test.kind != TestKind::confined)
    table.fault("kind", "\"axial\" in a scene of one dimension");
  if (strain == 0.0)
    table.fault("strain", "a strain that is not 0, of 1000 % at most");
  test.along = (test.axis + 1) % static_cast<int>(n_axes(dimension));
  if (along) {
    test.along = *along;
    if (test.along == test.axis)
      table.fault("along", "an axis across the test's own");
  }
  if (test.kind == TestKind::indent && test.strain < 0)
    table.fault("strain", "a depth above 0: how far the punch goes in, over the length");
  return request;
}

/// Lengths of the body's bounding box.
Vec3 size_of(const Grid& grid) {
  Vec3 size{};
  for (int a = 0; a < grid.dimension(); ++a)
    size[a] = grid.cells()[a] * grid.spacing()[a];
  return size;
}

/// Mean spacing across a test's axis.
double spacing_across(const Grid& grid, int axis) {
  const double area = face_area(grid, axis);
  return grid.dimension() == 3 ? std::sqrt(area) : area;
}

/// Extent of a punch beyond its outermost moved nodes, in spacings. Under its edge the displacement grows as
/// the square root of the distance, and the sequence of nodes with transform z (1 - z)^(-3/2), z = exp(i k
/// h), is that square root starting at x = h - 3/4 h (Wiener and Hopf): a quarter of a spacing. The rest of
/// the lattice's symbol at the surface is smooth at k = 0 and contributes little; for trilinear elements, (1
/// - cos k) (5 + cos k), it subtracts 0.046.
constexpr double beyond_last_node = 0.25;

/// Squared distance from the centre of the face [m^2].
double square_from_middle(const Grid& grid, const StandardTest& test, const Index3& node) {
  double square = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const std::size_t a = axis;
    const double off = axis == test.axis ? 0 : grid.spacing()[a] * (node[a] - 0.5 * grid.cells()[a]);
    square += off * off;
  }
  return square;
}

/// Selects the nodes whose round punch is nearest to the requested one. Every node has its own cell, half a
/// spacing to each side, which is more than the extent of the punch beyond it.
void span_punch(const Grid& grid, TestRequest& request) {
  const std::size_t axis = request.test.axis;
  const double h = spacing_across(grid, request.test.axis), asked = request.test.radius;
  std::vector<double> squares;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (const Index3 at = grid.node_at(node); at[axis] == grid.cells()[axis])
      squares.push_back(square_from_middle(grid, request.test, at));
  std::ranges::sort(squares);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const double beyond = squares[i] * (1 + 1e-9), cells = static_cast<double>(i + 1);
    if (i + 1 < squares.size() && squares[i + 1] <= beyond)
      continue;
    const double of_cells = grid.dimension() == 3 ? std::sqrt(cells / std::numbers::pi) : cells / 2,
                 radius = h * (of_cells - (0.5 - beyond_last_node));
    if (std::abs(radius - asked) >= nearest)
      continue;
    nearest = std::abs(radius - asked);
    request.test.radius = radius;
    request.square = beyond;
  }
}

void measure(const Grid& grid, TestRequest& request) {
  StandardTest& test = request.test;
  const Vec3 size = size_of(grid);
  const int axis = test.axis, along = test.along;
  test.length = size[axis];
  test.area = 1;
  double shorter = std::numeric_limits<double>::infinity();
  for (int a = 0; a < grid.dimension(); ++a)
    if (a != axis) {
      test.area *= size[a];
      shorter = std::min(shorter, size[a]);
    }
  test.second_moment = test.area * size[along] * size[along] / 12;
  if (test.kind == TestKind::indent)
    test.radius = request.radius > 0 ? request.radius : shorter / 4;
}

/// The conditions of a test, expressed as holds and moves.
class TestConditions {
public:
  TestConditions(const TestRequest& request, const Asked& asked, const Specimen& body, FaultList& faults)
      : request_(request), test_(request.test), asked_(asked), body_(body), faults_(faults) {}

  std::vector<Condition> made();

private:
  struct Place {
    std::string name; ///< name in results
    Region region;
  };

  std::size_t d() const { return static_cast<std::size_t>(body_.grid.dimension()); }
  std::array<bool, 3> only(int axis) const {
    std::array<bool, 3> axes{};
    axes[axis] = true;
    return axes;
  }
  Place face(int axis, bool upper) const {
    const std::string name{axis_letters[axis], upper ? '+' : '-'};
    return {name, *Region::face(name, body_.grid.dimension())};
  }
  void hold(const Place& place, const std::array<bool, 3>& axes) {
    Condition condition;
    condition.held = true;
    condition.axes = axes;
    add(std::move(condition), place);
  }
  void move(const Place& place, const std::array<bool, 3>& axes, const Vec3& by,
            std::optional<Turn> turn = {}) {
    Condition condition;
    condition.axes = axes;
    condition.by = by;
    condition.turn = std::move(turn);
    add(std::move(condition), place);
  }
  void add(Condition condition, const Place& place) {
    condition.asked = {asked_.key, asked_.line, place.name};
    add_condition(std::move(condition), place.region, condition.asked, false, body_, conditions_, faults_);
  }
  Vec3 shift(int axis, double length) const {
    Vec3 by{};
    by[axis] = length;
    return by;
  }
  Vec3 middle_of_upper_face() const;
  void pin_against_sliding();
  void bend();
  Place patch() const;
  void press();

  const TestRequest& request_;
  const StandardTest& test_;
  const Asked& asked_;
  const Specimen& body_;
  FaultList& faults_;
  std::vector<Condition> conditions_;
};

Vec3 TestConditions::middle_of_upper_face() const {
  const Vec3 low = body_.position({0, 0, 0}), size = size_of(body_.grid);
  Vec3 middle{};
  for (std::size_t a = 0; a < 3; ++a)
    middle[a] = low[a] + (a == static_cast<std::size_t>(test_.axis) ? 1 : 0.5) * size[a];
  return middle;
}

/// Fixes one node of the lower face, and one component of a distant one: enough to prevent rigid motion of a
/// body that slides between plates, without a force.
void TestConditions::pin_against_sliding() {
  const std::vector<std::int64_t> nodes = face(test_.axis, false).region.nodes(body_);
  if (nodes.empty())
    return; // a fault already
  Vec3 middle = middle_of_upper_face();
  const auto farness = [&](std::int64_t node, const Vec3& from) {
    const Vec3 x = body_.position(body_.grid.node_at(node));
    double square = 0;
    for (std::size_t a = 0; a < 3; ++a)
      square += a == static_cast<std::size_t>(test_.axis) ? 0 : (x[a] - from[a]) * (x[a] - from[a]);
    return square;
  };
  const std::int64_t pinned =
      *std::ranges::min_element(nodes, {}, [&](std::int64_t node) { return farness(node, middle); });
  std::array<bool, 3> across{};
  for (std::size_t a = 0; a < d(); ++a)
    across[a] = a != static_cast<std::size_t>(test_.axis);
  hold({"a pinned node", Region::numbered({pinned})}, across);
  if (d() < 3)
    return;
  const Vec3 place = body_.position(body_.grid.node_at(pinned));
  const std::size_t second = test_.along;
  // Farthest along `along`, so that a rotation would move it sideways.
  const std::int64_t guide = *std::ranges::max_element(nodes, {}, [&](std::int64_t node) {
    return std::abs(body_.position(body_.grid.node_at(node))[second] - place[second]);
  });
  hold({"a guided node", Region::numbered({guide})}, only(3 - test_.axis - test_.along));
}

/// Bends to an arc: no shear, constant moment.
void TestConditions::bend() {
  Turn turn;
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(test_.axis).cross(Eigen::Vector3d::Unit(test_.along));
  turn.axis = {axis[0], axis[1], axis[2]};
  turn.angle = test_.angle();
  turn.about = middle_of_upper_face();
  move(face(test_.axis, true), all_axes(body_.grid.dimension()), end_of_arc(test_, 1), turn);
}

/// The nodes of the upper face under the indenter.
TestConditions::Place TestConditions::patch() const {
  std::vector<std::int64_t> under;
  for (const std::int64_t node : face(test_.axis, true).region.nodes(body_))
    if (square_from_middle(body_.grid, test_, body_.grid.node_at(node)) <= request_.square)
      under.push_back(node);
  return {"punch", Region::numbered(std::move(under))};
}

void TestConditions::press() {
  const Place punch = patch();
  if (punch.region.nodes(body_).empty())
    faults_.add(asked_.line, asked_.key + ".axis",
                "matter under the punch, in the middle of the upper face of the bounding box", "none");
  else
    move(punch, only(test_.axis), shift(test_.axis, -test_.displacement()));
}

std::vector<Condition> TestConditions::made() {
  const auto all = all_axes(body_.grid.dimension());
  const Place lower = face(test_.axis, false), upper = face(test_.axis, true);
  const bool slides = request_.is_sliding || test_.kind == TestKind::confined;
  hold(lower, slides ? only(test_.axis) : all);
  if (request_.is_sliding)
    pin_against_sliding();
  for (std::size_t a = 0; test_.kind == TestKind::confined && a < d(); ++a)
    for (const bool is_upper : {false, true})
      if (a != static_cast<std::size_t>(test_.axis))
        hold(face(static_cast<int>(a), is_upper), only(static_cast<int>(a)));
  switch (test_.kind) {
  case TestKind::axial:
  case TestKind::confined:
    move(upper, slides ? only(test_.axis) : all, shift(test_.axis, test_.displacement()));
    break;
  case TestKind::shear:
    move(upper, all, shift(test_.along, test_.displacement()));
    break;
  case TestKind::bend:
    bend();
    break;
  case TestKind::indent:
    press();
    break;
  }
  return std::move(conditions_);
}

/// Checks that need the body's size. @return false, and a fault, if the test does not fit
bool fits_body(const Scene& scene, const TestRequest& request, const Asked& asked, FaultList& faults) {
  const StandardTest& test = request.test;
  // Small strain excludes large rotations: 2 % too soft at this angle, wrong sign at a right angle.
  const double largest = scene.strain == Strain::finite ? largest_turn : 0.2;
  if (test.kind == TestKind::bend && !(std::abs(test.angle()) <= largest)) {
    faults.add(asked.line, asked.key + ".strain",
               fmt::format("an end that turns by {:.4g} rad at most (a strain of {:.3g} %){}", largest,
                           100 * std::abs(test.strain / test.angle()) * largest,
                           largest < 1 ? ", or [relaxation] frame = \"blocks\"" : ""),
               fmt::format("{:.4g} rad", test.angle()));
    return false;
  }
  if (test.kind != TestKind::indent)
    return true;
  double cell = 0, side = std::numeric_limits<double>::infinity();
  for (int a = 0; a < scene.dimension(); ++a)
    if (a != test.axis) {
      cell = std::max(cell, scene.specimen.grid.spacing()[a]);
      side = std::min(side, size_of(scene.specimen.grid)[a]);
    }
  if (cell > side / 2)
    faults.add(asked.line, asked.key, "a body of two cells across and more under a punch",
               fmt::format("{:.4g} m, and cells of {:.4g} m", side, cell));
  else if (test.radius < cell || test.radius > side / 2)
    faults.add(asked.line, asked.key + ".radius",
               fmt::format("a punch from one cell to the whole face: {:.4g} m to {:.4g} m", cell, side / 2),
               fmt::format("{:.4g} m", test.radius));
  return test.radius >= cell && test.radius <= side / 2;
}

void check_failure_is_known(const Scene& scene, const Asked& asked, FaultList& faults) {
  for (const Material& material : scene.materials)
    if (!material.elasticity.is_isotropic())
      faults.add(asked.line, asked.key + ".failure", "isotropic materials, for which the criterion is made",
                 material.name);
}

} // namespace

std::vector<Condition> read_test(TableReader& root, Scene& scene, bool has_body) {
  auto table = root.open("test");
  if (!table)
    return {};
  for (const char* key : {"hold", "move"})
    if (root.has(key))
      root.fault(key, "no holds and moves beside a [test], which sets them", fmt::format("[[{}]]", key));
  auto request = read_request(*table, scene.dimension());
  table->finish();
  if (!request || !has_body || !root.faults().empty())
    return {};
  measure(scene.specimen.grid, *request);
  const Asked asked{table->path(), table->line(), "[test]"};
  if (request->test.asks_for_failure)
    check_failure_is_known(scene, asked, root.faults());
  if (!fits_body(scene, *request, asked, root.faults()))
    return {};
  if (request->test.kind == TestKind::indent)
    span_punch(scene.specimen.grid, *request);
  scene.test = request->test;
  return TestConditions(*request, asked, scene.specimen, root.faults()).made();
}

} // namespace maille::reader
