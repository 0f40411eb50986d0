#include "choose/choose.hpp"

#include "maille/base/arena.hpp"
#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "trade/measure.hpp"
#include "trade/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Finer lattices than this are not built only to ask what finite elements would take there.
constexpr double most_cells = 2e6;

std::int64_t bytes_for(const Scene& scene, const std::string& method) {
  if (!is_finite_elements(method))
    return deform::bytes_needed(scene, method);
  fem_ref::Options options;
  options.degree = method == "fem_q2" ? 2 : 1;
  return static_cast<std::int64_t>(fem_ref::estimate(scene, options).bytes);
}

/// Without the table, the promised range is the expected value times and divided by this factor.
constexpr double margin_without_table = 2;

/// Why nothing is said about a way on a lattice that exists; empty where something is.
std::string why_left_out(const Probes& probes, const Way& way) {
  const auto probed = probes.of.find(way.method);
  if (const auto lost = probes.lost.find(way.halvings); lost != probes.lost.end())
    return lost->second;
  if (is_finite_elements(way.method) && !probes.quantity.empty())
    return fmt::format("of finite elements the table alone knows, and it holds no errors of {}",
                       probes.quantity);
  if (is_finite_elements(way.method))
    return probes.growth ? "of finite elements the table alone knows, and the scene is unlike its own" : "";
  return probed == probes.of.end() ? "it is not probed" : probed->second.why_not;
}

/// Looks through the ways of one scene.
class Search {
public:
  Search(Lattices& lattices, const Calibration& calibration, Choice& choice)
      : lattices_(lattices), calibration_(calibration), choice_(choice) {}

  void consider(const Way& way) {
    if (std::string reason = why_left_out(choice_.probes, way); !reason.empty())
      return leave_out(way, reason);
    const double growth = std::exp2(way.halvings * lattices_.scene().dimension());
    if (growth > 1 && static_cast<double>(lattices_.scene().specimen.grid.n_cells()) * growth > most_cells)
      return leave_out(way, "its lattice is too large to look at");
    const LatticeScene lattice = lattices_.at(way.halvings);
    if (!lattice.scene)
      return leave_out(way, lattice.why_not);
    add(way, *lattice.scene);
  }

private:
  void leave_out(const Way& way, const std::string& reason) {
    std::string line =
        fmt::format("{} at {:g} times the spacing: {}", way.method, std::exp2(-way.halvings), reason);
    if (std::ranges::find(choice_.left_out, line) == choice_.left_out.end()) // once for all tolerances
      choice_.left_out.push_back(std::move(line));
  }

  void add(const Way& way, const Scene& scene) {
    Candidate candidate;
    candidate.way = way;
    candidate.cells = scene.specimen.grid.cells();
    candidate.spacing = scene.specimen.grid.spacing();
    candidate.nodes = scene.specimen.n_matter_nodes();
    const RawPrediction raw = predict_raw(choice_.probes, way, &scene, candidate.nodes);
    if (!raw.error || !raw.seconds)
      return leave_out(way, "nothing is known about it");
    const double level = choice_.wish.level;
    const Way known = as_in_the_table(way);
    candidate.seconds = calibration_.seconds(
        is_finite_elements(way.method) && calibration_.knows(way) ? way : known, *raw.seconds, level);
    if (choice_.probes.growth)
      candidate.error = {*raw.error, *raw.error / margin_without_table, *raw.error * margin_without_table};
    else if (known.halvings == way.halvings - shift())
      candidate.error = calibration_.error(known, *raw.error, level);
    else
      return leave_out(way, "the table does not know it for probes so fine");
    candidate.bytes = bytes_for(scene, way.method);
    choice_.candidates.push_back(std::move(candidate));
  }

  /// Lattices by which the probes are finer than those of the table, at twice the spacing.
  int shift() const { return choice_.probes.halvings + 1; }
  /// The way of the table that is as much finer than its probes as `way` is than these; the nearest that it
  /// has.
  Way as_in_the_table(const Way& way) const {
    Way known = way;
    for (known.halvings -= shift(); known.halvings < way.halvings && !calibration_.knows(known);)
      ++known.halvings;
    return known;
  }

  Lattices& lattices_;
  const Calibration& calibration_;
  Choice& choice_;
};

} // namespace

bool Candidate::meets(const Wish& wish) const {
  return error.high <= wish.error && seconds.high <= wish.seconds && (!wish.bytes || bytes <= *wish.bytes);
}

void pick(Choice& choice) {
  const Wish& wish = choice.wish;
  const auto keep_if_better = [](std::optional<Candidate>& best, const Candidate& candidate, double value,
                                 double best_value) {
    if (!best || value < best_value)
      best = candidate;
  };
  for (const Candidate& candidate : choice.candidates) {
    if (candidate.meets(wish)) {
      choice.chosen = candidate;
      choice.most_exact_in_time.reset();
      choice.quickest_to_error.reset();
      return;
    }
    if (wish.bytes && candidate.bytes > *wish.bytes)
      continue;
    auto &exact = choice.most_exact_in_time, &quick = choice.quickest_to_error;
    if (candidate.seconds.high <= wish.seconds)
      keep_if_better(exact, candidate, candidate.error.high, exact ? exact->error.high : 0);
    if (candidate.error.high <= wish.error)
      keep_if_better(quick, candidate, candidate.seconds.high, quick ? quick->seconds.high : 0);
  }
}

Choice choose(Lattices& lattices, const Wish& wish, const Calibration& calibration, const Control& control,
              bool judge_kind) {
  Choice choice;
  choice.wish = wish;
  if (!choice.wish.bytes)
    choice.wish.bytes = available_memory();
  choice.scenes = calibration.n_scenes();
  choice.probes = wish.of.is_displacement() ? probe(lattices, control, judge_kind)
                                            : probe_quantity(lattices, wish.of, control);
  if (!choice.probes.why_not.empty())
    return choice;
  Search search(lattices, calibration, choice);
  for (const Way& way : calibration.ways())
    search.consider(way);
  std::ranges::stable_sort(choice.candidates, {}, [](const Candidate& c) { return c.seconds.median; });
  pick(choice);
  return choice;
}

} // namespace maille::studies
