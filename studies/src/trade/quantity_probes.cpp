// Probes for what the table of trades knows no errors of: three lattices speak for it.
#include "trade/body.hpp"
#include "trade/measure.hpp"
#include "trade/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace maille::studies {

namespace {

constexpr double probing_tolerance = 1e-3;
constexpr double most_probed_cells = 1e6; ///< of lattices finer than the scene's own
constexpr int coarsest = -2, finest = 2;
/// By less, answers that halve the spacing do not come nearer to each other. More than order 2 gives is
/// chance: two of them happen to agree.
constexpr double least_growth = 1.4, largest_growth = 4;
/// Answers that differ by less differ by their algebra.
constexpr double algebra = 2 * probing_tolerance;
constexpr int most_runs = 3;
constexpr double long_enough = 0.005; ///< [s]

class QuantityProbing {
public:
  QuantityProbing(Lattices& lattices, const Quantity& quantity, const Control& control)
      : lattices_(lattices), quantity_(quantity), control_(control) {
    probes_.quantity = quantity.name;
  }

  Probes run() {
    const double thickness = thickness_in_cells(lattices_.scene());
    probes_.lost[coarsest - 1] = "it is coarser than the lattices that speak for it";
    for (int halvings = coarsest; halvings <= finest; ++halvings)
      look_at(halvings, thickness);
    if (!find_lattices() || !find_distances())
      return std::move(probes_);
    time_coupled();
    for (const char* method : {"limits", "relaxed"})
      probes_.of[method].why_not = fmt::format("of coupled alone can an error of {} be promised", what());
    return std::move(probes_);
  }

private:
  const std::string& what() const { return quantity_.name; }

  void look_at(int halvings, double thickness) {
    const double cells = static_cast<double>(lattices_.scene().specimen.grid.n_cells());
    if (halvings > 0 && cells * std::exp2(halvings * lattices_.scene().dimension()) > most_probed_cells)
      return;
    const LatticeScene lattice = lattices_.at(halvings);
    std::string why_not = lattice.why_not;
    if (lattice.scene)
      why_not = what_is_lost(lattices_.scene(), thickness, *lattice.scene, halvings);
    if (why_not.empty())
      held_.push_back(halvings);
    else
      probes_.lost[halvings] = why_not;
  }

  bool is_held(int halvings) const { return std::ranges::find(held_, halvings) != held_.end(); }
  const Scene& at(int halvings) { return *lattices_.at(halvings).scene; }

  /// The elastic answer, without limits; null on failure, and then `why_not`.
  const Answer* elastic(int halvings) {
    if (const auto known = elastic_.find(halvings); known != elastic_.end())
      return &known->second;
    Scene free = with_tolerance(at(halvings), probing_tolerance);
    free.limits = {};
    Answer answer = measure(free, "coupled", {}, control_).answer;
    if (is_converged(answer.status))
      return &(elastic_[halvings] = std::move(answer));
    probes_.why_not = fmt::format("the probe by coupled ended {}{}{}", to_string(answer.status),
                                  answer.message.empty() ? "" : ": ", answer.message);
    return nullptr;
  }

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
    for (int coarse = coarsest; coarse + 2 <= finest; ++coarse) {
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

  bool find_distances() {
    for (const int halvings : held_) {
      if (halvings >= probes_.halvings)
        continue;
      const auto there = difference(halvings, probes_.halvings);
      if (!there) {
        probes_.lost[halvings] = std::exchange(probes_.why_not, {});
        continue;
      }
      probes_.distance[halvings] = *there;
    }
    return true;
  }

  /// Times `coupled` as a later run would do it: within limits, where they bind.
  void time_coupled() {
    const Scene& scene = at(probes_.halvings);
    probes_.nodes = scene.specimen.n_matter_nodes();
    Probes::OfMethod& coupled = probes_.of["coupled"];
    std::vector<double> seconds;
    for (double total = 0; seconds.size() < most_runs && (seconds.size() < 2 || total < long_enough);) {
      const Measured run = measure(scene, "coupled", probing_tolerance, control_);
      if (!is_converged(run.answer.status)) {
        coupled.why_not = fmt::format("coupled {}", to_string(run.answer.status));
        return;
      }
      seconds.push_back(run.answer.seconds.total());
      total += run.wall_seconds;
      if (seconds.size() == 1)
        coupled.model_error =
            quantity_.difference({&scene, &run.answer}, {&scene, elastic(probes_.halvings)}).value_or(0);
    }
    coupled.seconds = median(seconds);
  }

  Lattices& lattices_;
  const Quantity& quantity_;
  const Control& control_;
  std::vector<int> held_; ///< lattices that hold the body
  std::map<int, Answer> elastic_;
  Probes probes_;
};

} // namespace

Probes probe_quantity(Lattices& lattices, const Quantity& quantity, const Control& control) {
  const auto start = std::chrono::steady_clock::now();
  Probes probes = QuantityProbing(lattices, quantity, control).run();
  probes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return probes;
}

} // namespace maille::studies
