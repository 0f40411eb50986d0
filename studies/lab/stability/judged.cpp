#include "checks/promises.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "stability/extremes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::lab {

namespace {

/// A settled answer farther than that from a known truth is silently wrong. Iterative methods ask for 1e-4 of
/// the energy norm; propagation is exact up to the wavefront's quanta.
double allowed_error(std::string_view method) {
  return method == "limits" || method == "dijkstra" ? 1e-6 : 1e-2;
}

std::string in_words(Status status) {
  switch (status) {
  case Status::done:
    return "settled";
  case Status::budget_reached:
    return "budget reached";
  default:
    return std::string(to_string(status));
  }
}

std::optional<Displacement> truth_of(const Extreme& extreme, const Scene& scene, const std::string& method) {
  if (extreme.truth)
    return extreme.truth(scene, method);
  if (method != "limits")
    return std::nullopt;
  Answer paths = deform::solve(scene, "dijkstra");
  return has_displacement(paths.status) ? std::optional(std::move(paths.displacement)) : std::nullopt;
}

/// Length of the vector at a node, of numbers of any size.
template<class Of>
double length_at(const Displacement& u, const Of& of) {
  double length = 0;
  for (std::size_t b = 0; b < u.n_components(); ++b)
    length = std::hypot(length, of(static_cast<int>(b)));
  return length;
}

bool truth_is_rounding(const Scene& scene, const Displacement& truth) {
  const Grid& grid = scene.specimen.grid;
  return !scene.turns.empty() && std::ranges::all_of(truth.values(), [&](double value) {
    return std::abs(value) <= 1e-12 * grid.spacing()[0] * grid.cells()[0];
  });
}

} // namespace

double largest_error(const Scene& scene, const Displacement& answer, const Displacement& truth) {
  // A whole turn moves nothing but by rounding of positions.
  const Grid& grid = scene.specimen.grid;
  double difference = 0, largest = 0;
  if (truth_is_rounding(scene, truth))
    largest = grid.spacing()[0] * grid.cells()[0];
  for (std::size_t i = 0; i < truth.n_nodes(); ++i) {
    const auto node = static_cast<std::int64_t>(i);
    difference =
        std::max(difference, length_at(truth, [&](int b) { return answer(b, node) - truth(b, node); }));
    largest = std::max(largest, length_at(truth, [&](int b) { return truth(b, node); }));
  }
  if (difference == 0)
    return 0;
  return largest > 0 ? difference / largest : std::numeric_limits<double>::infinity();
}

StabilityCell judged(const Extreme& extreme, const Scene& scene, const std::string& method,
                     const Answer& answer) {
  StabilityCell cell;
  cell.outcome = in_words(answer.status);
  cell.note = answer.message;
  cell.iterations = answer.iterations;
  cell.seconds = answer.seconds.total();
  cell.broken = broken_promise(scene, method, answer);
  if (extreme.must_be_refused && answer.status != Status::refused)
    cell.broken = "is answered and has no answer";
  if (!has_displacement(answer.status))
    return cell;
  cell.is_finite =
      std::ranges::all_of(answer.displacement.values(), [](double u) { return std::isfinite(u); });
  const LinkLimits limits(scene);
  const bool has_own_frames = method == "coupled" && in_blocks(scene);
  cell.violation = has_own_frames
                       ? largest_violation_in_blocks(scene, limits, answer.displacement)
                       : largest_violation(scene, limits, answer.displacement, object_frame(scene));
  const auto truth = truth_of(extreme, scene, method);
  if (!truth)
    return cell;
  cell.error = largest_error(scene, answer.displacement, *truth);
  const bool is_told = method == "literal" || (extreme.is_for_lattice && method.starts_with("fem"));
  if (answer.status == Status::done && !is_told && !(*cell.error <= allowed_error(method)) &&
      cell.broken.empty())
    cell.broken = fmt::format("settled, and {:.2g} from the truth", *cell.error);
  return cell;
}

} // namespace maille::lab
