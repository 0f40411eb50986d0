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
  bool in_real_time = true; ///< false: physics runs within each tick, so that every run gives the same bits
  int threads = 1;          ///< threads of the physics
};

struct ProbeRun {
  deform::ServoReport servo;
  double passive_stiffness = 0; ///< upper bound of passive stiffness [N/m]
  double least_energy = 0;   ///< minimum of the hand's energy account [J]; below 0: the hand received energy
  double taken_back = 0;     ///< energy dissipated by added damping [J]
  std::int64_t sites = 0;    ///< number of sites with requested stiffness
  std::int64_t answers = 0;  ///< number of responses
  double slowest_answer = 0; ///< [s]
  std::int64_t inside = 0;   ///< checked ticks with overlap of the proxy
  std::int64_t looks = 0;    ///< number of checked ticks: all, or about a thousand
  bool has_clock = true;     ///< false: times are ticks times the period, without latencies per tick
  bool was_interrupted = false; ///< stopped before the end of the motion
};

/// Upper bound of recorded ticks: an hour at 1 kHz.
inline constexpr std::int64_t most_probe_ticks = 3'600'000;
/// Number of ticks of a motion, from 0 s to its last time. @return nothing above most_probe_ticks
std::optional<std::int64_t> ticks_of(const deform::RecordedMotion& motion, double period);

/// Plays the recorded hand from start to end, or until a stop request; results up to then are kept.
/// @param control stop and progress, for both the loop and the checks after it
/// @throws std::invalid_argument for settings that are not passive, or a motion that starts with overlap or
///         has too many ticks
ProbeRun run_probe(const deform::ProbedWorld& world, const deform::RecordedMotion& motion,
                   const ProbeRunSettings& settings, const Control& control = {});

/// Results of the run as text.
std::string table(const deform::ProbedWorld& world, const ProbeRun& run, const ProbeRunSettings& settings);
nlohmann::ordered_json json(const deform::ProbedWorld& world, const ProbeRun& run,
                            const ProbeRunSettings& settings);
/// One line per tick: time, positions of hand and proxy, force, latency.
std::string csv(const ProbeRun& run);
/// Plots force over time, and latencies. @param file .svg or .png @return the reason of a failure
std::optional<std::string> draw_probe_run(const ProbeRun& run, const std::string& title,
                                          const std::filesystem::path& file);

} // namespace maille::studies
