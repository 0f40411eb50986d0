#include "trade/measure.hpp"

#include "compare/methods.hpp"

#include <algorithm>
#include <ctime>

namespace maille::studies {

namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Answer answer_anew(const Scene& scene, const std::string& method, std::optional<double> tolerance,
                   const Control& control) {
  if (!is_finite_elements(method))
    return answer_by(with_tolerance(scene, tolerance), method, control);
  fem_ref::Options options;
  options.degree = method == "fem_q2" ? 2 : 1;
  if (tolerance)
    options.tolerance = *tolerance;
  return fem_ref::solve(scene, options, control).answer;
}

} // namespace

bool has_tolerance(std::string_view method) {
  return method == "sweep" || method == "relaxed" || method == "coupled";
}

bool is_finite_elements(std::string_view method) {
  return method == "fem_q1" || method == "fem_q2";
}

Scene with_tolerance(const Scene& scene, std::optional<double> tolerance) {
  Scene copy = scene;
  if (tolerance)
    copy.relaxation.tolerance = *tolerance;
  return copy;
}

Measured measure(const Scene& scene, const std::string& method, std::optional<double> tolerance,
                 const Control& control) {
  const double start = processor_seconds();
  Measured measured{answer_anew(scene, method, tolerance, control), 0};
  const double processor = processor_seconds() - start;
  Seconds& seconds = measured.answer.seconds;
  measured.wall_seconds = seconds.total();
  if (processor < measured.wall_seconds) { // other programs used the processor, or threads shared the work
    const double share = control.threads == 1 ? processor / measured.wall_seconds : 1;
    seconds.setup *= share;
    seconds.solve *= share;
  }
  return measured;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

} // namespace maille::studies
