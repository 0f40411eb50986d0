/// Probes: cheap answers on lattices of the scene, each of half the spacing of the one before.
///
/// Two lattices speak for the displacement where the scene is like those of the table of trades, whose errors
/// are known, and three where it is not. The table knows no errors of anything else: three lattices speak for
/// it. Both kinds of probing take their answers from LatticeAnswers.

#include "trade/probes.hpp"
#include "trade/body.hpp"
#include "trade/measure.hpp"

#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

namespace maille::studies {

namespace {

constexpr double probing_tolerance = 1e-3;
constexpr double most_probed_cells = 1e6; ///< upper bound for lattices finer than the scene's
/// Halvings of the coarser lattice of a pair, and of the lattices of a quantity.
constexpr int coarsest = -2, finest_pair = 0, finest_of_quantity = 2;
/// With less growth, answers do not converge as the spacing halves; more than order 2 is coincidence.
constexpr double least_growth = 1.4, largest_growth = 4;
/// Answers that differ by less differ by their algebra.
constexpr double algebra = 2 * probing_tolerance;
constexpr std::array<const char*, 3> probed_methods{"limits", "relaxed", "coupled"};

std::string in_words(const Answer& answer) {
  return fmt::format("{}{}{}", to_string(answer.status), answer.message.empty() ? "" : ": ", answer.message);
}

/// Which lattices hold the body, and the elastic answers on them.
class LatticeAnswers {
public:
  LatticeAnswers(Lattices& lattices, const Control& control)
      : lattices_(lattices), control_(control), thickness_(thickness_in_cells(lattices.scene())) {}

protected:
  const Scene& at(int halvings) { return *lattices_.at(halvings).scene; }
  bool is_small_enough(int halvings) const {
    const double cells = static_cast<double>(lattices_.scene().specimen.grid.n_cells());
    return halvings <= 0 || cells * std::exp2(halvings * lattices_.scene().dimension()) <= most_probed_cells;
  }
  /// True if the lattice exists and represents the body; else stores the reason.
  bool holds(int halvings) {
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
  /// The answer as elasticity has it, limits or not, kept; null on failure, and then `why_not`.
  const Answer* elastic(int halvings) {
    if (const auto known = elastic_.find(halvings); known != elastic_.end())
      return &known->second;
    Scene free = with_tolerance(at(halvings), probing_tolerance);
    free.limits = {};
    Answer answer = measure(free, "coupled", {}, control_).answer;
    if (is_converged(answer.status))
      return &(elastic_[halvings] = std::move(answer));
    probes_.why_not = "the probe by coupled ended " + in_words(answer);
    return nullptr;
  }
  /// Times a method on the lattice of the probes, within limits where they bind. Quick answers are asked for
  /// again: the first of a process pays for pages and caches.
  /// @param error_of  of an answer, over the elastic one
  template<class ErrorOf>
  void time(const std::string& method, const ErrorOf& error_of) {
    constexpr int most_runs = 5;
    constexpr double long_enough = 0.005, too_long = 0.2; // [s]
    std::vector<double> seconds;
    Probes::OfMethod& of = probes_.of[method];
    double total = 0;
    while (seconds.size() < most_runs && (seconds.size() < 2 || total < long_enough) && total < too_long) {
      const Measured run = measure(at(probes_.halvings), method, probing_tolerance, control_);
      if (!is_converged(run.answer.status)) {
        of.why_not = method + " " + in_words(run.answer);
        return;
      }
      seconds.push_back(run.answer.seconds.total());
      total += run.wall_seconds;
      of.model_error = error_of(run.answer);
    }
    of.seconds = median(seconds);
  }

  Lattices& lattices_;
  const Control& control_;
  double thickness_;
  Probes probes_;

private:
  std::map<int, Answer> elastic_; ///< by halvings
};

/// Chooses the lattices of the displacement and answers on them.
class Probing : LatticeAnswers {
public:
  using LatticeAnswers::LatticeAnswers;
  Probes run(bool judge_kind);

private:
  /// Finds the coarsest pair. @return false without such a pair
  bool find_pair();
  double difference(int halvings, const Answer& fine, const Answer& coarse) {
    return compare(at(halvings), between_lattices(at(halvings - 1), coarse.displacement, at(halvings)),
                   fine.displacement)
        .relative_l2;
  }
  /// @return the answer on the finest probed lattice; null if no forecast is possible, with `why_not` set
  const Answer* answer_on_lattices();
  bool find_distances(const Answer& finest);
};

bool Probing::find_pair() {
  for (int halvings = coarsest; halvings < 0; ++halvings)
    holds(halvings); // stores reasons for callers
  for (int coarse = coarsest; coarse <= finest_pair; ++coarse)
    if (is_small_enough(coarse + 1) && holds(coarse) && holds(coarse + 1)) {
      probes_.halvings = coarse + 1;
      return true;
    }
  if (probes_.lost.empty())
    probes_.why_not = "there are no two lattices to compare that are small enough";
  else // the finest lost lattice is the most informative
    probes_.why_not = fmt::format("there are no two lattices to compare: at {:g} times the spacing {}",
                                  std::exp2(-probes_.lost.rbegin()->first), probes_.lost.rbegin()->second);
  return false;
}

/// Distances on all lattices that resolve the body, from the answer on the finest probed lattice.
bool Probing::find_distances(const Answer& finest) {
  const Displacement best = between_lattices(at(probes_.halvings), finest.displacement, lattices_.scene());
  for (int halvings = coarsest; halvings < probes_.halvings; ++halvings) {
    if (!holds(halvings))
      continue;
    const Answer* const there = elastic(halvings);
    if (there == nullptr)
      return false;
    probes_.distance[halvings] =
        compare(lattices_.scene(), between_lattices(at(halvings), there->displacement, lattices_.scene()),
                best)
            .relative_l2;
  }
  return true;
}

const Answer* Probing::answer_on_lattices() {
  const Answer* const coarse = elastic(probes_.halvings - 1);
  const Answer* fine = coarse != nullptr ? elastic(probes_.halvings) : nullptr;
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
    const Answer* const finer = elastic(++probes_.halvings);
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
  if (judge_kind)
    probes_.unlike = how_unlike_the_table(lattices_.scene());
  const Answer* const finest = find_pair() ? answer_on_lattices() : nullptr;
  if (finest == nullptr)
    return std::move(probes_);
  const Scene& scene = at(probes_.halvings);
  probes_.nodes = scene.specimen.n_matter_nodes();
  for (const char* method : probed_methods)
    time(method, [&](const Answer& answer) {
      return compare(scene, answer.displacement, finest->displacement).relative_l2;
    });
  if (!(probes_.difference > 0) || !std::isfinite(probes_.difference))
    probes_.why_not = "nothing moves between the holds and the moves of the probing lattices";
  return std::move(probes_);
}

/// Finds three lattices that speak for a quantity.
class QuantityProbing : LatticeAnswers {
public:
  QuantityProbing(Lattices& lattices, const Quantity& quantity, const Control& control)
      : LatticeAnswers(lattices, control), quantity_(quantity) {
    probes_.quantity = quantity.name;
  }

