#include "bench/subjects.hpp"

#include "bench/render/vtk_casters.hpp"
#include "maille/render/renderer.hpp"
#include "rivals/plain_caster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>

namespace maille::lab {

namespace {

using namespace render;

constexpr double edge = 0.2; // of the head's cube [m]

/// Skin, skull and brain as shells about a middle, in values of CT.
std::vector<float> head_values(int n) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(n) * static_cast<std::size_t>(n * n));
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double x = 2.0 * i / (n - 1) - 1, y = 2.0 * j / (n - 1) - 1, z = 2.0 * k / (n - 1) - 1;
        const double folds = 0.02 * std::sin(14 * x) * std::sin(11 * y + 1) * std::sin(9 * z);
        const double r = std::sqrt(x * x / 0.62 + y * y / 0.8 + z * z / 0.72) + folds;
        const auto shell = [&](double at, double width) {
          return std::clamp((at - r) / width + 0.5, 0.0, 1.0);
        };
        values.push_back(
            static_cast<float>(1050 * shell(1.0, 0.03) + 700 * (shell(0.9, 0.03) - shell(0.82, 0.03))));
      }
  return values;
}

VoxelGrid cube_of(int n) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  const double h = edge / (n - 1);
  grid.spacing = {h, h, h};
  grid.origin = {-edge / 2, -edge / 2, -edge / 2};
  return grid;
}

double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Median of the seconds by a clock, of this thread's processor by default; the first run does not count.
double median_of(int repeats, const std::function<void(int)>& work,
                 clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  std::vector<double> seconds;
  for (int i = 0; i <= repeats; ++i) {
    const double start = seconds_by(clock);
    work(i);
    if (i > 0)
      seconds.push_back(seconds_by(clock) - start);
  }
  std::ranges::nth_element(seconds, seconds.begin() + repeats / 2);
  return seconds[static_cast<std::size_t>(repeats / 2)];
}

/// Pulled, bent and twisted.
std::shared_ptr<Deformation> bent_lattice(int cells) {
  auto lattice = std::make_shared<Lattice>();
  lattice->cells = {cells, cells, cells};
  lattice->origin = {-edge / 2, -edge / 2, -edge / 2};
  lattice->spacing = {edge / cells, edge / cells, edge / cells};
  auto deformation = std::make_shared<Deformation>(lattice);
  std::vector<Vec3> positions;
  for (std::int64_t node = 0; node < lattice->n_nodes(); ++node) {
    const Vec3 x = deformation->position(node);
    const double z = x[2] / edge, c = std::cos(z), s = std::sin(z);
    positions.push_back({1.1 * (x[0] * c - x[1] * s) + 0.1 * edge * z * z, x[0] * s + x[1] * c,
                         1.1 * x[2] + 0.1 * edge * std::sin(3 * x[0] / edge)});
  }
  deformation->set_positions(positions);
  return deformation;
}

} // namespace

std::unique_ptr<VtkCasters> VtkCasters::open(int width, int height, std::string& why_not) {
  static const auto* const functions = static_cast<const VtkCasterFunctions*>(
      open_plugin("maille-vtk-casters.so", "casters of volumes (VTK)", vtk_casters_layout));
  return functions->open(width, height, why_not);
}

namespace {

class RenderBench {
public:
  RenderBench(const BenchOptions& options, BenchReport& report)
      : report_(report), n_(options.quick ? 64 : 256), repeats_(options.quick ? 1 : 5) {
    view_.width = view_.height = options.quick ? 128 : 512;
    view_.camera =
        seeing({-edge / 2, -edge / 2, -edge / 2}, {edge / 2, edge / 2, edge / 2}, {0.4, 1, 0.3}, {0, 0, 1});
    view_.camera = view_.camera.zoomed(1.5);
    look_ = std::make_shared<Look>(look_preset("ct_skin"));
    std::string why_not;
    vtk_ = VtkCasters::open(view_.width, view_.height, why_not);
    if (!vtk_)
      report_.notes.push_back("rivals omitted: " + why_not);
  }

