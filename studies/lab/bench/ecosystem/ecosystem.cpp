#include "bench/ecosystem/ecosystem.hpp"

#include "bench/ecosystem/startup.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/warp/warp.hpp"
#include "maille/scene/write_image.hpp"
#include "median.hpp"
#include "program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>

namespace maille::lab {

namespace {

namespace fs = std::filesystem;

ImageInfo millimetre_grid(const Index3& size) {
  ImageInfo grid;
  grid.size = size;
  grid.spacing = {1e-3, 1e-3, 1e-3};
  grid.world = WorldAxes::lps;
  return grid;
}

/// A body of whole cells in such an image, from voxel `first` on.
Specimen body_in(const Index3& first, const Index3& cells, double spacing) {
  Specimen body;
  body.shape = "box";
  body.grid = Grid(3, cells, {spacing, spacing, spacing});
  for (std::size_t a = 0; a < 3; ++a)
    body.origin[a] = (first[a] - 0.5) * 1e-3;
  body.placement.world = WorldAxes::lps;
  return body;
}

/// Waves of up to 7.2 voxels that fade towards the image's border.
Vec3 wave(const Vec3& x, double length) {
  Vec3 u{};
  double fade = 1;
  for (const double place : x)
    fade *= std::sin(std::numbers::pi * std::clamp(place / length, 0.0, 1.0));
  for (std::size_t a = 0; a < 3; ++a)
    u[a] =
        7.2e-3 * length / 0.256 * fade * std::sin(2 * std::numbers::pi * x[(a + 1) % 3] / length + double(a));
  return u;
}

/// Balls of several sizes, side by side, in the middle of the image: labels that a segmentation may have.
float label_at(const Vec3& x, double length) {
  constexpr std::array<double, 3> radii{0.09, 0.11, 0.12};
  for (std::size_t n = 0; n < 8; ++n) {
    double distance = 0;
    for (std::size_t a = 0; a < 3; ++a)
      distance += std::pow(x[a] / length - ((n >> a & 1) != 0 ? 0.66 : 0.34), 2);
    if (std::sqrt(distance) < radii[n % 3])
      return static_cast<float>(n + 1);
  }
  return 0;
}

struct Waved {
  ImageInfo grid;
  Specimen body;
  Displacement u;
  Image grey, labels;
  double length = 0;
  std::vector<DeformedBody> bodies() const { return {{&body, &u}}; }
};

/// An image of n^3 voxels, a body of cells of two voxels a side in it.
Waved waved(int n) {
  Waved made;
  made.length = n * 1e-3;
  made.grid = millimetre_grid({n, n, n});
  const int cells = n / 2 - 1;
  made.body = body_in({1, 1, 1}, {cells, cells, cells}, 2e-3);
  made.u = Displacement(made.body.grid);
  for (std::int64_t node = 0; node < made.body.grid.n_nodes(); ++node) {
    const Vec3 by = wave(made.body.position(made.body.grid.node_at(node)), made.length);
    for (int a = 0; a < 3; ++a)
      made.u(a, node) = by[static_cast<std::size_t>(a)];
  }
  made.grey = made.labels = {made.grid, std::vector<float>(static_cast<std::size_t>(made.grid.n_voxels()))};
  std::size_t voxel = 0;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++voxel) {
        const Vec3 x{i * 1e-3, j * 1e-3, k * 1e-3};
        made.labels.values[voxel] = label_at(x, made.length);
        made.grey.values[voxel] =
            static_cast<float>(100 + 50 * std::sin(0.2 * i) * std::cos(0.3 * j + 0.1 * k));
      }
  return made;
}

/// The largest distance [voxels] between a voxel and where the map takes the place that it is pulled from.
double worst_residual(const Waved& made, const Pull& pull) {
  const Grid& grid = made.body.grid;
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  double worst = 0;
  std::size_t voxel = 0;
  for (int k = 0; k < pull.grid.size[2]; ++k)
    for (int j = 0; j < pull.grid.size[1]; ++j)
      for (int i = 0; i < pull.grid.size[0]; ++i, ++voxel) {
        if (pull.source[voxel] == Pull::nothing)
          continue;
        const Vec3 at{i * 1e-3, j * 1e-3, k * 1e-3};
        Vec3 rest{}, in_cell{}, error{};
        Index3 cell{};
        for (std::size_t a = 0; a < 3; ++a) {
          rest[a] = at[a] + 1e-3 * double{pull.shift[a * n + voxel]};
          const double place = (rest[a] - made.body.origin[a]) / grid.spacing()[a];
          cell[a] = std::clamp(static_cast<int>(std::floor(place)), 0, grid.cells()[a] - 1);
          in_cell[a] = place - cell[a];
          error[a] = rest[a] - at[a];
        }
        for (int corner = 0; corner < 8; ++corner) {
          double weight = 1;
          for (std::size_t a = 0; a < 3; ++a)
            weight *= (corner >> a & 1) != 0 ? in_cell[a] : 1 - in_cell[a];
          const Vec3 u = made.u.at(grid.corner(cell, corner));
          for (std::size_t a = 0; a < 3; ++a)
            error[a] += weight * u[a];
        }
        worst = std::max(worst, std::hypot(error[0], error[1], error[2]) / 1e-3);
      }
  return worst;
}

/// How far a label's volume in the warped image, parts of voxels included, is from that of det F; beside
/// it the same of counted voxels, which the size of voxels limits.
double worst_volume_error(const Waved& made, const Pull& pull, BenchReport& report) {
  const auto bodies = made.bodies();
  const auto table = warped_label_table(pull, bodies, made.labels, warped_labels(pull, made.labels),
                                        volume_ratio(made.grid, bodies));
  double worst = 0;
  for (const WarpedLabel& label : table) {
    const double error = std::abs(label.sub_voxel_volume / label.integral_of_det_f - 1);
    report.add({{"what", fmt::format("label {}", label.label)},
                {"voxels", label.voxels},
                {"warped_voxels", label.warped},
                {"volume_error", error},
                {"counted_volume_error", std::abs(label.volume / label.integral_of_det_f - 1)}});
    if (label.voxels >= 1000)
      worst = std::max(worst, error);
  }
  return worst;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The displacement of nodes as plastimatch takes a field: of the image at rest, forwards.
Image nodes_as_image(const Waved& made) {
  Image image;
  image.info.size = made.body.grid.nodes();
  image.info.components = 3;
  image.info.spacing = made.body.grid.spacing();
  image.info.origin = made.body.origin;
  image.info.world = WorldAxes::lps;
  for (const double u : made.u.values())
    image.values.push_back(static_cast<float>(1e3 * u));
  return image;
}

/// Both from file to files, alternately, so that a machine that others use treats both alike.
void face_plastimatch(const Waved& made, int repeats, BenchReport& report) {
  if (!has_program("plastimatch")) {
    report.notes.emplace_back("no plastimatch: apt install plastimatch; its checks are left out");
    return;
  }
  const WorkFolder folder("maille");
  const fs::path at = folder.path();
  write_image(made.grey, at / "grey.mha");
  write_image(nodes_as_image(made), at / "push.mha");
  std::vector<double> theirs, ours;
  const auto run = [&](const std::string& words) {
    const std::string line = fmt::format("OMP_NUM_THREADS=1 plastimatch {} > /dev/null 2>&1", words);
    const auto code = run_program(line, [&] { return report.control.should_stop(); });
    if (!code)
      throw BenchStopped{};
    if (*code != 0)
      throw std::runtime_error("plastimatch failed: " + words);
  };
  for (int repeat = 0; repeat < repeats; ++repeat) {
    theirs.push_back(seconds_of([&] {
      run(fmt::format("xf-invert --fixed {0}/grey.mha --input {0}/push.mha --output {0}/their_pull.mha",
                      at.string()));
      run(fmt::format("warp --input {0}/grey.mha --xf {0}/their_pull.mha --output-img {0}/their_warped.mha",
                      at.string()));
    }));
    ours.push_back(seconds_of([&] {
      const Image grey = read_image(at / "grey.mha");
      const auto bodies = made.bodies();
      const Pull pull = pull_of(grey.info, bodies);
      write_image(warped(pull, grey), at / "our_warped.mha");
      write_image(pull_field(pull, bodies), at / "our_pull.mha");
    }));
  }
  report.add({{"what", "plastimatch xf-invert and warp, files to files"}, {"seconds", upper_median(theirs)}});
  report.add({{"what", "maille, files to files"}, {"seconds", upper_median(ours)}});
  report.checks.push_back({"plastimatch_over_maille_warp", upper_median(theirs) / upper_median(ours)});
}

/// Two bars that touch slide by 3.4 and -2.3 voxels and turn by 0.2 rad: the least Dice of a label with the
/// truth, by the closed form at 8^3 points of every voxel.
double dice_of_sliding_bars(int n, BenchReport& report) {
  const ImageInfo grid = millimetre_grid({2 * n, 2 * n, n / 2});
  const double c = std::cos(0.2), s = std::sin(0.2), middle = (n - 0.5) * 1e-3;
  const std::array<double, 2> slides{-2.3e-3, 3.4e-3};
  const int length = n, width = n / 2, depth = n / 4;
  std::vector<Specimen> bars;
  std::vector<Displacement> moved;
  Image labels{grid, std::vector<float>(static_cast<std::size_t>(grid.n_voxels()), 0)};
  for (int bar = 0; bar < 2; ++bar) {
    const Index3 first{n / 2, n - width + bar * width, n / 8};
    bars.push_back(body_in(first, {length, width, depth}, 1e-3));
    Displacement u(bars.back().grid);
    for (std::int64_t node = 0; node < bars.back().grid.n_nodes(); ++node) {
      const Vec3 x = bars.back().position(bars.back().grid.node_at(node));
      const double dx = x[0] + slides[static_cast<std::size_t>(bar)] - middle, dy = x[1] - middle;
      u(0, node) = middle + c * dx - s * dy - x[0];
      u(1, node) = middle + s * dx + c * dy - x[1];
    }
    moved.push_back(std::move(u));
    for (int k = first[2]; k < first[2] + depth; ++k)
      for (int j = first[1]; j < first[1] + width; ++j)
        for (int i = first[0]; i < first[0] + length; ++i)
          labels.values[static_cast<std::size_t>(i + 2 * n * (j + 2 * n * k))] = static_cast<float>(bar + 1);
  }
  const auto truth = [&](double x, double y, double z) {
    const double dx = x - middle, dy = y - middle;
    const double ry = middle - s * dx + c * dy, edge = (n - 0.5) * 1e-3;
    const int bar = ry < edge ? 0 : 1;
    const double rx = middle + c * dx + s * dy - slides[static_cast<std::size_t>(bar)];
    const double low = (n / 2 - 0.5) * 1e-3, bottom = (n / 8 - 0.5) * 1e-3;
    const bool is_in = rx >= low && rx < low + length * 1e-3 && std::abs(ry - edge) < width * 1e-3 &&
                       z >= bottom && z < bottom + depth * 1e-3;
    return is_in ? bar + 1 : 0;
  };
  const std::vector<DeformedBody> bodies{{&bars[0], &moved[0]}, {&bars[1], &moved[1]}};
  const Image after = warped_labels(pull_of(grid, bodies), labels);
  std::array<double, 2> shared{}, sizes{};
  std::size_t voxel = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++voxel) {
        std::array<int, 3> inside{};
        for (int point = 0; point < 512; ++point)
          ++inside[static_cast<std::size_t>(truth((i + ((point & 7) + 0.5) / 8 - 0.5) * 1e-3,
                                                  (j + ((point >> 3 & 7) + 0.5) / 8 - 0.5) * 1e-3,
                                                  (k + ((point >> 6) + 0.5) / 8 - 0.5) * 1e-3))];
        const auto most = static_cast<int>(std::ranges::max_element(inside) - inside.begin());
        const int ours = static_cast<int>(after.values[voxel]);
        for (std::size_t bar = 0; bar < 2; ++bar) {
          const int label = static_cast<int>(bar) + 1;
          sizes[bar] += (most == label) + (ours == label);
          shared[bar] += most == label && ours == label;
        }
      }
  double least = 1;
  for (std::size_t bar = 0; bar < 2; ++bar) {
    const double dice = 2 * shared[bar] / sizes[bar];
    report.add({{"what", fmt::format("sliding bar {}", bar + 1)}, {"voxels", shared[bar]}, {"dice", dice}});
    least = std::min(least, dice);
  }
  return least;
}

} // namespace

