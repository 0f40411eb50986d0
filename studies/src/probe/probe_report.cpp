#include "compare/plots.hpp"
#include "probe/probe_run.hpp"
#include "results/result_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace maille::studies {

namespace {

using deform::LatencyHistogram;
using deform::ServoSample;

struct ForceStatistics {
  double largest = 0, mean = 0; ///< [N]; mean over ticks with contact
  double largest_torque = 0;    ///< [N m]
  double deepest = 0;           ///< largest indentation of a body [m]
  std::int64_t touching = 0;    ///< ticks with contact
};

ForceStatistics statistics_of(const ProbeRun& run) {
  ForceStatistics result;
  for (const ServoSample& sample : run.servo.samples) {
    const double size = sample.state.force.force.norm();
    result.largest = std::max(result.largest, size);
    result.largest_torque = std::max(result.largest_torque, sample.state.force.torque.norm());
    result.deepest = std::max(result.deepest, sample.state.depth);
    if (sample.state.is_touching) {
      result.mean += size;
      ++result.touching;
    }
  }
  result.mean /= static_cast<double>(std::max<std::int64_t>(result.touching, 1));
  return result;
}

double microseconds(std::int64_t nanoseconds) {
  return 1e-3 * static_cast<double>(nanoseconds);
}

const ResultTable<LatencyHistogram::Bin>& columns_of_bins() {
  using Bin = LatencyHistogram::Bin;
  static const ResultTable<Bin> table([](ResultTable<Bin>& columns) {
    columns.add({"", "from_us", "us", "least duration"}, &Bin::from, microseconds);
    columns.add({"", "to_us", "us", "largest duration"}, &Bin::to, microseconds);
    columns.add({"", "count", "", "ticks"}, &Bin::count);
  });
  return table;
}

const ResultTable<LatencyHistogram>& columns_of_latency() {
  static const ResultTable<LatencyHistogram> table([](ResultTable<LatencyHistogram>& columns) {
    columns.add({"", "mean_us", "us", "of all ticks"},
                [](const LatencyHistogram& of) { return 1e-3 * of.mean(); });
    for (const auto& [key, share] : {std::pair{"p50_us", 0.5}, {"p99_us", 0.99}, {"p999_us", 0.999}})
      columns.add({"", key, "us", fmt::format("{:g} % of ticks are not above", 100 * share)},
                  [share = share](const LatencyHistogram& of) { return microseconds(of.quantile(share)); });
    columns.add({"", "largest_us", "us", "of all ticks"}, &LatencyHistogram::largest, microseconds);
    columns.add_rows({"", "bins", "", "a row each that is not empty"}, columns_of_bins(),
                     &LatencyHistogram::bins);
  });
  return table;
}

/// Results of a run.
struct ProbeResult {
  const deform::ProbedWorld* world;
  const ProbeRun* run;
  const ProbeRunSettings* settings;
  ForceStatistics forces;
};

const ResultTable<ProbeResult>& columns_of_result() {
  static const ResultTable<ProbeResult> table([](ResultTable<ProbeResult>& columns) {
    constexpr auto world = &ProbeResult::world;
    constexpr auto run = &ProbeResult::run;
    constexpr auto servo = &ProbeRun::servo;
    constexpr auto settings = &ProbeResult::settings;
    constexpr auto forces = &ProbeResult::forces;
    using Forces = ForceStatistics;
    columns.add({"", "ticks", "", "of the loop"}, run, servo, &deform::ServoReport::ticks);
    columns.add({"", "period_s", "s", "of a tick"}, settings, &ProbeRunSettings::probe,
                &deform::ProbeSettings::period);
    columns.add({"", "in_real_time", "", "false: --no-clock"}, settings, &ProbeRunSettings::in_real_time);
    columns.add({"", "had_priority", "", "over other threads"}, run, servo,
                &deform::ServoReport::had_priority);
    columns.add({"", "missed_deadlines", "", "ticks that ended late, or were left out"}, run, servo,
                &deform::ServoReport::missed);
    columns.add({"", "tool_voxels", "", "1: a point"}, world,
                [](const deform::ProbedWorld& of) { return of.tool().n_voxels(); });
    columns.add({"", "deformable_bodies", "", "of the scene"}, world, &deform::ProbedWorld::n_bodies);
    columns.add({"", "force.largest_n", "N", "on the hand"}, forces, &Forces::largest);
    columns.add({"", "force.mean_touching_n", "N", "of ticks that touch"}, forces, &Forces::mean);
    columns.add({"", "force.largest_torque_nm", "N m", "on the hand"}, forces, &Forces::largest_torque);
    columns.add({"", "force.touching_ticks", "", "in which the tool touches"}, forces, &Forces::touching);
    columns.add({"", "bodies.deepest_m", "m", "that one gave way"}, forces, &Forces::deepest);
    columns.add({"", "bodies.sites", "", "whose stiffness was asked for"}, run, &ProbeRun::sites);
    columns.add({"", "bodies.answers", "", "that came"}, run, &ProbeRun::answers);
    columns.add({"", "bodies.slowest_answer_s", "s", "that one took"}, run, &ProbeRun::slowest_answer);
    columns.add({"", "passivity.stiffness", "N/m", "of the coupling"}, settings, &ProbeRunSettings::probe,
                &deform::ProbeSettings::coupling, &deform::CouplingSettings::stiffness);
    columns.add({"", "passivity.largest_passive_stiffness", "N/m", "2 (b - B) / T"}, run,
                &ProbeRun::passive_stiffness);
    columns.add({"", "passivity.least_energy_j", "J", "in the hand's account"}, run, &ProbeRun::least_energy);
    columns.add({"", "passivity.taken_back_j", "J", "by the guard"}, run, &ProbeRun::taken_back);
    columns.add({"", "interrupted", "", "before the motion's end"}, run, &ProbeRun::was_interrupted);
    columns.add({"", "penetrations", "", "looks that found the tool in matter"}, run, &ProbeRun::inside);
    columns.add({"", "looks", "", "after the motion"}, run, &ProbeRun::looks);
    columns.add_row({"", "latency", "", "from due to written"}, columns_of_latency(), run, servo,
                    &deform::ServoReport::latency);
    columns.add_row({"", "work", "", "of that without waking up"}, columns_of_latency(), run, servo,
                    &deform::ServoReport::work);
  });
  return table;
}

/// CSV columns, one line per tick. @param has_clock see ProbeRun
ResultTable<ServoSample> columns_of_samples(bool has_clock) {
  ResultTable<ServoSample> columns({.digits = 9, .digits_of_seconds = 9});
  using State = deform::ProbeState;
  constexpr auto state = &ServoSample::state;
  columns.add({"time", "", "s", "since the loop began"}, &ServoSample::time);
  const auto add_vector = [&](const char* name, const char* unit, const char* meaning, auto... path) {
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      columns.add({fmt::format("{}_{}", name, "xyz"[axis]), "", unit, meaning}, state, path...,
                  [axis](const Eigen::Vector3d& of) { return of[axis]; });
  };
  add_vector("hand", "m", "where the hand was", &State::device);
  add_vector("proxy", "m", "where the tool was", &State::proxy);
  add_vector("force", "N", "on the hand", &State::force, &deform::ProbeForce::force);
  columns.add({"body_stiffness", "", "N/m", "of the body that is touched"}, state, &State::stiffness)
      .digits(6);
  columns
      .add({"latency_us", "", "us", "from due to written; 0 without a clock"},
           [has_clock](const ServoSample& of) { return has_clock ? microseconds(of.latency) : 0.0; })
      .digits(6);
  return columns;
}

/// Latencies by octaves of microseconds, with bars.
std::string bars_of(const LatencyHistogram& histogram) {
  constexpr int most = 40;
  std::vector<std::int64_t> counts;
  for (const auto& bin : histogram.bins()) {
    std::size_t octave = 0;
    while ((std::int64_t{2000} << octave) <= bin.from)
      ++octave;
    counts.resize(std::max(counts.size(), octave + 1));
    counts[octave] += bin.count;
  }
  std::string text;
  for (std::size_t octave = 0; octave < counts.size(); ++octave) {
    const std::size_t length =
        (most * counts[octave] + histogram.n() - 1) / std::max<std::int64_t>(histogram.n(), 1);
    text += fmt::format("  {:>8} us  {:>9}  {}\n", fmt::format("< {}", std::int64_t{2} << octave),
                        counts[octave], std::string(length, '#'));
  }
  return text;
}

} // namespace

