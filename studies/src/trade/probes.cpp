#include "trade/probes.hpp"
#include "trade/body.hpp"
#include "trade/measure.hpp"

#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

namespace maille::studies {

namespace {

constexpr double probing_tolerance = 1e-3;
constexpr double most_probed_cells = 1e6; ///< of lattices finer than the scene's own
constexpr int coarsest = -2;
constexpr int finest_pair = 0; ///< its coarser lattice is the scene's own at most
/// By less, answers that halve the spacing do not come nearer to each other; by more than order 2 gives they
/// do by chance.
constexpr double least_growth = 1.4, largest_growth = 4;
constexpr std::array<const char*, 3> probed_methods{"limits", "relaxed", "coupled"};

/// The scene as elasticity has it: limits that stand in for it and do not bind.
Scene without_active_limits(const Scene& scene) {
  Scene free = with_tolerance(scene, probing_tolerance);
  free.limits = {};
  return free;
}

/// Quick answers are asked for again: the first of a process pays for pages and caches.
Probes::OfMethod probe_method(const Scene& scene, const std::string& method, const Displacement& elastic,
                              const Control& control) {
  constexpr int most_runs = 5;
  constexpr double long_enough = 0.005;
  std::vector<double> seconds;
  Probes::OfMethod result;
  double total = 0;
  while (seconds.size() < most_runs && (seconds.size() < 2 || total < long_enough) && total < 0.2) {
    const Measured run = measure(scene, method, probing_tolerance, control);
    if (!is_converged(run.answer.status)) {
      result.why_not = fmt::format("{} {}{}{}", method, to_string(run.answer.status),
                                   run.answer.message.empty() ? "" : ": ", run.answer.message);
      return result;
    }
    seconds.push_back(run.answer.seconds.total());
    total += run.wall_seconds;
    result.model_error = compare(scene, run.answer.displacement, elastic).relative_l2;
  }
  result.seconds = median(seconds);
  return result;
}

/// Chooses the lattices and answers on them.
class Probing {
public:
  Probing(Lattices& lattices, const Control& control) : lattices_(lattices), control_(control) {}
  Probes run(bool judge_kind);

private:
  /// Whether there is such a lattice, and it holds the body; else why not is kept.
  bool holds(int halvings);
  bool is_small_enough(int halvings) const;
  /// Finds the coarsest pair. @return false without such a pair
  bool find_pair();
  /// The elastic answer, cached; null on failure, and then `why_not`.
  const Displacement* elastic(int halvings);
  const Scene& at(int halvings) { return *lattices_.at(halvings).scene; }
  double difference(int halvings, const Displacement& fine, const Displacement& coarse) {
    return compare(at(halvings), between_lattices(at(halvings - 1), coarse, at(halvings)), fine).relative_l2;
  }
  /// @return the finest answer that was asked for; null where nothing can be said, and then `why_not`
  const Displacement* answer_on_lattices();
  bool find_distances(const Displacement& finest);

