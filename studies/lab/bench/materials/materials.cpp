#include "bench/materials/materials.hpp"

#include "compare/methods.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace maille::lab {

void MaterialsBench::at(double part, std::string_view what) const {
  if (!goes_on(control_, part, what))
    throw Interrupted{};
}

Control MaterialsBench::control() const {
  Control control;
  control.threads = control_.threads;
  control.stop_requested = control_.stop_requested;
  return control;
}

Answer MaterialsBench::answer(const Scene& scene, std::string_view method) const {
  Answer answer = answer_by(scene, method, control());
  if (answer.status == Status::interrupted)
    throw Interrupted{};
  if (!is_converged(answer.status))
    throw std::runtime_error(
        fmt::format("{}: {} ended {}: {}", scene.name, method, to_string(answer.status), answer.message));
  return answer;
}

OffAxisPull off_axis_pull(const ElasticConstants& constants, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double E1 = constants.youngs_modulus[0], E3 = constants.youngs_modulus[2];
  const double give = 1 / constants.G13 - 2 * constants.nu13 / E1;
  const double E_x = 1 / (c * c * c * c / E1 + give * s * s * c * c + s * s * s * s / E3);
  return {E_x, E_x * s * c * ((2 / E1 - give) * c * c - (2 / E3 - give) * s * s)};
}

BenchReport bench_materials(const BenchOptions& options, const Control& control) {
  BenchReport report;
  report.machine = describe_machine();
  report.machine["copy_gb_per_s"] = copy_bandwidth(1 << 20, 1, 1); // nothing here is timed
  MaterialsBench bench(options, control, report);
  try {
    bench_taut_bar(bench);
    bench_free_ends(bench, 0.02, 0.1);
    bench_fitted_limits(bench, 0.1, 0.3);
    bench_turned_fibres(bench, 0.3, 0.5);
    bench_off_axis_pulls(bench, 0.5, 1);
  } catch (const MaterialsBench::Interrupted&) {
    report.checks.clear();
    report.notes.emplace_back("interrupted: the rows so far, no checks");
  }
  return report;
}

} // namespace maille::lab
