#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::Pose;
using deform::RigidMotion;
using deform::RigidShape;
using deform::RigidWorld;
using deform::World;
using Eigen::Vector3d;

class Dice {
public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  Vector3d direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
  }
  Pose pose(const Vector3d& middle, const Vector3d& size, bool is_turned) {
    Pose pose;
    if (is_turned)
      pose.rotation = Eigen::AngleAxisd(between(0, std::numbers::pi), direction()).toRotationMatrix();
    pose.position = middle - pose.rotation * (0.5 * size);
    return pose;
  }

private:
  std::mt19937 random_;
};

/// A box as geometry knows it: no voxel, cell or map.
struct Plate {
  Pose pose;
  Vector3d size;

  Vector3d within(const Vector3d& x) const { return pose.rotation.transpose() * (x - pose.position); }
  double depth(const Vector3d& x) const {
    const Vector3d at = within(x);
    return std::min(at.minCoeff(), (size - at).minCoeff());
  }
  /// Whether a straight way leads through both large faces, no nearer to their edges than `edge`.
  bool is_crossed(const Vector3d& from, const Vector3d& to, double edge) const {
    const Vector3d a = within(from), b = within(to);
    if ((a[2] < 0) == (b[2] < 0) || (a[2] < size[2]) == (b[2] < size[2]))
      return false;
    for (const double face : {0.0, size[2]}) {
      const Vector3d x = a + (face - a[2]) / (b[2] - a[2]) * (b - a);
      for (const int axis : {0, 1})
        if (x[axis] < edge || x[axis] > size[axis] - edge)
          return false;
    }
    return true;
  }
};

RigidShape solid(const Index3& size, double spacing) {
  return {
      size,
      {spacing, spacing, spacing},
      std::vector<std::uint8_t>(static_cast<std::size_t>(std::int64_t{1} * size[0] * size[1] * size[2]), 1)};
}

/// Paths of a tip, or of the plate, in one world. @return how often matter came into matter
std::int64_t paths_at_a_plate(unsigned seed, int n_paths, std::int64_t& contacts) {
  Dice dice(seed);
  const double half_diagonal = 0.5 * std::sqrt(3.0), edge = 1.8;
  const double spacing = std::array{0.25, 0.4, 0.7, 1.0, 1.0, 1.5, 2.0, 4.0}[seed % 8];
  const double of_tip = std::array{0.25, 0.7, 1.0, 1.3, 4.0}[seed / 8 % 5];
  const int thick = 1 + static_cast<int>(seed % 3), wide = static_cast<int>(std::ceil(12 / spacing));
  const Vector3d middle = Vector3d::Constant(24) + 0.5 * dice.direction(),
                 tip_size = Vector3d::Constant(of_tip);
  Plate plate;
  plate.size = Vector3d(wide, wide, thick) * spacing;
  plate.pose = dice.pose(middle, plate.size, seed % 5 != 0);
  RigidWorld world({48, 48, 48}, {1, 1, 1});
  const int of_plate = *world.add(solid({wide, wide, thick}, spacing), plate.pose).object;
  std::optional<int> tip;
  while (!tip)
    tip =
        world
            .add(solid({1, 1, 1}, of_tip), dice.pose(middle + 12 * dice.direction(), tip_size, seed % 2 == 0))
            .object;
  const auto middle_of_tip = [&] {
    return Vector3d(world.pose(*tip).position + world.pose(*tip).rotation * (0.5 * tip_size));
  };
  std::int64_t n = 0;
  for (int path = 0; path < n_paths; ++path) {
    const Vector3d from = middle_of_tip();
    const Vector3d aim =
        plate.pose.position +
        plate.pose.rotation * plate.size.cwiseProduct(Vector3d(dice.between(0.1, 0.9), dice.between(0.1, 0.9),
                                                               dice.between(0, 1)));
    RigidMotion motion;
    motion.by = path % 2 == 0 ? Vector3d((aim - from) * dice.between(1, 3))
                              : Vector3d(dice.between(2, 12) * dice.direction());
    const bool moves_plate = path % 6 == 5;
    if (moves_plate)
      motion.by *= -std::min(1.0, 6 / motion.by.norm());
    const Plate before = plate;
    const auto result = world.move(moves_plate ? of_plate : *tip, motion);
    contacts += static_cast<std::int64_t>(result.contacts.size());
    plate.pose = world.pose(of_plate);
    const Vector3d to = middle_of_tip(),
                   seen = moves_plate ? Vector3d(from - result.fraction * motion.by) : to;
    n += before.is_crossed(from, seen, edge) || plate.depth(to) > half_diagonal + 1e-6;
  }
  return n;
}

