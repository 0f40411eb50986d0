#include "maille/studies/choose.hpp"
#include "trade/measure.hpp"

#include "maille/fem_ref/solve.hpp"
#include "maille/scene/compare.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>

namespace maille::studies {

namespace {

constexpr double probing_tolerance = 1e-3;
constexpr std::array<const char*, 3> probed_methods{"limits", "relaxed", "coupled"};

/// The scene as elasticity has it: limits that stand in for it and do not bind.
Scene without_binding_limits(const Scene& scene) {
  Scene free = with_tolerance(scene, probing_tolerance);
  free.limits = {};
  return free;
}

/// Quick answers are asked for again: the first of a process pays for pages and caches.
Probes::OfMethod probe_method(const Scene& scene, const std::string& method, const Displacement& elastic,
                              const Control& control) {
  constexpr int most_runs = 5;
  constexpr double long_enough = 0.02;
  std::vector<double> seconds;
  Probes::OfMethod result;
  double total = 0;
  while (seconds.size() < most_runs && (seconds.size() < 2 || total < long_enough)) {
    const Measured run = measure(scene, method, probing_tolerance, control);
    if (!is_settled(run.answer.status)) {
      result.why_not = fmt::format("{} {}{}{}", method, to_string(run.answer.status),
                                   run.answer.message.empty() ? "" : ": ", run.answer.message);
      return result;
    }
    seconds.push_back(run.answer.seconds.total());
    total += run.wall_seconds;
    result.model_error = compare(scene, run.answer.displacement, elastic).relative_l2;
    if (total > 10 * long_enough)
      break;
  }
  result.seconds = median(seconds);
  return result;
}

} // namespace

Probes probe(Lattices& lattices, const Control& control) {
  const auto start = std::chrono::steady_clock::now();
  Probes probes;
  LatticeScene fine = lattices.at(-1), coarse = lattices.at(-2);
  if (!fine.scene || !coarse.scene) {
    probes.halvings = 0;
    coarse = std::move(fine);
    fine = lattices.at(0);
  }
  if (!coarse.scene) {
    probes.why_not = "there is no coarser lattice to compare with: " + coarse.why_not;
    return probes;
  }
  const Scene& scene = *fine.scene;
  probes.nodes = scene.specimen.n_matter_nodes();
  const Answer elastic = measure(without_binding_limits(scene), "coupled", {}, control).answer,
               coarser = measure(without_binding_limits(*coarse.scene), "coupled", {}, control).answer;
  for (const Answer* answer : {&elastic, &coarser})
    if (!is_settled(answer->status)) {
      probes.why_not = fmt::format("the probe by coupled ended {}{}{}", to_string(answer->status),
                                   answer->message.empty() ? "" : ": ", answer->message);
      return probes;
    }
  probes.difference =
      compare(scene, between_lattices(*coarse.scene, coarser.displacement, scene), elastic.displacement)
          .relative_l2;
  for (const char* method : probed_methods)
    probes.of[method] = probe_method(scene, method, elastic.displacement, control);
  if (!(probes.difference > 0) || !std::isfinite(probes.difference))
    probes.why_not = "nothing moves between the holds and the moves of the probing lattices";
  probes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return probes;
}

RawPrediction predict_raw(const Probes& probes, const Way& way, const Scene* at, std::int64_t nodes) {
  if (!probes.why_not.empty())
    return {};
  const double tolerance = way.tolerance.value_or(0);
  const double discretisation = probes.difference * std::exp2(probes.halvings - way.halvings);
  if (is_finite_elements(way.method)) {
    if (!at)
      return {};
    fem_ref::Options options;
    options.degree = way.method == "fem_q2" ? 2 : 1;
    return {discretisation / options.degree, fem_ref::estimate(*at, options).seconds};
  }
  const auto found = probes.of.find(way.method);
  if (found == probes.of.end() || !found->second.why_not.empty())
    return {};
  const Probes::OfMethod& probed = found->second;
  return {std::hypot(discretisation, probed.model_error, tolerance),
          probed.seconds * static_cast<double>(nodes) / static_cast<double>(probes.nodes)};
}

} // namespace maille::studies