std::string table(const deform::ProbedWorld& world, const ProbeRun& run, const ProbeRunSettings& settings) {
  const ForceStatistics forces = statistics_of(run);
  const LatencyHistogram& latency = run.servo.latency;
  const auto& coupling = settings.probe.coupling;
  std::string text = fmt::format(
      "{} ticks of {:g} ms, {} of them touching; tool of {} voxels, {} deformable\n", run.servo.ticks,
      1e3 * settings.probe.period, forces.touching, world.tool().n_voxels(), world.n_bodies());
  text +=
      fmt::format("force      largest {:.4g} N, mean while touching {:.4g} N", forces.largest, forces.mean);
  text +=
      forces.largest_torque > 0 ? fmt::format(", torque up to {:.4g} N m\n", forces.largest_torque) : "\n";
  if (world.n_bodies() > 0)
    text += fmt::format(
        "bodies     gave way by up to {:.4g} mm; {} sites asked for, {} answers, the slowest in {:.3g} s\n",
        1e3 * forces.deepest, run.sites, run.answers, run.slowest_answer);
  text += fmt::format("passivity  {:g} N/m of at most {:g} (2 (b - B) / T); the hand was given {:.3g} J, "
                      "{:.3g} J taken back\n",
                      coupling.stiffness, run.passive_stiffness, std::abs(run.least_energy), run.taken_back);
  text += fmt::format("matter     entered in {} of {} looks{}\n", run.inside, run.looks,
                      run.looks < run.servo.ticks ? " (not every tick was checked)" : "");
  text +=
      fmt::format("{} median {:.4g} us, 99 % {:.4g}, 99.9 % {:.4g}, largest {:.4g}; {} missed deadlines{}\n",
                  settings.in_real_time ? "latency   " : "work      ", microseconds(latency.quantile(0.5)),
                  microseconds(latency.quantile(0.99)), microseconds(latency.quantile(0.999)),
                  microseconds(latency.largest()), run.servo.missed,
                  run.servo.had_priority ? "; with real-time priority" : "");
  return text + bars_of(latency);
}