/// A C, in three dimensions a channel, whose arms are some cells apart.
World channel(int dimension, const char* method, int gap) {
  WorldObject object;
  object.name = "c";
  object.kind = ObjectKind::deformable;
  Scene& scene = object.scene;
  scene.specimen.shape = "rows";
  const Index3 size{dimension == 3 ? 7 : 10, gap + 4, dimension == 3 ? 2 : 1};
  scene.specimen.grid = Grid(dimension, size, {1, 1, 1});
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    scene.specimen.material_id.push_back(at[0] < 2 || at[1] < 2 || at[1] >= gap + 2 ? 0 : no_material);
  }
  Material material;
  material.name = "soft";
  material.elasticity = ElasticConstants::isotropic(1e4, 0.3);
  scene.materials = {material};
  if (std::string_view(method) == "limits") {
    scene.limits.from = LimitSource::given;
    scene.limits.given.stretch.fill(1.5);
    scene.limits.given.compress.fill(0.6);
    for (auto& row : scene.limits.given.shear)
      row.fill(0.9);
  }
  for (int component = 0; component < dimension; ++component)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (grid.node_at(node)[0] == 0)
        scene.prescribed.push_back({node, component, 0, true});
  object.position = {8.5, 8.5, dimension == 3 ? 6.5 : 0};
  WorldScene world;
  world.dimension = dimension;
  world.method = method;
  world.cells = {28, 28, dimension == 3 ? 16 : 1};
  world.objects = {object};
  return World(world);
}

/// Parts of one arm's skin that pass through the other arm's: every segment against every segment in two
/// dimensions, every edge of a triangle against every triangle in three.
class SkinOracle {
public:
  explicit SkinOracle(const World& world) : world_(world), body_(world.scene().objects[0].scene.specimen) {
    const Grid& grid = body_.grid;
    const int d = grid.dimension();
    const auto is_matter = [&](const Index3& at) {
      return grid.has_cell(at) && body_.is_matter(grid.cell(at));
    };
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
      for (std::size_t a = 0; a < static_cast<std::size_t>(d); ++a)
        for (const int side : {0, 1}) {
          const Index3 at = grid.cell_at(cell);
          Index3 beside = at;
          beside[a] += 2 * side - 1;
          if (!is_matter(at) || is_matter(beside) || at[0] < 2)
            continue;
          const bool is_upper = at[1] >= 2;
          const std::size_t b = (a + 1) % static_cast<std::size_t>(d), c = (a + 2) % 3;
          Index3 p = at;
          p[a] += side;
          Index3 q = p, r = p, s = p;
          ++q[b], ++s[b];
          if (d == 2) {
            parts_[is_upper].push_back({grid.node(p), grid.node(q), -1});
            continue;
          }
          ++r[c], ++s[c];
          parts_[is_upper].push_back({grid.node(p), grid.node(q), grid.node(s)});
          parts_[is_upper].push_back({grid.node(p), grid.node(s), grid.node(r)});
        }
  }
  bool does_cross() const {
    std::array<std::vector<std::array<Vector3d, 3>>, 2> at;
    for (std::size_t arm = 0; arm < 2; ++arm)
      for (const Part& part : parts_[arm])
        at[arm].push_back({place(part[0]), place(part[1]), place(part[2] < 0 ? part[1] : part[2])});
    for (const auto& one : at[0])
      for (const auto& other : at[1]) {
        if (!are_near(one, other))
          continue;
        if (world_.scene().dimension == 2 ? segments(one, other)
                                          : triangles(one, other) || triangles(other, one))
          return true;
      }
    return false;
  }

private:
  using Part = std::array<std::int64_t, 3>;
  Vector3d place(std::int64_t node) const { return world_.position(0, node); }
  static bool are_near(const std::array<Vector3d, 3>& a, const std::array<Vector3d, 3>& b) {
    for (int k = 0; k < 3; ++k) {
      const auto [low_a, high_a] = std::minmax({a[0][k], a[1][k], a[2][k]});
      const auto [low_b, high_b] = std::minmax({b[0][k], b[1][k], b[2][k]});
      if (low_a > high_b || low_b > high_a)
        return false;
    }
    return true;
  }
  static double side(const Vector3d& p, const Vector3d& q, const Vector3d& r) {
    return (q - p).cross(r - p)[2];
  }
  static bool segments(const std::array<Vector3d, 3>& a, const std::array<Vector3d, 3>& b) {
    return side(a[0], a[1], b[0]) * side(a[0], a[1], b[1]) < 0 &&
           side(b[0], b[1], a[0]) * side(b[0], b[1], a[1]) < 0;
  }
  /// Whether an edge of the first passes through the second, by signed volumes.
  static bool triangles(const std::array<Vector3d, 3>& a, const std::array<Vector3d, 3>& b) {
    const auto volume = [](const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s) {
      return (q - p).cross(r - p).dot(s - p);
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d &p = a[i], &q = a[(i + 1) % 3];
      if (volume(b[0], b[1], b[2], p) * volume(b[0], b[1], b[2], q) >= 0)
        continue;
      const double u = volume(p, q, b[0], b[1]), v = volume(p, q, b[1], b[2]), w = volume(p, q, b[2], b[0]);
      if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0))
        return true;
    }
    return false;
  }

  const World& world_;
  const Specimen& body_;
  std::array<std::vector<Part>, 2> parts_; ///< of the lower and the upper arm
};