  Lattices& lattices_;
  const Control& control_;
  double thickness_ = 0;
  Probes probes_;
  std::map<int, Displacement> elastic_; ///< by halvings
};

bool Probing::is_small_enough(int halvings) const {
  const double cells = static_cast<double>(lattices_.scene().specimen.grid.n_cells());
  return halvings <= 0 || cells * std::exp2(halvings * lattices_.scene().dimension()) <= most_probed_cells;
}

bool Probing::holds(int halvings) {
  if (probes_.lost.contains(halvings))
    return false;
  const LatticeScene lattice = lattices_.at(halvings);
  std::string why_not = lattice.why_not;
  if (lattice.scene)
    why_not = what_is_lost(lattices_.scene(), thickness_, *lattice.scene, halvings);
  if (!why_not.empty())
    probes_.lost[halvings] = why_not;
  return why_not.empty();
}

bool Probing::find_pair() {
  for (int halvings = coarsest; halvings < 0; ++halvings)
    holds(halvings); // callers look these up later
  for (int coarse = coarsest; coarse <= finest_pair; ++coarse)
    if (is_small_enough(coarse + 1) && holds(coarse) && holds(coarse + 1)) {
      probes_.halvings = coarse + 1;
      return true;
    }
  if (probes_.lost.empty())
    probes_.why_not = "there are no two lattices to compare that are small enough";
  else // the finest that is lost says most
    probes_.why_not = fmt::format("there are no two lattices to compare: at {:g} times the spacing {}",
                                  std::exp2(-probes_.lost.rbegin()->first), probes_.lost.rbegin()->second);
  return false;
}

const Displacement* Probing::elastic(int halvings) {
  if (const auto known = elastic_.find(halvings); known != elastic_.end())
    return &known->second;
  Answer answer = measure(without_active_limits(at(halvings)), "coupled", {}, control_).answer;
  if (is_converged(answer.status))
    return &(elastic_[halvings] = std::move(answer.displacement));
  probes_.why_not = fmt::format("the probe by coupled ended {}{}{}", to_string(answer.status),
                                answer.message.empty() ? "" : ": ", answer.message);
  return nullptr;
}

/// Distances on all lattices that resolve the body, from the answer on the finest probed lattice.
bool Probing::find_distances(const Displacement& finest) {
  const Displacement best = between_lattices(at(probes_.halvings), finest, lattices_.scene());
  for (int halvings = coarsest; halvings < probes_.halvings; ++halvings) {
    if (!holds(halvings))
      continue;
    const Displacement* const there = elastic(halvings);
    if (there == nullptr)
      return false;
    probes_.distance[halvings] =
        compare(lattices_.scene(), between_lattices(at(halvings), *there, lattices_.scene()), best)
            .relative_l2;
  }
  return true;
}

const Displacement* Probing::answer_on_lattices() {
  const Displacement* const coarse = elastic(probes_.halvings - 1);
  const Displacement* fine = coarse != nullptr ? elastic(probes_.halvings) : nullptr;
  if (fine == nullptr)
    return nullptr;
  probes_.difference = difference(probes_.halvings, *fine, *coarse);
  if (!probes_.unlike.empty()) {
    if (!is_small_enough(probes_.halvings + 1) || !holds(probes_.halvings + 1)) {
      probes_.why_not = fmt::format(
          "the scene is unlike those of the table ({}), and a third lattice that would speak for it is "
          "too large to probe",
          fmt::join(probes_.unlike, ", "));
      return nullptr;
    }
    const Displacement* const finer = elastic(++probes_.halvings);
    if (finer == nullptr)
      return nullptr;
    const double before = std::exchange(probes_.difference, difference(probes_.halvings, *finer, *fine));
    probes_.growth = before / probes_.difference;
    if (!(*probes_.growth >= least_growth)) {
      probes_.why_not = fmt::format(
          "the scene is unlike those of the table ({}), and answers of three lattices do not approach each "
          "other: they differ by {:.2g} % and {:.2g} %",
          fmt::join(probes_.unlike, ", "), 100 * before, 100 * probes_.difference);
      return nullptr;
    }
    fine = finer;
    if (!find_distances(*fine))
      return nullptr;
  }
  return fine;
}

Probes Probing::run(bool judge_kind) {
  thickness_ = thickness_in_cells(lattices_.scene());
  if (judge_kind)
    probes_.unlike = how_unlike_the_table(lattices_.scene());
  const Displacement* const finest = find_pair() ? answer_on_lattices() : nullptr;
  if (finest == nullptr)
    return std::move(probes_);
  const Scene& scene = at(probes_.halvings);
  probes_.nodes = scene.specimen.n_matter_nodes();
  for (const char* method : probed_methods)
    probes_.of[method] = probe_method(scene, method, *finest, control_);
  if (!(probes_.difference > 0) || !std::isfinite(probes_.difference))
    probes_.why_not = "nothing moves between the holds and the moves of the probing lattices";
  return std::move(probes_);
}

} // namespace

Probes probe(Lattices& lattices, const Control& control, bool judge_kind) {
  const auto start = std::chrono::steady_clock::now();
  Probes probes = Probing(lattices, control).run(judge_kind);
  probes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return probes;
}

RawPrediction predict_raw(const Probes& probes, const Way& way, const Scene* at, std::int64_t nodes) {
  if (!probes.why_not.empty())
    return {};
  const double tolerance = way.tolerance.value_or(0);
  double discretisation = probes.difference * std::exp2(probes.halvings - way.halvings);
  if (probes
          .growth) { // Richardson's extrapolation by the observed order, of which no more than 2 is believed
    const double q = std::min(*probes.growth, largest_growth);
    discretisation = probes.difference / (q - 1) * std::pow(q, probes.halvings - way.halvings);
    if (const auto there = probes.distance.find(way.halvings); there != probes.distance.end())
      discretisation = std::max(discretisation, there->second + probes.difference / (q - 1));
    if (is_finite_elements(way.method) || probes.lost.contains(way.halvings))
      return {};
  }
  if (is_finite_elements(way.method)) {
    if (!at)
      return {};
    fem_ref::Options options;
    options.degree = way.method == "fem_q2" ? 2 : 1;
    return {discretisation / options.degree, fem_ref::estimate(*at, options).seconds, probes.halvings};
  }
  const auto found = probes.of.find(way.method);
  if (found == probes.of.end() || !found->second.why_not.empty())
    return {};
  const Probes::OfMethod& probed = found->second;
  return {std::hypot(discretisation, probed.model_error, tolerance),
          probed.seconds * static_cast<double>(nodes) / static_cast<double>(probes.nodes), probes.halvings};
}

} // namespace maille::studies