nlohmann::ordered_json json(const deform::ProbedWorld& world, const ProbeRun& run,
                            const ProbeRunSettings& settings) {
  return columns_of_result().json({&world, &run, &settings, statistics_of(run)});
}

std::string csv(const ProbeRun& run) {
  return columns_of_samples(run.has_clock).csv(run.servo.samples);
}

std::optional<std::string> draw_probe_run(const ProbeRun& run, const std::string& title,
                                          const std::filesystem::path& file) {
  nlohmann::ordered_json samples = nlohmann::ordered_json::array();
  // Of many ticks, those with the largest force and the largest latency are drawn.
  constexpr std::size_t most = 20000;
  const std::span<const ServoSample> all(run.servo.samples);
  const std::size_t together = all.size() / most + 1;
  for (std::size_t i = 0; i < all.size(); i += together) {
    const auto some = all.subspan(i, std::min(together, all.size() - i));
    const auto norm = [](const ServoSample& of) { return of.state.force.force.norm(); };
    const ServoSample& sample = *std::ranges::max_element(some, {}, norm);
    const auto& force = sample.state.force.force;
    samples.push_back({sample.time, force[0], force[1], force[2],
                       microseconds(std::ranges::max_element(some, {}, &ServoSample::latency)->latency)});
  }
  return draw_curves({{"title", title}, {"samples", std::move(samples)}}, file);
}

} // namespace maille::studies
