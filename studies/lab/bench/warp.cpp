#include "bench/subjects.hpp"

#include "maille/images/write_image.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/warp/warp.hpp"
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

struct Waved {
  ImageInfo grid;
  Specimen body;
  Displacement u;
  Image grey;
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
  made.grey = {made.grid, std::vector<float>(static_cast<std::size_t>(made.grid.n_voxels()))};
  std::size_t voxel = 0;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++voxel) {
        made.grey.values[voxel] =
            static_cast<float>(100 + 50 * std::sin(0.2 * i) * std::cos(0.3 * j + 0.1 * k));
      }
  return made;
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

} // namespace

void bench_warp(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  const Waved made = waved(options.quick ? 64 : 256);
  const auto bodies = made.bodies();
  Pull pull;
  const int repeats = options.quick ? 3 : 5;
  const double inverted = median_seconds(
      repeats, [] {}, [&] { pull = pull_of(made.grid, bodies); });
  const double carried = median_seconds(
      repeats, [] {}, [&] { warped(pull, made.grey); });
  report.add({{"what", "pull field"}, {"voxels", made.grid.n_voxels()}, {"seconds", inverted}});
  report.add({{"what", "grey image along it"}, {"voxels", made.grid.n_voxels()}, {"seconds", carried}});
  face_plastimatch(made, options.quick ? 1 : 3, report);
}

} // namespace maille::lab