  Probes run() {
    probes_.lost[coarsest - 1] = "it is coarser than the lattices that speak for it";
    for (int halvings = coarsest; halvings <= finest_of_quantity; ++halvings)
      if (is_small_enough(halvings) && holds(halvings))
        held_.push_back(halvings);
    if (!find_lattices())
      return std::move(probes_);
    find_distances();
    const Scene& scene = at(probes_.halvings);
    probes_.nodes = scene.specimen.n_matter_nodes();
    time("coupled", [&](const Answer& answer) {
      return quantity_.difference({&scene, &answer}, {&scene, elastic(probes_.halvings)}).value_or(0);
    });
    for (const char* method : {"limits", "relaxed"})
      probes_.of[method].why_not = fmt::format("of coupled alone can an error of {} be promised", what());
    return std::move(probes_);
  }

private:
  const std::string& what() const { return quantity_.name; }

  bool is_held(int halvings) const { return std::ranges::find(held_, halvings) != held_.end(); }

  /// @return nothing on failure, and then `why_not`
  std::optional<double> difference(int coarse, int fine) {
    const Answer* const a = elastic(coarse);
    const Answer* const b = a != nullptr ? elastic(fine) : nullptr;
    if (b == nullptr)
      return std::nullopt;
    const auto found = quantity_.difference({&at(coarse), a}, {&at(fine), b});
    if (!found || !std::isfinite(*found)) {
      probes_.why_not = fmt::format("its answers have no {} to compare", what());
      return std::nullopt;
    }
    return found;
  }