  void rigid() {
    const auto values = head_values(n_);
    SceneObject head = object_of(n_, values);
    const double step = head.volume->grid().spacing[0];
    const double ours = frame_seconds(std::span(&head, 1), view_);
    row(fmt::format("rigid head of {}^3, shaded", n_), ours);
    report_.checks.push_back(
        {"bytes_per_voxel_seen",
         static_cast<double>(head.volume->bytes()) / static_cast<double>(head.volume->grid().n_voxels())});
    speedup(head);
    fingertip(head);
    if (!vtk_)
      return;
    vtk_->clear();
    vtk_->add_rigid(head.volume->grid(), values, *look_, step);
    const double theirs = vtk_seconds();
    Renderer renderer;
    const auto our_error =
        error_of(renderer.render(std::span(&head, 1), view_).rgb8({0, 0, 0}), values, true);
    vtk_->look_from(view_.camera);
    vtk_->render();
    const auto their_error = error_of(vtk_->pixels(), values, false);
    row(fmt::format("the same by vtkFixedPointVolumeRayCastMapper; mean error {:.3f}/255, ours {:.3f}/255",
                    their_error, our_error),
        theirs);
    report_.checks.push_back({"vtk_over_maille_rigid", theirs / ours});
    report_.checks.push_back({"error_over_vtk_error", our_error / their_error});
  }

  void eight() {
    const int n = n_ / 2;
    const auto values = head_values(n);
    SceneObject head = object_of(n, values);
    std::vector<SceneObject> heads;
    View view = view_;
    view.camera = view.camera.zoomed(0.4);
    if (vtk_)
      vtk_->clear();
    for (int h = 0; h < 8; ++h) {
      head.pose.position = {((h & 1) - 0.5) * 1.1 * edge, (((h >> 1) & 1) - 0.5) * 1.1 * edge,
                            ((h >> 2) - 0.5) * 1.1 * edge};
      heads.push_back(head);
      if (vtk_)
        vtk_->move(vtk_->add_rigid(head.volume->grid(), values, *look_, head.volume->grid().spacing[0]),
                   head.pose.position);
    }
    Renderer renderer;
    renderer.render(heads, view);
    const Vec3 from = heads[7].pose.position;
    const auto at = [&](int i) { return Vec3{from[0] + 1e-4 * i, from[1], from[2] + 1e-4 * i}; };
    const double ours = median_of(2 * repeats_, [&](int i) {
      heads[7].pose.position = at(i);
      renderer.render(heads, view);
    });
    row(fmt::format("eight heads of {}^3, one moves", n), ours);
    const std::int64_t rays = renderer.counters().rays;
    renderer.render(heads, view);
    report_.checks.push_back({"rays_when_still", static_cast<double>(renderer.counters().rays - rays)});
    if (!vtk_)
      return;
    vtk_->look_from(view.camera);
    const double theirs = median_of(repeats_, [&](int i) {
      vtk_->move(7, at(i));
      vtk_->render();
    });
    row("the same by vtkFixedPointVolumeRayCastMapper", theirs);
    report_.checks.push_back({"vtk_over_maille_one_of_eight", theirs / ours});
  }

  void deformed() {
    const int small = n_ / 4, large = n_ / 2;
    const auto values = head_values(small + 1);
    SceneObject head = object_of(small + 1, values);
    head.deformation = bent_lattice(small);
    const double ours = frame_seconds(std::span(&head, 1), view_);
    row(fmt::format("deformed lattice of {}^3 cells", small), ours);
    const auto large_values = head_values(large + 1);
    SceneObject rigid = object_of(large + 1, large_values), bent = rigid;
    bent.deformation = bent_lattice(large);
    const double of_rigid = frame_seconds(std::span(&rigid, 1), view_),
                 of_bent = frame_seconds(std::span(&bent, 1), view_);
    row(fmt::format("rigid head of {}^3", large), of_rigid);
    row(fmt::format("deformed lattice of {}^3 cells", large), of_bent);
    report_.checks.push_back({"deformed_over_rigid_128", of_bent / of_rigid});
    if (!vtk_)
      return;
    vtk_->clear();
    vtk_->add_deformed(*head.deformation, values, *look_);
    const double theirs = vtk_seconds(1);
    row("the first by vtkUnstructuredGridVolumeRayCastMapper, unshaded", theirs);
    report_.checks.push_back({"vtk_over_maille_deformed_64", theirs / ours});
    VoxelGrid grid;
    std::vector<float> resampled;
    const double resampling =
        median_of(1, [&](int) { resampled = vtk_->resample(*head.deformation, values, large, grid); });
    vtk_->clear();
    vtk_->add_rigid(grid, resampled, *look_, grid.spacing[0]);
    const double casting = vtk_seconds();
    row(fmt::format("the first by vtkResampleToImage to {}^3, then vtkFixedPointVolumeRayCastMapper", large),
        resampling + casting);
    report_.checks.push_back({"resample_over_maille_deformed", (resampling + casting) / ours});
  }

private:
  SceneObject object_of(int n, const std::vector<float>& values) const {
    SceneObject object;
    object.volume = std::make_shared<Volume>(cube_of(n), values, 0, 2000);
    object.look = look_;
    return object;
  }
  void row(const std::string& what, double seconds) {
    report_.add({{"what", what}, {"milliseconds", 1e3 * seconds}});
  }
  View moved(const View& view, int i) const {
    View to = view;
    to.camera = view.camera.turned(1e-3 * (i + 1), 0);
    return to;
  }
  /// Time of a frame after the first, one thread: the camera moves, so that everything is cast.
  double frame_seconds(std::span<const SceneObject> objects, const View& view) const {
    Renderer renderer(1);
    return median_of(repeats_, [&](int i) { renderer.render(objects, moved(view, i)); });
  }
  double vtk_seconds(int repeats = 0) {
    return median_of(repeats > 0 ? repeats : repeats_, [&](int i) {
      vtk_->look_from(moved(view_, i).camera);
      vtk_->render();
    });
  }