void bench_ecosystem(const BenchOptions& options, BenchReport& report) {
  bench_start(options,
              report); // first: to fork a process that holds images takes longer than to start maille
  const int n = options.quick ? 64 : 256;
  const Waved made = waved(n);
  const auto bodies = made.bodies();
  Pull pull;
  const int repeats = options.quick ? 3 : 5;
  const double inverted = median_seconds(
      repeats, [] {}, [&] { pull = pull_of(made.grid, bodies); });
  const double carried = median_seconds(
      repeats, [] {}, [&] { warped(pull, made.grey); });
  report.add({{"what", "pull field"}, {"voxels", made.grid.n_voxels()}, {"seconds", inverted}});
  report.add({{"what", "grey image along it"}, {"voxels", made.grid.n_voxels()}, {"seconds", carried}});
  report.checks.push_back({"pull_residual_voxels", worst_residual(made, pull)});
  report.checks.push_back({"label_volume_error", worst_volume_error(made, pull, report)});
  report.checks.push_back({"dice_sliding", dice_of_sliding_bars(options.quick ? 32 : 64, report)});
  face_plastimatch(made, options.quick ? 1 : 3, report);
  report.notes.emplace_back("what is measured of the Python module (python_copies, python_call_us, import_s, "
                            "mypy_strict_errors, answers_bit_equal) its tests print: ctest -R python -V");
}

} // namespace maille::lab
