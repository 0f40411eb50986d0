#include "bench/subjects.hpp"

#include "maille/live/live.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sys/resource.h>
#include <thread>

namespace maille::lab {

namespace {

using live::Event;
using live::EventKind;
using live::LiveReport;
using live::LiveSettings;
using live::LiveTools;
using live::ScriptedEvent;

constexpr int edge = 512; // of pictures [pixels]
const std::filesystem::path scenes = MAILLE_SCENES;

double quantile(std::vector<double> values, double share) {
  if (values.empty())
    return std::numeric_limits<double>::infinity();
  std::ranges::sort(values);
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

std::unique_ptr<live::Window> window_of(BenchReport& report) {
  if (live::has_windows() &&
      (std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr)) {
    live::WindowSettings settings;
    settings.width = edge + 300;
    settings.height = edge;
    settings.text_scale = 1;
    try {
      return live::open_window(settings);
    } catch (const std::runtime_error&) {
    }
  }
  const std::string note =
      "no display: pictures were made and not shown; xvfb-run -a studies/lab/run live has a window";
  if (std::ranges::find(report.notes, note) == report.notes.end())
    report.notes.push_back(note);
  return std::make_unique<live::HeadlessWindow>(edge, edge);
}

live::Loaded load(const std::filesystem::path& file, const std::string& method) {
  live::Loaded loaded;
  loaded.scene =
      is_world_scene(file) ? read_world_scene(file) : world_of_body(read_scene(file), method, loaded.notes);
  if (!method.empty())
    loaded.scene.method = method;
  loaded.looks = read_looks(file);
  return loaded;
}

Scene box_of(int nodes) {
  return parse_scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{0}, {0}, {0}]\nspacing = \"1 mm\"\n"
                  "material = {{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }}\n"
                  "[[hold]]\nwhere = \"z-\"\n"
                  "[limits]\nfrom = \"given\"\nstretch = 1.25\ncompress = 0.75\nshear = 0.25\n",
                  nodes - 1),
      "box.toml");
}

live::Loaded box(int nodes, const std::string& method) {
  live::Loaded loaded;
  Scene scene = box_of(nodes);
  if (method != "limits") // elastic methods within no limits: what they take is their own time
    scene.limits = {};
  loaded.scene = world_of_body(scene, method, loaded.notes);
  return loaded;
}

/// Where something that can be moved is in the first picture, nearest to its middle, and well inside.
std::optional<std::array<int, 2>> place_to_take(const live::Loaded& loaded) {
  const live::Looking looking = live::first_looking(loaded.scene, edge, edge);
  const auto painter =
      loaded.scene.dimension < 3 ? live::flat_painter() : live::volume_painter(loaded.looks, 2);
  live::WorldState state;
  state.scene_number = 1;
  for (const WorldObject& object : loaded.scene.objects) {
    state.frames.push_back(deform::frame_of(object));
    state.displacements.push_back(object.kind == ObjectKind::deformable
                                      ? std::make_shared<const Displacement>(object.scene.specimen.grid)
                                      : nullptr);
  }
  const live::Painted painted = painter->paint(loaded.scene, state, looking);
  std::optional<std::array<int, 2>> best;
  double least = std::numeric_limits<double>::infinity();
  const auto object_at = [&](int x, int y) {
    return painted.object[static_cast<std::size_t>(y) * edge + static_cast<std::size_t>(x)];
  };
  for (int y = 3; y < edge - 3; ++y)
    for (int x = 3; x < edge - 3; ++x) {
      const int object = object_at(x, y);
      if (object < 0 || loaded.scene.objects[static_cast<std::size_t>(object)].kind == ObjectKind::fixed)
        continue;
      const bool is_edge =
          object_at(x - 2, y) != object || object_at(x + 2, y) != object || object_at(x, y + 2) != object;
      if (const double far = std::hypot(x - edge / 2, y - edge / 2) + (is_edge ? edge : 0); far < least) {
        least = far;
        best = {x, y};
      }
    }
  return best;
}

ScriptedEvent event_at(double at, EventKind kind, double x, double y) {
  ScriptedEvent scripted;
  scripted.at = at;
  scripted.event.kind = kind;
  scripted.event.x = x;
  scripted.event.y = y;
  scripted.event.button = 1;
  return scripted;
}

/// A drag along a spiral, sixty moves a second.
std::vector<ScriptedEvent> drag_of(const std::array<int, 2>& from, double seconds, double radius) {
  constexpr double before = 0.7, rate = 60;
  std::vector<ScriptedEvent> script{event_at(before, EventKind::pointer_down, from[0], from[1])};
  const int n = static_cast<int>(seconds * rate);
  for (int i = 1; i <= n; ++i) {
    const double angle = 2 * std::numbers::pi * i / rate, out = radius * std::min(1.0, i / rate);
    script.push_back(event_at(before + i / rate, EventKind::pointer_move, from[0] + out * std::cos(angle),
                              from[1] - out * std::sin(angle)));
  }
  script.push_back(event_at(before + (n + 1) / rate, EventKind::pointer_up, from[0], from[1]));
  return script;
}

