#include "bench/anatomy/anatomy.hpp"

#include "maille/deform/solve.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <stdexcept>

namespace maille::studies {

namespace {

constexpr double mm = 1e-3;

/// A scene and its image in a folder of their own.
class Files {
public:
  Scene read(const Image& image, const std::string& text) const {
    write_nifti(image, folder_.path() / "body.nii");
    std::ofstream(folder_.path() / "scene.toml") << text;
    return read_scene(folder_.path() / "scene.toml");
  }

private:
  WorkFolder folder_{"maille"};
};

Answer solved(Scene scene, double tolerance, const Control& control) {
  scene.relaxation.tolerance = tolerance;
  Answer answer = deform::solve(scene, Method::coupled, control);
  if (answer.status == Status::interrupted)
    throw BenchStopped();
  if (answer.status != Status::done)
    throw std::runtime_error("bench anatomy: coupled gave no answer: " + answer.message);
  return answer;
}

/// Voxels of 1 mm from the origin of a world in RAS, with the values that a function has at their middles, in
/// voxels.
Image image_of(const Index3& size, const std::function<double(const Vec3&)>& value) {
  Image image;
  image.info.size = size;
  image.info.spacing = {mm, mm, mm};
  image.info.origin = {mm / 2, mm / 2, mm / 2};
  image.info.world = WorldAxes::ras;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        image.values.push_back(static_cast<float>(value({i + 0.5, j + 0.5, k + 0.5})));
  return image;
}

// ---- one scene, its image stored in every way ------------------------------------------------------------

/// The same voxels at the same places, axes in another order, some backwards.
Image stored(const Image& image, const std::array<std::size_t, 3>& axis, unsigned flips) {
  Image other;
  other.info = image.info;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool is_flipped = flips >> a & 1;
    other.info.size[a] = image.info.size[axis[a]];
    other.info.spacing[a] = image.info.spacing[axis[a]];
    for (std::size_t r = 0; r < 3; ++r) {
      const double along = image.info.direction[r][axis[a]];
      other.info.direction[r][a] = is_flipped ? -along : along;
      if (is_flipped)
        other.info.origin[r] += along * other.info.spacing[a] * (other.info.size[a] - 1);
    }
  }
  for (int k = 0; k < other.info.size[2]; ++k)
    for (int j = 0; j < other.info.size[1]; ++j)
      for (int i = 0; i < other.info.size[0]; ++i) {
        const Index3 at{i, j, k};
        Index3 of{};
        for (std::size_t a = 0; a < 3; ++a)
          of[axis[a]] = flips >> a & 1 ? other.info.size[a] - 1 - at[a] : at[a];
        const Index3& n = image.info.size;
        other.values.push_back(image.values[static_cast<std::size_t>(
            of[0] + std::int64_t{n[0]} * (of[1] + std::int64_t{n[1]} * of[2]))]);
      }
  return other;
}

constexpr const char* leg = R"([specimen]
shape = "image"
image = "body.nii"
labels = { 17 = { youngs_modulus = "30 kPa", poisson_ratio = 0.4 }, 30 = { youngs_modulus = "90 kPa", poisson_ratio = 0.3 } }

[[hold]]
where = { label = 30, end = "proximal", depth = "3 mm" }

[[load]]
where = { label = 17, end = "distal", depth = "3 mm" }
frame = "ras"
force = ["10 mN", 0, "-20 mN"]
)";

/// A muscle beside a bone that go down together, slightly askew.
double label_at(const Vec3& x) {
  const double bone = std::hypot(x[0] - 4, x[1] - 4 - 0.05 * x[2]), muscle = std::hypot(x[0] - 8, x[1] - 5);
  return bone < 2.6 && x[2] > 2 ? 30 : muscle < 3.1 && x[2] > 1 && x[2] < 13 ? 17 : 0;
}

/// Displacements in the world, by the place of the node in it.
class InWorld {
public:
  InWorld(const Scene& scene, const Answer& answer) : body_(scene.specimen), answer_(answer) {}