  void speedup(const SceneObject& head) {
    const auto by_clock = [&](int threads) {
      Renderer renderer(threads);
      return median_of(
          2 * repeats_, [&](int i) { renderer.render(std::span(&head, 1), moved(view_, i)); },
          CLOCK_MONOTONIC);
    };
    report_.checks.push_back({"two_threads_speedup", by_clock(1) / by_clock(2)});
  }

  void fingertip(const SceneObject& head) {
    Look solid = solid_look({0.8f, 0.4f, 0.3f});
    VoxelGrid grid = cube_of(16);
    for (std::size_t a = 0; a < 3; ++a) {
      grid.spacing[a] = 8e-4;
      grid.origin[a] = -6e-3;
    }
    std::vector<float> ball;
    for (int k = 0; k < 16; ++k)
      for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i)
          ball.push_back(static_cast<float>(
              std::clamp(0.5 + (5.5 - std::hypot(i - 7.5, j - 7.5, k - 7.5)) / 2, 0.0, 1.0)));
    SceneObject finger;
    finger.volume = std::make_shared<Volume>(grid, ball, 0, 1);
    finger.look = std::make_shared<Look>(solid);
    std::vector<SceneObject> objects{head, finger};
    Renderer renderer(2);
    renderer.render(objects, view_);
    std::vector<std::uint8_t> screen(4 * static_cast<std::size_t>(view_.width) *
                                     static_cast<std::size_t>(view_.height));
    const double seconds = median_of(
        20 * repeats_ + 1,
        [&](int i) {
          objects[1].pose.position = {0.05 * std::sin(0.1 * i), -0.085, 0.03 * std::cos(0.1 * i)};
          renderer.render(objects, view_).rgba8({0, 0, 0}, screen.data());
        },
        CLOCK_MONOTONIC);
    report_.checks.push_back({"frames_per_second_fingertip", 1 / seconds});
  }

  /// Mean difference to the plain caster, eight samples a voxel, over pixels spread over the picture [1/255];
  /// lit by gradients of smoothed values, as Maille's are, or of the values, as VTK's are.
  double error_of(const std::vector<std::uint8_t>& pixels, const std::vector<float>& values,
                  bool smooth) const {
    std::vector<rivals::PlainObject> heads(1); // copied once, not for every ray
    rivals::PlainObject& head = heads[0];
    const VoxelGrid grid = cube_of(n_);
    head.size = grid.size;
    head.spacing = grid.spacing;
    head.origin = grid.origin;
    head.values.assign(values.begin(), values.end());
    head.low = 0;
    head.high = 2000;
    head.smooth = smooth ? rivals::smoothed(head) : head.values;
    head.look = *look_;
    head.unit_distance = grid.spacing[0];
    const Vec3 ahead = view_.camera.axes()[2];
    const rivals::PlainView of{ahead, {-ahead[0], -ahead[1], -ahead[2]}, grid.spacing[0] / 8, 3 * edge};
    double sum = 0;
    int count = 0;
    const int stride = view_.width / 32;
    for (int y = stride / 2; y < view_.height; y += stride)
      for (int x = stride / 2; x < view_.width; x += stride) {
        const Ray ray = view_.camera.ray(view_.width, view_.height, x, y);
        const auto expected = rivals::cast_plainly(heads, of, ray.origin, ray.direction);
        for (std::size_t c = 0; c < 3; ++c, ++count)
          sum += std::abs(255 * expected[c] -
                          pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) +
                                      static_cast<std::size_t>(x)) +
                                 c]);
      }
    return sum / count;
  }

  BenchReport& report_;
  int n_, repeats_;
  View view_;
  std::shared_ptr<const Look> look_;
  std::unique_ptr<VtkCasters> vtk_;
};

} // namespace

void bench_render(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  RenderBench bench(options, report);
  bench.rigid();
  bench.eight();
  bench.deformed();
  report.machine["copy_gb_per_s"] = copy_bandwidth(std::size_t{1} << 28, options.quick ? 3 : 9, 1);
}

} // namespace maille::lab
