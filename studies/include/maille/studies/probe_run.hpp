#pragma once
/// A recorded hand feels a scene: `maille probe`.

#include "maille/deform/probe/probed_world.hpp"
#include "maille/deform/probe/servo_loop.hpp"
#include "maille/deform/probe/simulated_device.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

struct ProbeRunSettings {
  deform::ProbeSettings probe;
  deform::HandModel hand;
  bool in_real_time =
      true;        ///< false: tick after tick, physics answering within the tick: the same bits every time
  int threads = 1; ///< of the physics
};

struct ProbeRun {
  deform::ServoReport servo;
  double passive_stiffness = 0; ///< the bound [N/m]
  double least_energy = 0;      ///< that was ever in the hand's account [J]; below 0: it was given some
  double taken_back = 0;        ///< by the guard [J]
  std::int64_t sites = 0;       ///< whose stiffness was asked for
  std::int64_t answers = 0;     ///< that came
  double slowest_answer = 0;    ///< [s]
  std::int64_t inside = 0;      ///< ticks after which the proxy was in matter, of those looked at
  std::int64_t looks = 0;       ///< every tick, or a thousand of them
};

/// Lets the hand follow its recording, from its beginning to its end.
/// @throws UsageError, std::invalid_argument for settings that are not passive, or a motion that begins in matter
ProbeRun run_probe(const deform::ProbedWorld& world, const deform::RecordedMotion& motion,
                   const ProbeRunSettings& settings);

/// What it felt, in numbers, for people.
std::string table(const deform::ProbedWorld& world, const ProbeRun& run, const ProbeRunSettings& settings);
nlohmann::ordered_json json(const deform::ProbedWorld& world, const ProbeRun& run,
                            const ProbeRunSettings& settings);
/// A line a tick: time, place of the hand and of the proxy, force, latency.
std::string csv(const ProbeRun& run);
/// Force over time, and the latencies. @param file .svg or .png @return why it could not be drawn
std::optional<std::string> draw_probe_run(const ProbeRun& run, const std::string& title,
                                          const std::filesystem::path& file);

} // namespace maille::studies