  /// The largest difference to another answer, and the largest displacement [m].
  std::pair<double, double> difference(const InWorld& other) const {
    double apart = 0, largest = 0;
    for (std::int64_t node = 0; node < body_.grid.n_nodes(); ++node) {
      const Index3 at = body_.grid.node_at(node);
      if (!body_.is_node(at))
        continue;
      const Vec3 here = displacement(node),
                 there =
                     other.displacement(other.node_at(point_in_world(body_.placement, body_.position(at))));
      apart = std::max(apart, std::hypot(here[0] - there[0], here[1] - there[1], here[2] - there[2]));
      largest = std::max(largest, std::hypot(here[0], here[1], here[2]));
    }
    return {apart, largest};
  }

private:
  Vec3 displacement(std::int64_t node) const {
    return to_world(body_.placement, answer_.displacement.at(node));
  }
  std::int64_t node_at(const Vec3& world) const {
    const Vec3 x = point_in_object(body_.placement, world);
    Index3 at{};
    for (std::size_t a = 0; a < 3; ++a)
      at[a] = std::clamp(static_cast<int>(std::lround((x[a] - body_.origin[a]) / body_.grid.spacing()[a])), 0,
                         body_.grid.nodes()[a] - 1);
    return body_.grid.node(at);
  }

  const Specimen& body_;
  const Answer& answer_;
};

double orientation_difference(const BenchOptions& options, BenchReport& report) {
  const Files files;
  double worst = 0;
  for (const bool is_oblique : {false, true}) {
    Image image = image_of({13, 11, 15}, label_at);
    if (is_oblique) {
      const double c = std::cos(0.3), s = std::sin(0.3), d = std::cos(0.2), e = std::sin(0.2);
      image.info.direction = {{{c, -s * d, s * e}, {s, c * d, -c * e}, {0, e, d}}};
    }
    const Scene first_scene = files.read(image, leg);
    const Answer first = solved(first_scene, 1e-8, report.one_thread());
    double largest = 0;
    int n = 0;
    std::array<std::size_t, 3> axis{0, 1, 2};
    do
      for (unsigned flips = 0; flips < (options.quick ? 2U : 8U); ++flips, ++n) {
        const Scene scene = files.read(stored(image, axis, flips), leg);
        const Answer answer = solved(scene, 1e-8, report.one_thread());
        const auto [apart, size] = InWorld(first_scene, first).difference(InWorld(scene, answer));
        largest = std::max(largest, apart / size);
      }
    while (std::ranges::next_permutation(axis).found);
    report.add({{"case", is_oblique ? "orientations, oblique" : "orientations"},
                {"images", n},
                {"cells", first_scene.specimen.n_matter_cells()},
                {"largest_difference", largest}});
    worst = std::max(worst, largest);
  }
  return worst;
}

// ---- balls, and holes in balls and tubes twice as wide ---------------------------------------------------

constexpr double E = 10e3, nu = 0.3, pressure = 100;

double sphere_pressure_error(BenchReport& report) {
  const Files files;
  const auto ball = [](const Vec3& x) { return std::hypot(x[0] - 8, x[1] - 8, x[2] - 8) <= 8 ? 1.0 : 0.0; };
  const Scene scene = files.read(image_of({16, 16, 16}, ball), R"([specimen]
shape = "image"
image = "body.nii"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = { box = [["8 mm", "8 mm", "8 mm"], ["8 mm", "8 mm", "8 mm"]] }
[[hold]]
where = { box = [["9 mm", "8 mm", "8 mm"], ["9 mm", "8 mm", "8 mm"]] }
axes = "yz"
[[hold]]
where = { box = [["8 mm", "9 mm", "8 mm"], ["8 mm", "9 mm", "8 mm"]] }
axes = "z"
[[load]]
where = { sphere = { centre = ["8 mm", "8 mm", "8 mm"], radius = "20 mm" } }
pressure = "100 Pa"
)");
  const Answer answer = solved(scene, 1e-8, report.one_thread());
  double apart = 0, largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    if (!scene.specimen.is_node(at))
      continue;
    const Vec3 x = scene.specimen.position(at), u = answer.displacement.at(node);
    double difference = 0, size = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double expected = -pressure * (1 - 2 * nu) / E * (x[a] - 8 * mm);
      difference += std::pow(u[a] - expected, 2);
      size += expected * expected;
    }
    apart = std::max(apart, std::sqrt(difference));
    largest = std::max(largest, std::sqrt(size));
  }
  report.add({{"case", "ball under pressure"},
              {"cells_across", 16},
              {"cells", scene.specimen.n_matter_cells()},
              {"error", apart / largest}});
  return apart / largest;
}

