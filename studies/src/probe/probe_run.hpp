#pragma once
/// A recorded hand feels a scene: `maille play`.

#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/servo_loop.hpp"
#include "maille/scene/answer.hpp"

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
  std::int64_t looks = 0;       ///< every tick, or about a thousand of them
  bool has_clock = true; ///< else times are ticks times the period, and latencies are not told per tick
  bool was_interrupted = false; ///< the motion was not felt to its end
};

/// The largest number of ticks that are kept: an hour at 1 kHz.
inline constexpr std::int64_t most_probe_ticks = 3'600'000;
/// The ticks that a motion takes, from 0 s to its last time. @return nothing if they are more than
/// most_probe_ticks
std::optional<std::int64_t> ticks_of(const deform::RecordedMotion& motion, double period);

/// Lets the hand follow its recording, from its beginning to its end, or until it is to stop: what was felt
/// until then is kept.
/// @param control stop and progress, both of the loop and of the looks after it
/// @throws std::invalid_argument for settings that are not passive, a motion that begins in matter or takes
///         too many ticks
ProbeRun run_probe(const deform::ProbedWorld& world, const deform::RecordedMotion& motion,
                   const ProbeRunSettings& settings, const Control& control = {});

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
