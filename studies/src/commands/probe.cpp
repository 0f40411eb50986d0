#include "cli/commands.hpp"
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
#include <optional>
#include <utility>

namespace maille::studies {

namespace {

/// What is probed, and what it is called.
struct Probed {
  deform::ProbedWorld world;
  std::string title;
};

/// A world says itself what is wrong with its objects; here it becomes a fault of the file.
deform::ProbedWorld probed_world(const WorldScene& scene, int tool, double radius,
                                 const std::filesystem::path& file) {
  try {
    return {scene, tool, radius};
  } catch (const std::invalid_argument& error) {
    throw InputError({{file.string(), 0, "object", "objects that a probe can meet", error.what()}});
  }
}

Probed read_probed(const ProbeCommandOptions& options, double radius) {
  if (!is_world_scene(options.scene)) {
    if (options.tool)
      throw UsageError("--tool: expected a scene with [[object]] tables, found one body");
    const Scene scene = read_scene(options.scene);
    if (scene.dimension() != 3)
      throw UsageError(
          fmt::format("maille probe: expected a body of three dimensions, found {}", scene.dimension()));
    return {deform::ProbedWorld(scene, radius), scene.title};
  }
  const WorldScene scene = read_world_scene(options.scene);
  int tool = -1;
  if (options.tool) {
    const auto found = std::ranges::find_if(
        scene.objects, [&](const WorldObject& object) { return object.name == *options.tool; });
    if (found == scene.objects.end() || found->kind != ObjectKind::rigid)
      throw UsageError(
          fmt::format("--tool: expected the name of a rigid object, found \"{}\"", *options.tool));
    tool = static_cast<int>(found - scene.objects.begin());
  }
  return {probed_world(scene, tool, radius, options.scene), scene.title};
}

/// A number of the command line that nan or inf passed the range of.
void check_finite(const ProbeCommandOptions& options) {
  const std::pair<const char*, double> numbers[] = {{"--rate", options.rate},
                                                    {"--stiffness", options.stiffness},
                                                    {"--damping", options.damping},
                                                    {"--turn-stiffness", options.turn_stiffness},
                                                    {"--device-damping", options.device_damping},
                                                    {"--mass", options.mass},
                                                    {"--hand-stiffness", options.hand_stiffness},
                                                    {"--hand-damping", options.hand_damping},
                                                    {"--largest-force", options.largest_force}};
  for (const auto& [name, value] : numbers)
    if (!std::isfinite(value))
      throw UsageError(fmt::format("{}: expected a finite number, found {}", name, value));
}

/// @throws InputError where a motion is longer than what is kept of it
void check_length(const deform::RecordedMotion& motion, const ProbeCommandOptions& options) {
  if (!ticks_of(motion, 1 / options.rate))
    throw InputError(
        {{options.motion.string(), 0, "time",
          fmt::format("times that count from the motion's beginning, up to {:g} s at a --rate of {:g}",
                      static_cast<double>(most_probe_ticks - 1) / options.rate, options.rate),
          fmt::format("{:g} s", motion.duration())}});
}

ProbeRunSettings settings_of(const ProbeCommandOptions& options) {
  check_finite(options);
  ProbeRunSettings settings;
  settings.probe.period = 1 / options.rate;
  settings.probe.coupling = {options.stiffness, options.damping, options.turn_stiffness};
  settings.probe.rule =
      options.rule == "reaction" ? deform::ForceRule::reaction : deform::ForceRule::coupling;
  settings.probe.largest_force = options.largest_force;
  settings.hand = {options.mass, options.device_damping, options.hand_stiffness, options.hand_damping};
  settings.in_real_time = !options.no_clock;
  settings.threads = options.threads;
  if (!deform::is_passive(settings.probe.coupling, options.device_damping, settings.probe.period))
    throw UsageError(fmt::format(
        "--stiffness: expected less than {:g} N/m, which is 2 (b - B) / T for --device-damping {:g}, "
        "--damping {:g} and "
        "--rate {:g}, found {:g}",
        deform::largest_passive_stiffness(options.device_damping, options.damping, settings.probe.period),
        options.device_damping, options.damping, options.rate, options.stiffness));
  return settings;
}

} // namespace

int probe_command(const ProbeCommandOptions& options) {
  keep_inputs({options.scene, options.motion});
  const auto radius = parse_quantity(options.radius, Dimension::length);
  if (!radius || *radius < 0)
    throw UsageError(
        fmt::format("--radius: expected {}, found \"{}\"", describe(Dimension::length), options.radius));
  if (options.json == "-" && options.csv == "-")
    throw UsageError("--json and --csv: expected at most one of them on stdout, found both");
  if (options.picture && !options.picture->ends_with(".png") && !options.picture->ends_with(".svg"))
    throw UsageError("--picture: expected a file that ends in .png or .svg, found " + *options.picture);
  const ProbeRunSettings settings = settings_of(options);
  const Probed probed = read_probed(options, *radius);
  const deform::RecordedMotion motion = deform::read_recorded_motion(options.motion);
  check_length(motion, options);
  prepare_file("--json", options.json);
  prepare_file("--csv", options.csv);
  prepare_file("--picture", options.picture);
  if (probed.world.surroundings()->n_inside(probed.world.tool(),
                                            deform::Proxy(probed.world.tool(), motion.at(0)).pose()) > 0)
    throw InputError({{options.motion.string(), 0, "", "a motion that begins in free space",
                       "a tool in matter, or outside the world"}});
  const ProbeRun run = run_probe(probed.world, motion, settings, terminal_control(options.threads));
  end_progress();
  const bool speaks = options.json != "-" && options.csv != "-";
  if (speaks)
    deliver(table(probed.world, run, settings), std::nullopt);
  if (options.json) {
    auto out = json(probed.world, run, settings);
    out["title"] = probed.title; // for reports, as the next
    out.update(asked_about(options.scene, ""));
    deliver(json_text(out), options.json);
  }
  if (options.csv)
    deliver(csv(run), options.csv);
  if (options.picture) {
    if (const auto why_not = draw_probe_run(run, probed.title, *options.picture))
      no_picture(*why_not, *options.picture);
    else if (speaks)
      fmt::print("wrote {}\n", *options.picture);
  }
  if (run.inside > 0)
    fmt::print(
        stderr,
        "maille probe: the tool was in matter in {} of {} looks: forces there are not to be believed\n",
        run.inside, run.looks);
  if (run.was_interrupted)
    fmt::print(stderr, "maille probe: interrupted after {} ticks, which are kept\n", run.servo.ticks);
  return run.inside > 0 || run.was_interrupted ? exit_run_failed : exit_done;
}

} // namespace maille::studies