/// The part of the voxel around x that is between two radii, of a ball or of a cylinder along z, by points.
double part_between(const Vec3& x, double inner, double outer, bool is_ball) {
  constexpr int n = 16;
  int inside = 0;
  for (int k = 0; k < (is_ball ? n : 1); ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double r = std::hypot(x[0] + (i + 0.5) / n - 0.5, x[1] + (j + 0.5) / n - 0.5,
                                    is_ball ? x[2] + (k + 0.5) / n - 0.5 : 0);
        inside += r >= inner && r <= outer ? 1 : 0;
      }
  return static_cast<double>(inside) / (n * n * (is_ball ? n : 1));
}

/// Work of a pressure within a thick wall over an eighth of a ball, or a quarter of a tube of length 2 mm in
/// plane strain [J]; Lame's closed forms.
double work_in_wall(double a, double b, bool is_ball) {
  if (is_ball) {
    const double scale = pressure * a * a * a / (b * b * b - a * a * a) / E;
    const double u = scale * ((1 - 2 * nu) * a + (1 + nu) / 2 * b * b * b / (a * a));
    return pressure / 2 * u * 4 * std::numbers::pi * a * a / 8;
  }
  const double u = pressure * a * a / (b * b - a * a) * (1 + nu) / E * ((1 - 2 * nu) * a + b * b / a);
  return pressure / 2 * u * 2 * std::numbers::pi * a * 2 * mm / 4;
}

/// Relative error of the work of an inner pressure.
double wall_error(const Files& files, double inner, double outer, bool is_ball, bool is_partial,
                  const Control& control) {
  const int n = static_cast<int>(std::ceil(outer));
  const Image image = image_of({n, n, is_ball ? n : 2},
                               [&](const Vec3& x) { return part_between(x, inner, outer, is_ball); });
  const std::string text = fmt::format(
      R"([specimen]
shape = "image"
image = "body.nii"
material = {{ youngs_modulus = "10 kPa", poisson_ratio = 0.3 }}
{}
[[hold]]
where = {{ box = [[0, 0, 0], [0, "20 mm", "20 mm"]] }}
axes = "x"
[[hold]]
where = {{ box = [[0, 0, 0], ["20 mm", 0, "20 mm"]] }}
axes = "y"
[[hold]]
where = {{ box = [[0, 0, 0], ["20 mm", "20 mm", {}]] }}
axes = "z"
[[load]]
where = {}
pressure = "100 Pa"
)",
      is_partial ? "partial_volume = { none = 0, full = 1, least = 0.001 }" : "threshold = 0.4999",
      is_ball ? "0" : "\"20 mm\"",
      is_ball
          ? fmt::format("{{ sphere = {{ centre = [0, 0, 0], radius = \"{} mm\" }} }}", (inner + outer) / 2)
          : "{ box = [[0, 0, 0], [\"10 mm\", \"10 mm\", \"20 mm\"]] }");
  const Scene scene = files.read(image, text);
  Scene loaded = scene;
  // The planes of symmetry are no surface.
  std::erase_if(loaded.tractions, [&](const FaceLoad& face) {
    return !face.upper && scene.specimen.grid.cell_at(face.cell)[static_cast<std::size_t>(face.axis)] == 0 &&
           scene.specimen.origin[static_cast<std::size_t>(face.axis)] < mm / 2;
  });
  if (!is_ball)
    std::erase_if(loaded.tractions, [](const FaceLoad& face) { return face.axis == 2; });
  const Answer answer = solved(loaded, 1e-7, control);
  const double expected = work_in_wall(inner * mm, outer * mm, is_ball);
  return *answer.strain_energy / expected - 1;
}