struct Run {
  LiveReport report;
  std::string driver;
};

Run run(live::Loaded loaded, std::vector<ScriptedEvent> script, BenchReport& report) {
  const std::unique_ptr<live::Window> window = window_of(report);
  LiveSettings settings;
  settings.scene = "bench";
  settings.script = std::move(script);
  settings.threads = 2;
  settings.text_scale = 1;
  LiveTools tools;
  tools.load = [&](const std::filesystem::path&) { return std::move(loaded); };
  return {live::run_live(*window, settings, tools), window->driver()};
}

/// A row of a drag. @return its 99th percentile from event to picture [ms]
std::optional<double> drag_row(const std::string& name, const live::Loaded& loaded, double seconds,
                               BenchReport& report, LiveReport* out = nullptr) {
  const auto place = place_to_take(loaded);
  if (!place) {
    report.notes.push_back(name + ": nothing that moves is to be seen in its first picture");
    return std::nullopt;
  }
  const Run done = run(loaded, drag_of(*place, seconds, 40), report);
  const std::vector<double>& waits = done.report.event_to_picture;
  const double p99 = 1000 * quantile(waits, 0.99);
  report.add({{"what", name},
              {"window", done.driver},
              {"pictures", done.report.pictures},
              {"moves_seen", waits.size()},
              {"event_to_picture_median_ms", 1000 * quantile(waits, 0.5)},
              {"event_to_picture_p99_ms", p99},
              {"pictures_a_second_p95", 1 / quantile(done.report.picture_seconds, 0.95)},
              {"first_picture_s", done.report.first_picture},
              {"hand_p999_ms", 1e-6 * static_cast<double>(done.report.hand.latency.quantile(0.999))},
              {"penetrations", done.report.penetrations}});
  if (out != nullptr)
    *out = done.report;
  return p99;
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Processor time over wall-clock time while a window is open and nothing moves.
double idle_share(double seconds, BenchReport& report) {
  double share = 0;
  std::thread watch([&] {
    std::this_thread::sleep_for(std::chrono::seconds(3)); // until it is judged and drawn
    const double before = processor_seconds();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    share = (processor_seconds() - before) / seconds;
  });
  run(load(scenes / "world/muscle.toml", ""), {event_at(3.5 + seconds, EventKind::close, 0, 0)}, report);
  watch.join();
  report.add({{"what", "idle"}, {"processor_share", share}, {"seconds", seconds}});
  return share;
}

void check(BenchReport& report, const char* name, std::optional<double> value) {
  if (value)
    report.checks.push_back({name, *value});
}

} // namespace

void bench_live(const BenchOptions& options, BenchReport& report) {
  const double seconds = options.quick ? 1 : 5;
  const live::Loaded large = box(options.quick ? 33 : 128, "limits");
  check(report, "limits_128_ms", drag_row("limits, a node of 128^3", large, seconds, report));
  check(report, "coupled_65_ms",
        drag_row("coupled, a node of 65^3", box(options.quick ? 17 : 65, "coupled"), seconds, report));
  const bool has_data = std::getenv("MAILLE_DATA") != nullptr;
  if (has_data)
    check(report, "calf_legs_coupled_ms",
          drag_row("coupled, muscles of both calves", load(scenes / "calf_both_legs.toml", "coupled"),
                   seconds, report));
  else
    report.notes.emplace_back("MAILLE_DATA is not set: without the calf and the head");
  double slowest = std::numeric_limits<double>::infinity(), first = 0;
  std::optional<double> hand;
  for (const live::Prototype& prototype : live::standard_menu(scenes)) {
    const bool needs_data = prototype.name == "head" || prototype.name == "calf";
    if (needs_data && !has_data)
      continue;
    LiveReport done;
    const live::Loaded loaded = load(prototype.scene, is_world_scene(prototype.scene) ? "" : "limits");
    if (drag_row(prototype.name, loaded, seconds, report, &done)) {
      slowest = std::min(slowest, 1 / quantile(done.picture_seconds, 0.95));
      first = std::max(first, done.first_picture);
      if (prototype.name == "muscle")
        hand = 1e-6 * static_cast<double>(done.hand.latency.quantile(0.999));
    }
  }
  check(report, "first_picture_s", first);
  check(report, "hand_p999_ms", hand);
  check(report, "idle_cpu", idle_share(options.quick ? 1 : 5, report));
  check(report, "prototype_pictures_per_second", slowest);
  report.notes.emplace_back(
      "while things move a picture has as many pixels, down to a quarter along each edge, as "
      "keep to 10 ms; it is whole an eighth of a second after");
}

} // namespace maille::lab
