#include "gnuplot.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/probe_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

using deform::LatencyHistogram;
using deform::ServoSample;

struct ForceStatistics {
  double largest = 0, mean = 0; ///< [N]; the mean over the ticks that touch
  double largest_torque = 0;    ///< [N m]
  double deepest = 0;           ///< that a body gave way by [m]
  std::int64_t touching = 0;    ///< ticks
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

nlohmann::ordered_json json_of(const LatencyHistogram& histogram) {
  auto bins = nlohmann::ordered_json::array();
  for (const auto& bin : histogram.bins())
    bins.push_back(
        {{"from_us", microseconds(bin.from)}, {"to_us", microseconds(bin.to)}, {"count", bin.count}});
  return {{"mean_us", 1e-3 * histogram.mean()},
          {"p50_us", microseconds(histogram.quantile(0.5))},
          {"p99_us", microseconds(histogram.quantile(0.99))},
          {"p999_us", microseconds(histogram.quantile(0.999))},
          {"largest_us", microseconds(histogram.largest())},
          {"bins", std::move(bins)}};
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
    const auto length = static_cast<std::size_t>((most * counts[octave] + histogram.n() - 1) /
                                                 std::max<std::int64_t>(histogram.n(), 1));
    text += fmt::format("  {:>8} us  {:>9}  {}\n", fmt::format("< {}", std::int64_t{2} << octave),
                        counts[octave], std::string(length, '#'));
  }
  return text;
}

std::string script(const ProbeRun& run, const std::string& title, const std::filesystem::path& file) {
  const bool is_svg = file.extension() == ".svg";
  std::string text =
      fmt::format("set terminal {}\nset output {}\n",
                  is_svg ? "svg size 1100,620 font 'DejaVu Sans,13' background '#FFFFFF' noenhanced"
                         : "pngcairo size 1100,620 font 'DejaVu Sans,10' background '#FFFFFF' noenhanced",
                  gnuplot_quoted(file.string()));
  text += "$samples << EOD\n";
  for (const ServoSample& sample : run.servo.samples) {
    const auto& f = sample.state.force.force;
    text += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n", sample.time, f[0], f[1], f[2],
                        f.norm(), microseconds(sample.latency));
  }
  text += fmt::format("EOD\nset multiplot title {}\n", gnuplot_quoted(title));
  text += "set grid xtics ytics lc '#E4E4E4' lw 0.8\nset border 3\nset tics nomirror scale 0.6\n"
          "set lmargin at screen 0.08\nset rmargin at screen 0.86\n"
          "set key outside right top Left reverse samplen 1.5 spacing 1.25\n";
  text += "set tmargin at screen 0.92\nset bmargin at screen 0.46\nset ylabel 'force on the hand [N]'\nset "
          "format x ''\n"
          "plot $samples using 1:2 with lines lw 1.2 lc '#0072B2' title 'x', "
          "$samples using 1:3 with lines lw 1.2 lc '#009E73' title 'y', "
          "$samples using 1:4 with lines lw 1.2 lc '#D55E00' title 'z', "
          "$samples using 1:5 with lines lw 1.6 lc '#222222' title 'size'\n";
  text +=
      "set tmargin at screen 0.38\nset bmargin at screen 0.10\nset ylabel 'latency [us]'\nset xlabel 'time "
      "[s]'\n"
      "set format x '%g'\nset logscale y\nunset key\n"
      "plot $samples using 1:6 with dots lc '#555555' notitle, 1000 with lines dt 2 lc '#D55E00' notitle\n";
  return text + "unset multiplot\nset output\n";
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
                      run.looks < run.servo.ticks ? " (a look every so many ticks)" : "");
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
  const ForceStatistics forces = statistics_of(run);
  return {{"ticks", run.servo.ticks},
          {"period_s", settings.probe.period},
          {"in_real_time", settings.in_real_time},
          {"had_priority", run.servo.had_priority},
          {"missed_deadlines", run.servo.missed},
          {"tool_voxels", world.tool().n_voxels()},
          {"deformable_bodies", world.n_bodies()},
          {"force",
           {{"largest_n", forces.largest},
            {"mean_touching_n", forces.mean},
            {"largest_torque_nm", forces.largest_torque},
            {"touching_ticks", forces.touching}}},
          {"bodies",
           {{"deepest_m", forces.deepest},
            {"sites", run.sites},
            {"answers", run.answers},
            {"slowest_answer_s", run.slowest_answer}}},
          {"passivity",
           {{"stiffness", settings.probe.coupling.stiffness},
            {"largest_passive_stiffness", run.passive_stiffness},
            {"least_energy_j", run.least_energy},
            {"taken_back_j", run.taken_back}}},
          {"interrupted", run.was_interrupted},
          {"penetrations", run.inside},
          {"looks", run.looks},
          {"latency", json_of(run.servo.latency)},
          {"work", json_of(run.servo.work)}};
}

std::string csv(const ProbeRun& run) {
  std::string text =
      "time,hand_x,hand_y,hand_z,proxy_x,proxy_y,proxy_z,force_x,force_y,force_z,body_stiffness,latency_us\n";
  for (const ServoSample& sample : run.servo.samples) {
    const auto& s = sample.state;
    text += fmt::format(
        "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g}\n", sample.time,
        s.device[0], s.device[1], s.device[2], s.proxy[0], s.proxy[1], s.proxy[2], s.force.force[0],
        s.force.force[1], s.force.force[2], s.stiffness, run.has_clock ? microseconds(sample.latency) : 0.0);
  }
  return text;
}

std::optional<std::string> draw_probe_run(const ProbeRun& run, const std::string& title,
                                          const std::filesystem::path& file) {
  if (auto reason = why_no_gnuplot())
    return reason;
  write_whole(file, [&](const std::filesystem::path& part) { run_gnuplot(script(run, title, part)); });
  return std::nullopt;
}

} // namespace maille::studies
