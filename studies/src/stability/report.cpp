#include "maille/studies/stability.hpp"

#include "stability/extremes.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::studies {

namespace {

std::string short_number(const std::optional<double>& value) {
  return !value ? "-" : *value == 0 ? "0" : fmt::format("{:.2g}", *value);
}

/// What a table in Markdown can hold.
std::string in_a_cell(std::string text, std::size_t longest) {
  std::ranges::replace(text, '\n', ' ');
  std::ranges::replace(text, '|', '/');
  if (text.size() > longest) {
    text.resize(longest);
    while (!text.empty() && (text.back() & 0x80) != 0) // not within a character
      text.pop_back();
    text += " ...";
  }
  return text;
}

std::int64_t n_broken(const std::vector<StabilityCell>& cells) {
  return std::ranges::count_if(cells, [](const StabilityCell& cell) { return !cell.broken.empty(); });
}

void add_checks(const Stability& stability, BenchReport& report) {
  const auto add = [&](const char* name, double value, double goal, bool larger_is_better) {
    report.checks.push_back({name, value, goal, larger_is_better});
  };
  add("cells_total", static_cast<double>(stability.cells.size()), static_cast<double>(stability.cells_asked),
      true);
  add("cells_broken", static_cast<double>(n_broken(stability.cells)), 0, false);
  if (stability.random_scenes > 0) {
    add("random_scenes", static_cast<double>(stability.random_scenes), 10000, true);
    add("random_scenes_broken", static_cast<double>(stability.broken_random_scenes.size()), 0, false);
  }
  constexpr double rounding = 1e-12;
  if (stability.cyclic_drift_relaxed)
    add("cyclic_drift_relaxed", *stability.cyclic_drift_relaxed, rounding, false);
  if (stability.cyclic_drift_coupled)
    add("cyclic_drift_coupled", *stability.cyclic_drift_coupled, rounding, false);
}

constexpr const char* introduction = R"(# Stability at the extremes

Written by `maille stability{} --markdown docs/stability.md`. Every extreme is asked of every method, each in a process of its own.
[promises.md](promises.md) says what each method promises, and which test checks it.

A row is *broken* where a process died or had to be ended, an exception came out, a number of the answer is not finite, a method that
promises to obey the limits does not (beyond rounding), something held has moved, something moved is not where it was asked and nothing says so,
a settled answer is more than 1 % from a known truth (`limits` and `dijkstra`: 1e-6), or a refusal has no reason. `literal` and finite elements promise nothing
about limits, and `literal` no truth.

- *outcome*: settled; clamped (requests cut back to what the limits admit); budget reached (10 s, or the sweeps of the scene: the state is
  usable and not settled); refused or failed, with the reason.
- *violation*: the largest excess of a link over its limits, in rest lengths.
- *iterations*: and in brackets over those of the first row of that method in the table. Nodes or tiles visited for propagation.
- *error*: the largest over the largest true displacement, where a truth is known: closed forms; for `limits` without one, shortest paths; of
  cycles, the drift of the state from that of the first cycle.

)";

std::string row_of(const StabilityCell& cell) {
  const std::string iterations = !cell.violation && cell.iterations == 0 ? "-"
                                 : cell.over_normal
                                     ? fmt::format("{} ({:.2g})", cell.iterations, *cell.over_normal)
                                     : fmt::format("{}", cell.iterations);
  const std::string note =
      cell.broken.empty() ? in_a_cell(cell.note, 150) : "**broken**: " + in_a_cell(cell.broken, 150);
  return fmt::format("| {} | `{}` | {} | {} | {} | {} | {} | {} |\n", cell.setting, cell.method, cell.outcome,
                     short_number(cell.violation),
                     !cell.violation  ? "-"
                     : cell.is_finite ? "yes"
                                      : "**no**",
                     iterations, short_number(cell.error), note);
}

} // namespace

BenchReport stability_report(const Stability& stability) {
  BenchReport report;
  report.machine = describe_machine();
  for (const StabilityCell& cell : stability.cells)
    report.rows.push_back({{"extreme", cell.extreme},
                           {"setting", cell.setting},
                           {"method", cell.method},
                           {"outcome", cell.outcome},
                           {"violation", json_number(cell.violation)},
                           {"finite", cell.is_finite},
                           {"iterations", cell.iterations},
                           {"over_normal", json_number(cell.over_normal)},
                           {"error", json_number(cell.error)},
                           {"seconds", cell.seconds},
                           {"broken", cell.broken},
                           {"note", cell.note}});
  report.notes = stability.broken_random_scenes;
  add_checks(stability, report);
  return report;
}

std::string stability_page(const Stability& stability) {
  std::string page = introduction;
  const std::size_t place = page.find("{}");
  page.replace(place, 2, stability.is_quick ? " --quick" : "");
  if (stability.is_quick)
    page.insert(page.find("[promises.md]"), "This is the bounded version: fewer drags, cycles, random scenes "
                                            "and cells along the longest body than without "
                                            "`--quick` (10,000, 1,000,\n10,000 and 100,000), and no "
                                            "quadratic elements. The tests ask the 10,000 random "
                                            "scenes.\n");
  BenchReport checks;
  add_checks(stability, checks);
  page += "| check | value | goal | met |\n| --- | --- | --- | --- |\n";
  for (const BenchCheck& check : checks.checks)
    page += fmt::format("| `{}` | {:g} | {} {:g} | {} |\n", check.name, check.value,
                        check.larger_is_better ? "at least" : "at most", check.goal,
                        check.met() ? "yes" : "**no**");
  for (const std::string& scene : stability.broken_random_scenes)
    page += "\n```\n" + scene + "\n```\n";
  std::string last;
  for (const StabilityCell& cell : stability.cells) {
    if (cell.extreme != last)
      page += fmt::format("\n## {}\n\n| setting | method | outcome | violation | finite | iterations | error "
                          "| what it says |\n"
                          "| --- | --- | --- | --- | --- | --- | --- | --- |\n",
                          cell.extreme);
    last = cell.extreme;
    page += row_of(cell);
  }
  return page;
}

} // namespace maille::studies