  /// Whether numbers of three lattices move on in one direction: where they turn, two agree by chance.
  bool goes_on(int coarse) {
    if (!quantity_.numbers)
      return true;
    const auto a = quantity_.numbers(at(coarse), *elastic(coarse)),
               b = quantity_.numbers(at(coarse + 1), *elastic(coarse + 1)),
               c = quantity_.numbers(at(coarse + 2), *elastic(coarse + 2));
    double product = 0;
    for (std::size_t i = 0; i < c.size(); ++i)
      product += (b[i] - a[i]) * (c[i] - b[i]);
    return product > 0;
  }

  /// The coarsest three that approach each other.
  bool find_lattices() {
    std::string why_not = "there are no three lattices to compare that hold the body and are small enough";
    for (int coarse = coarsest; coarse + 2 <= finest_of_quantity; ++coarse) {
      if (!is_held(coarse) || !is_held(coarse + 1) || !is_held(coarse + 2))
        continue;
      const auto before = difference(coarse, coarse + 1);
      const auto last = before ? difference(coarse + 1, coarse + 2) : std::nullopt;
      if (!last) {
        why_not = std::exchange(probes_.why_not, {});
        continue;
      }
      probes_.halvings = coarse + 2;
      probes_.difference = std::max(*last, *before / largest_growth);
      probes_.growth = *before / probes_.difference;
      if (std::max(*before, *last) <= algebra) {
        probes_.difference = algebra;
        probes_.growth = 2;
        return true;
      }
      if (*probes_.growth >= least_growth && (*last <= algebra || goes_on(coarse)))
        return true;
      why_not = fmt::format(
          "three lattices do not approach each other: their {} differs by {:.2g} % and {:.2g} "
          "%{}",
          what(), 100 * *before, 100 * *last, *probes_.growth >= least_growth ? ", there and back" : "");
    }
    probes_.why_not = why_not;
    return false;
  }

  void find_distances() {
    for (const int halvings : held_) {
      if (halvings >= probes_.halvings)
        continue;
      const auto there = difference(halvings, probes_.halvings);
      if (there)
        probes_.distance[halvings] = *there;
      else
        probes_.lost[halvings] = std::exchange(probes_.why_not, {});
    }
  }

  const Quantity& quantity_;
  std::vector<int> held_; ///< lattices that hold the body
};

template<class Run>
Probes timed(const Run& run) {
  const auto start = std::chrono::steady_clock::now();
  Probes probes = run();
  probes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return probes;
}

} // namespace

Probes probe(Lattices& lattices, const Control& control, bool judge_kind) {
  return timed([&] { return Probing(lattices, control).run(judge_kind); });
}

Probes probe_quantity(Lattices& lattices, const Quantity& quantity, const Control& control) {
  return timed([&] { return QuantityProbing(lattices, quantity, control).run(); });
}

RawPrediction predict_raw(const Probes& probes, const Way& way, const Scene* at, std::int64_t nodes) {
  if (!probes.why_not.empty())
    return {};
  const double tolerance = way.tolerance.value_or(0);
  double discretisation = probes.difference * std::exp2(probes.halvings - way.halvings);
  if (probes.growth) { // Richardson extrapolation with the observed order, capped at 2
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
