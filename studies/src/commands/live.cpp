#include "maille/live/live.hpp"

#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/live_options.hpp"
#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "play/play.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>

namespace maille::studies {

namespace {

/// Folder of the supplied scenes: next to an installed program, or in a build.
std::filesystem::path scenes_folder() {
  std::error_code none;
  const auto installed =
      std::filesystem::read_symlink("/proc/self/exe", none).parent_path() / MAILLE_INSTALLED_SCENES;
  return std::filesystem::exists(installed, none) ? installed.lexically_normal()
                                                  : std::filesystem::path(MAILLE_SCENES);
}

live::Loaded load(const std::filesystem::path& file) {
  live::Loaded loaded;
  loaded.scene =
      is_world_scene(file) ? read_world_scene(file) : world_of_body(read_scene(file), "limits", loaded.notes);
  loaded.looks = read_looks(file);
  for (std::size_t i = 0; i < loaded.looks.size() && i < loaded.scene.objects.size(); ++i)
    loaded.paints.push_back(loaded.looks[i]
                                ? paint_of_look(loaded.scene.objects[i].scene.specimen, loaded.looks[i]->look)
                                : nullptr);
  return loaded;
}

Answer finite_elements(const Scene& question, const Control& control) {
  Scene asked = question; // finite elements have no limits
  asked.limits = {};
  return answer_by(asked, "fem_q1", control);
}

std::pair<int, int> size_of(const std::string& text) {
  int width = 0, height = 0;
  const char* const end = text.data() + text.size();
  const auto across = std::from_chars(text.data(), end, width);
  const auto down = across.ptr != end && *across.ptr == 'x'
                        ? std::from_chars(across.ptr + 1, end, height)
                        : std::from_chars_result{end, std::errc::invalid_argument};
  if (across.ec != std::errc() || down.ec != std::errc() || down.ptr != end || width < 160 || height < 120 ||
      width > 16384 || height > 16384)
    throw UsageError("--size: expected WIDTHxHEIGHT from 160x120 to 16384x16384, found " + text);
  return {width, height};
}

std::shared_ptr<live::HandDevice> device_of(const std::string& name) {
  constexpr double metres_a_second = 0.05;
  if (name == "mouse")
    return nullptr;
  try {
    if (name == "spacenav")
      return live::space_mouse(metres_a_second);
    if (name == "gamepad")
      return std::make_shared<live::GamePad>(metres_a_second);
    if (name.starts_with("udp:")) {
      int port = 0;
      const char* const end = name.data() + name.size();
      const auto read = std::from_chars(name.data() + 4, end, port);
      if (read.ec == std::errc() && read.ptr == end && port > 0 && port < 65536)
        return live::udp_device(port);
    }
  } catch (const std::runtime_error& error) {
    throw UsageError("--device: " + std::string(error.what()));
  }
  throw UsageError("--device: expected mouse, spacenav, gamepad or udp:PORT, found " + name);
}

live::LiveSettings settings_of(const LiveOptions& options) {
  live::LiveSettings settings;
  settings.scene = options.scene;
  settings.menu = live::standard_menu(scenes_folder());
  if (options.record)
    settings.record = *options.record;
  if (options.script)
    settings.script = live::read_script(*options.script);
  settings.in_step = options.headless;
  settings.device = device_of(options.device);
  settings.shots = options.shots;
  settings.method = options.method;
  settings.stereo = options.stereo == "side-by-side" ? live::Stereo::side_by_side
                    : options.stereo == "anaglyph"   ? live::Stereo::anaglyph
                                                     : live::Stereo::none;
  settings.text_scale = options.text;
  if (options.budget) {
    settings.frame_budget = parse_quantity(*options.budget, Dimension::time);
    if (!settings.frame_budget || !(*settings.frame_budget > 0))
      throw UsageError("--frame-budget: expected a time > 0 such as 16ms, found " + *options.budget);
  }
  settings.threads = options.threads;
  return settings;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty())
    return 0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

nlohmann::ordered_json json(const live::LiveReport& report, const std::string& driver) {
  return {{"window", driver},
          {"text_scale", report.text_scale},
          {"pictures", report.pictures},
          {"events", report.events},
          {"first_picture_s", report.first_picture},
          {"event_to_picture_s",
           {{"n", report.event_to_picture.size()},
            {"median", quantile(report.event_to_picture, 0.5)},
            {"p99", quantile(report.event_to_picture, 0.99)}}},
          {"hand",
           {{"ticks", report.hand.ticks},
            {"missed", report.hand.missed},
            {"p999_ms", 1e-6 * static_cast<double>(report.hand.latency.quantile(0.999))},
            {"had_priority", report.hand.had_priority}}},
          {"penetrations", report.penetrations},
          {"messages", report.messages}};
}

std::string in_words(const live::LiveReport& report) {
  std::string text = fmt::format("{} pictures, the first after {:.2f} s; {} events\n", report.pictures,
                                 report.first_picture, report.events);
  if (!report.event_to_picture.empty())
    text += fmt::format("event to picture: median {:.0f} ms, 99 of 100 within {:.0f} ms\n",
                        1000 * quantile(report.event_to_picture, 0.5),
                        1000 * quantile(report.event_to_picture, 0.99));
  text += fmt::format("penetrations: {}\n", report.penetrations);
  for (const std::string& message : report.messages)
    text += message + "\n";
  return text;
}

} // namespace

int live_command(const LiveOptions& options) {
  std::vector<std::filesystem::path> inputs;
  for (const auto& file : {options.scene, options.script})
    if (file)
      inputs.push_back(*file);
  keep_inputs(inputs);
  prepare_file("--record", options.record, {}, "", trajectory_header());
  prepare_file("--json", options.json);
  const auto [width, height] = size_of(options.size);
  if (options.headless && !options.script)
    throw UsageError("--headless: expected --script EVENTS.csv with it: without a window only scripts act");
  const live::LiveSettings settings = settings_of(options);
  for (const auto& [at, event] : settings.script)
    if ((event.kind == live::EventKind::shot || event.name == "shot") && !event.text.empty())
      prepare_file("--shots", (settings.shots / event.text).string(), std::nullopt, ".png");
  live::LiveTools tools;
  tools.add_mark = add_mark;
  tools.load = load;
  tools.finite_elements = finite_elements;
  tools.make_film = [](const std::filesystem::path& stem, std::int64_t n, double seconds) {
    return make_film(stem, 4, n, seconds, stem.string() + ".mp4");
  };
  if (options.scene && options.headless)
    (void)load(*options.scene); // an error ends it: a headless window could not show it
  std::unique_ptr<live::Window> window;
  if (options.headless) {
    window = std::make_unique<live::HeadlessWindow>(width, height);
  } else {
    live::WindowSettings asked;
    asked.title = options.scene ? "Maille - " + options.scene->filename().string() : "Maille";
    asked.width = width;
    asked.height = height;
    asked.text_scale = options.text;
    asked.full_screen = options.full_screen;
    asked.game_controllers = options.device == "gamepad";
    try {
      window = live::open_window(asked);
    } catch (const std::runtime_error& error) {
      throw UsageError(error.what());
    }
  }
  const live::LiveReport report = live::run_live(*window, settings, tools);
  if (options.json)
    deliver(json_text(json(report, window->driver())), options.json);
  if (options.json != "-")
    deliver(in_words(report), std::nullopt);
  return report.has_lost ? exit_run_failed : exit_done;
}

} // namespace maille::studies