/// Drags of an arm's tip, or of one node, at random. @return after how many the skin crosses itself
std::int64_t drag_at_random(int dimension, const char* method, unsigned seed, int n_drags,
                            std::int64_t& met) {
  Dice dice(seed);
  World world = channel(dimension, method, 1 + static_cast<int>(seed % 4));
  const SkinOracle oracle(world);
  const Grid& grid = world.scene().objects[0].scene.specimen.grid;
  std::int64_t n = 0;
  for (int drag = 0; drag < n_drags; ++drag) {
    Drive drive;
    const bool is_upper = dice.below(2) == 0;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      if (at[0] >= grid.nodes()[0] - 2 && (is_upper ? at[1] >= grid.nodes()[1] - 3 : at[1] <= 2))
        drive.nodes.push_back(node);
    }
    for (int a = 0; a < dimension; ++a)
      drive.motion.by[a] = dice.between(-3, 3);
    deform::FrameBudget budget;
    budget.rounds = 40;
    const auto result = world.advance({&drive, 1}, budget);
    met += std::ranges::any_of(result.contacts, [](const auto& contact) { return contact.other == 0; });
    n += oracle.does_cross();
    if (dice.below(3) == 0)
      world.release(0);
  }
  return n;
}

} // namespace

void report_matter(bool quick, BenchReport& report) {
  const auto seconds_since = [](auto start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const auto row = [&](const std::string& what, std::int64_t n, double seconds, const std::string& note) {
    report.add({{"what", what},
                {"voxels", n},
                {"microseconds", 1e6 * seconds},
                {"ns_per_voxel", 1e9 * seconds / static_cast<double>(n)},
                {"note", note}});
  };
  auto start = std::chrono::steady_clock::now();
  const int worlds = quick ? 40 : 2000, paths = 50;
  std::int64_t inside = 0, contacts = 0;
  for (int seed = 0; seed < worlds; ++seed)
    inside += paths_at_a_plate(static_cast<unsigned>(seed), paths, contacts);
  row(fmt::format("{} random paths of a tip at turned plates", worlds * paths), worlds * paths,
      seconds_since(start), fmt::format("a path in place of a voxel; {} contacts", contacts));
  report.checks.push_back({"matter_penetrations", static_cast<double>(inside), "0",
                           "plates of 1 to 3 voxels, spacings of 1/4 to 4 cells: a tip's middle deeper than "
                           "half a cell's diagonal, or a way through, by the plate's box"});
  start = std::chrono::steady_clock::now();
  struct Kind {
    int dimension;
    const char* method;
    int worlds, drags;
  };
  std::int64_t crossings = 0, met = 0, drags = 0;
  for (const Kind& kind : {Kind{2, "limits", 100, 60}, Kind{2, "coupled", 40, 50}, Kind{3, "limits", 40, 50}})
    for (int seed = 0; seed < (quick ? 2 : kind.worlds); ++seed) {
      const int n = quick ? 10 : kind.drags;
      drags += n;
      crossings += drag_at_random(kind.dimension, kind.method, static_cast<unsigned>(seed), n, met);
    }
  row(fmt::format("{} random drags of the arms of a C", drags), drags, seconds_since(start),
      fmt::format("a drag in place of a voxel; the arms had met after {}", met));
  report.checks.push_back({"self_crossings", static_cast<double>(crossings), "0",
                           "drags after which an arm's skin passes through the other's: segments in 2D, "
                           "triangles in 3D, each against each"});
}

} // namespace maille::lab
