#include "cli/command_line.hpp"
#include "cli/inputs.hpp"

#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "probe/probe_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <utility>

namespace maille::studies {

namespace {

/// The probed world and its name.
struct Probed {
  deform::ProbedWorld world;
  std::string title;
};

/// Creates the world; its errors about objects become errors of the file.
deform::ProbedWorld probed_world(const WorldScene& scene, int tool, double radius,
                                 const std::filesystem::path& file) {
  try {
    return {scene, tool, radius};
  } catch (const std::invalid_argument& error) {
    throw InputError({{file.string(), 0, "object", "objects that a probe can meet", error.what()}});
  }
}

Probed read_probed(const PlayOptions& options, double radius) {
  if (!is_world_scene(options.scene)) {
    if (options.feel.tool)
      throw UsageError("--tool: expected a scene with [[object]] tables, found one body");
    const Scene scene = read_scene(options.scene);
    if (scene.dimension() != 3)
      throw UsageError(
          fmt::format("maille play: expected a body of three dimensions, found {}", scene.dimension()));
    return {deform::ProbedWorld(scene, radius), scene.title};
  }
  const WorldScene scene = read_world_scene(options.scene);
  int tool = -1;
  if (options.feel.tool) {
    const auto found = std::ranges::find_if(
        scene.objects, [&](const WorldObject& object) { return object.name == *options.feel.tool; });
    if (found == scene.objects.end() || found->kind != ObjectKind::rigid)
      throw UsageError(
          fmt::format("--tool: expected the name of a rigid object, found \"{}\"", *options.feel.tool));
    tool = static_cast<int>(found - scene.objects.begin());
  }
  return {probed_world(scene, tool, radius, options.scene), scene.title};
}

/// Refuses nan and inf, which pass range checks of the command line.
void check_finite(const PlayOptions& options) {
  const std::pair<const char*, double> numbers[] = {{"--rate", options.feel.rate},
                                                    {"--stiffness", options.feel.stiffness},
                                                    {"--damping", options.feel.damping},
                                                    {"--turn-stiffness", options.feel.turn_stiffness},
                                                    {"--device-damping", options.feel.device_damping},
                                                    {"--mass", options.feel.mass},
                                                    {"--hand-stiffness", options.feel.hand_stiffness},
                                                    {"--hand-damping", options.feel.hand_damping},
                                                    {"--largest-force", options.feel.largest_force}};
  for (const auto& [name, value] : numbers)
    if (!std::isfinite(value))
      throw UsageError(fmt::format("{}: expected a finite number, found {}", name, value));
}

/// @throws InputError if a motion is longer than the recorded ticks
void check_length(const deform::RecordedMotion& motion, const PlayOptions& options) {
  if (!ticks_of(motion, 1 / options.feel.rate))
    throw InputError(
        {{options.trajectory.string(), 0, "time",
          fmt::format("times that count from the motion's beginning, up to {:g} s at a --rate of {:g}",
                      static_cast<double>(most_probe_ticks - 1) / options.feel.rate, options.feel.rate),
          fmt::format("{:g} s", motion.duration())}});
}

ProbeRunSettings settings_of(const PlayOptions& options) {
  check_finite(options);
  ProbeRunSettings settings;
  settings.probe.period = 1 / options.feel.rate;
  settings.probe.coupling = {options.feel.stiffness, options.feel.damping, options.feel.turn_stiffness};
  settings.probe.rule =
      options.feel.rule == "reaction" ? deform::ForceRule::reaction : deform::ForceRule::coupling;
  settings.probe.largest_force = options.feel.largest_force;
  settings.hand = {options.feel.mass, options.feel.device_damping, options.feel.hand_stiffness,
                   options.feel.hand_damping};
  settings.in_real_time = !options.feel.no_clock;
  settings.threads = options.threads;
  if (!deform::is_passive(settings.probe.coupling, options.feel.device_damping, settings.probe.period))
    throw UsageError(fmt::format(
        "--stiffness: expected less than {:g} N/m, which is 2 (b - B) / T for --device-damping {:g}, "
        "--damping {:g} and "
        "--rate {:g}, found {:g}",
        deform::largest_passive_stiffness(options.feel.device_damping, options.feel.damping,
                                          settings.probe.period),
        options.feel.device_damping, options.feel.damping, options.feel.rate, options.feel.stiffness));
  return settings;
}

} // namespace

std::vector<CLI::Option*> add_feeling(CLI::App* command, FeelOptions& options) {
  const std::size_t n_before = command->get_options().size();
  command->add_option("--tool", options.tool,
                      "the rigid object of the scene that the hand holds; default: a point");
  command
      ->add_option("--radius", options.radius, "of the part of a body that goes with the tool, such as 2mm")
      ->capture_default_str();
  command
      ->add_option("--rule", options.rule,
                   "coupling: forces through a spring; reaction: the body's own where that is passive")
      ->check(CLI::IsMember({"coupling", "reaction"}))
      ->capture_default_str();
  const auto number = [&](const char* name, double& value, const char* what, const CLI::Validator& range) {
    command->add_option(name, value, what)->check(range)->capture_default_str();
  };
  number("--rate", options.rate, "forces a second", CLI::Range(1.0, 1e5));
  number("--stiffness", options.stiffness, "of the coupling [N/m]", CLI::PositiveNumber);
  number("--damping", options.damping, "of the coupling [N s/m]", CLI::NonNegativeNumber);
  number("--turn-stiffness", options.turn_stiffness, "of the coupling, of tools [N m/rad]",
         CLI::NonNegativeNumber);
  number("--device-damping", options.device_damping, "of the device itself [N s/m]", CLI::NonNegativeNumber);
  number("--mass", options.mass, "of hand and device [kg]; 0: the recording is followed exactly",
         CLI::NonNegativeNumber);
  number("--hand-stiffness", options.hand_stiffness, "of the hand, where it has mass [N/m]",
         CLI::NonNegativeNumber);
  number("--hand-damping", options.hand_damping, "of the hand, where it has mass [N s/m]",
         CLI::NonNegativeNumber);
  number("--largest-force", options.largest_force, "of the device [N]", CLI::PositiveNumber);
  command->add_flag("--no-clock", options.no_clock,
                    "tick after tick, physics within the tick: the same bits every time");
  command->add_option("--csv", options.csv, "a line a tick in FILE (- for stdout)");
  const std::vector<CLI::Option*> all = command->get_options();
  for (std::size_t o = n_before; o < all.size(); ++o)
    all[o]->group("Options of a recorded hand");
  return {all.begin() + static_cast<std::ptrdiff_t>(n_before), all.end()};
}

bool is_recorded_hand(const std::filesystem::path& file) {
  if (file.extension() != ".csv")
    return false;
  std::ifstream lines(file);
  std::string line;
  while (std::getline(lines, line) && (line.empty() || line.front() == '#')) {
  }
  return line.find("object") == std::string::npos && line.find("frame") == std::string::npos;
}

int feel_command(const PlayOptions& options) {
  keep_inputs({options.scene, options.trajectory});
  const auto radius = parse_quantity(options.feel.radius, Dimension::length);
  if (!radius || *radius < 0)
    throw UsageError(
        fmt::format("--radius: expected {}, found \"{}\"", describe(Dimension::length), options.feel.radius));
  if (options.json == "-" && options.feel.csv == "-")
    throw UsageError("--json and --csv: expected at most one of them on stdout, found both");
  if (options.picture && !options.picture->ends_with(".png") && !options.picture->ends_with(".svg"))
    throw UsageError("--picture: expected a file that ends in .png or .svg, found " + *options.picture);
  const ProbeRunSettings settings = settings_of(options);
  const Probed probed = read_probed(options, *radius);
  const deform::RecordedMotion motion = deform::read_recorded_motion(options.trajectory);
  check_length(motion, options);
  prepare_file("--json", options.json);
  prepare_file("--csv", options.feel.csv, {}, "", csv(ProbeRun{}));
  prepare_file("--picture", options.picture);
  if (probed.world.surroundings()->n_inside(probed.world.tool(),
                                            deform::Proxy(probed.world.tool(), motion.at(0)).pose()) > 0)
    throw InputError({{options.trajectory.string(), 0, "", "a motion that begins in free space",
                       "a tool in matter, or outside the world"}});
  const ProbeRun run = run_probe(probed.world, motion, settings, terminal_control(options.threads));
  end_progress();
  const bool speaks = options.json != "-" && options.feel.csv != "-";
  if (speaks)
    deliver(table(probed.world, run, settings), std::nullopt);
  if (options.json) {
    auto out = json(probed.world, run, settings);
    out["title"] = probed.title; // for reports, as the next
    out.update(asked_about(options.scene, ""));
    deliver(json_text(out), options.json);
  }
  if (options.feel.csv)
    deliver(csv(run), options.feel.csv);
  if (options.picture)
    tell_of_picture(draw_probe_run(run, probed.title, *options.picture), *options.picture, speaks);
  if (run.inside > 0)
    fmt::print(stderr,
               "maille play: the tool was in matter in {} of {} looks: forces there are not to be believed\n",
               run.inside, run.looks);
  if (run.was_interrupted)
    fmt::print(stderr, "maille play: interrupted after {} ticks, which are kept\n", run.servo.ticks);
  return run.inside > 0 || run.was_interrupted ? exit_run_failed : exit_done;
}

} // namespace maille::studies