double partial_volume_gain(const BenchOptions& options, BenchReport& report) {
  const Files files;
  double least = std::numeric_limits<double>::infinity();
  for (const bool is_ball : {true, false}) {
    // Sizes within a cell of each other: whether steps of voxels happen to fit one of them says little.
    const std::vector<double> radii =
        options.quick ? std::vector<double>{8} : std::vector<double>{7.6, 7.8, 8, 8.2, 8.4};
    double stairs = 0, partial = 0;
    for (const double inner : radii) {
      const double of_stairs = wall_error(files, inner, 2 * inner, is_ball, false, report.one_thread()),
                   of_partial = wall_error(files, inner, 2 * inner, is_ball, true, report.one_thread());
      report.add({{"case", is_ball ? "spherical hole under pressure" : "cylindrical hole under pressure"},
                  {"cells_across", 2 * inner},
                  {"staircase_error", of_stairs},
                  {"partial_volume_error", of_partial}});
      stairs += of_stairs * of_stairs;
      partial += of_partial * of_partial;
    }
    least = std::min(least, std::sqrt(stairs / partial));
  }
  return least;
}

// ---- sliding ---------------------------------------------------------------------------------------------
double sliding_blocks_error(BenchReport& report) {
  const Files files;
  const auto blocks = [](const Vec3& x) { return x[2] < 4 ? 1.0 : 2.0; };
  const std::string text = R"([specimen]
shape = "image"
image = "body.nii"
labels = { 1 = { youngs_modulus = "100 kPa", poisson_ratio = 0.3 }, 2 = { youngs_modulus = "40 kPa", poisson_ratio = 0.45 } }
[[hold]]
where = "z-"
axes = "z"
[[move]]
where = "z+"
by = [0, 0, "-0.2 mm"]
axes = "z"
[[hold]]
where = { any = [{ box = [[0, 0, 0], [0, 0, 0]] }, { box = [[0, 0, "10 mm"], [0, 0, "10 mm"]] }] }
axes = "xy"
[[hold]]
where = { any = [{ box = [["6 mm", 0, 0], ["6 mm", 0, 0]] }, { box = [["6 mm", 0, "10 mm"], ["6 mm", 0, "10 mm"]] }] }
axes = "y"
)";
  const auto force = [](const Scene& scene, const Answer& answer) {
    double sum = 0;
    for (std::size_t i = 0; i < answer.reaction.size(); ++i)
      sum += scene.prescribed[i].held ? 0 : answer.reaction[i];
    return sum;
  };
  const double expected = -0.2 * mm / (4 * mm / 100e3 + 6 * mm / 40e3) * 36 * mm * mm;
  const Scene glued = files.read(image_of({6, 6, 10}, blocks), text),
              sliding = files.read(image_of({6, 6, 10}, blocks), text + "[[sliding]]\nbetween = [1, 2]\n");
  const Answer of_glued = solved(glued, 1e-7, report.one_thread()),
               of_sliding = solved(sliding, 1e-7, report.one_thread());
  const double error = std::abs(force(sliding, of_sliding) / expected - 1);
  report.add({{"case", "blocks on each other"},
              {"force_n", force(sliding, of_sliding)},
              {"closed_form_n", expected},
              {"force_if_joined_n", force(glued, of_glued)},
              {"iterations", of_sliding.iterations},
              {"error", error}});
  return error;
}

/// A block that is drawn along another by 1 mm, and pressed: all of its border slips, and draws with the
/// coefficient times what presses.
void friction_of_blocks(BenchReport& report) {
  const Files files;
  const Scene scene = files.read(image_of({6, 6, 10}, [](const Vec3& x) { return x[2] < 4 ? 1.0 : 2.0; }),
                                 R"([specimen]
shape = "image"
image = "body.nii"
labels = { 1 = { youngs_modulus = "100 kPa", poisson_ratio = 0 }, 2 = { youngs_modulus = "40 kPa", poisson_ratio = 0 } }
[[hold]]
where = "z-"
[[move]]
where = "z+"
by = ["1 mm", 0, "-0.2 mm"]
[[sliding]]
between = [1, 2]
friction = 0.3
)");
  const Answer answer = solved(scene, 1e-6, report.one_thread());
  double drawn = 0, pressed = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i) {
    const Prescribed& p = scene.prescribed[i];
    drawn += !p.held && p.component == 0 ? answer.reaction[i] : 0;
    pressed -= !p.held && p.component == 2 ? answer.reaction[i] : 0;
  }
  report.add({{"case", "block drawn along another with friction"},
              {"drawn_n", drawn},
              {"pressed_n", pressed},
              {"iterations", answer.iterations},
              {"error", std::abs(drawn / (0.3 * pressed) - 1)}});
}

/// A shaft of 8 cells across that turns within a tube: how far the tube goes over how far the shaft does.
void shaft_in_tube(BenchReport& report) {
  const Files files;
  const auto shaft = [](const Vec3& x) { return std::hypot(x[0] - 8, x[1] - 8) < 4 ? 2.0 : 1.0; };
  Scene scene = files.read(image_of({16, 16, 3}, shaft), R"([specimen]
shape = "image"
image = "body.nii"
labels = { 1 = { youngs_modulus = "100 kPa", poisson_ratio = 0.3 }, 2 = { youngs_modulus = "100 kPa", poisson_ratio = 0.3 } }
[[hold]]
where = { any = ["x-", "x+", "y-", "y+"] }
[[move]]
where = { box = [["5.5 mm", "5.5 mm", 0], ["10.5 mm", "10.5 mm", "3 mm"]] }
by = [0, 0, 0]
[[sliding]]
between = [1, 2]
[limits]
from = "given"
stretch = 1.002
compress = 0.998
shear = 0.02
)");
  const double angle = 0.01;
  for (Prescribed& p : scene.prescribed)
    if (const Index3 at = scene.specimen.grid.node_at(p.node); !p.held && p.component < 2)
      p.value = p.component == 0 ? -angle * (at[1] - 8) * mm : angle * (at[0] - 8) * mm;
  for (const char* method : {"coupled", "relaxed", "limits"}) {
    const Answer answer = deform::solve(scene, method, report.one_thread());
    double of_tube = 0;
    for (const SplitNode& side : answer.split)
      of_tube =
          std::max(of_tube, side.label == 1 ? std::hypot(side.displacement[0], side.displacement[1]) : 0);
    report.add({{"case", "shaft that turns in a tube"},
                {"method", method},
                {"status", to_string(answer.status)},
                {"iterations", answer.iterations},
                {"border_of_tube_over_shaft", of_tube / (4 * mm * angle)}});
  }
}

} // namespace

void bench_anatomy(const BenchOptions& options, BenchReport& report) {
  const auto at_most = [&](const char* name, double value, double goal) {
    report.checks.push_back({name, value, goal, false});
  };
  at_most("orientation_difference", orientation_difference(options, report), 1e-4);
  at_most("sphere_pressure_error", sphere_pressure_error(report), 0.02);
  report.checks.push_back({"partial_volume_gain", partial_volume_gain(options, report), 3});
  at_most("sliding_blocks_error", sliding_blocks_error(report), 0.01);
  friction_of_blocks(report);
  shaft_in_tube(report);
  for (BenchCheck& check : bench_identify(options, report))
    report.checks.push_back(std::move(check));
}

} // namespace maille::studies
