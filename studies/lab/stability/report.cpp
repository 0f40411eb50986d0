#include "results/value.hpp"
#include "stability/columns.hpp"
#include "stability/questions.hpp"
#include "stability/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace maille::lab {

namespace {

std::string short_number(double value) {
  return value == 0 ? "0" : fmt::format("{:.2g}", value);
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
  const auto add = [&](const char* name, double value) { report.checks.push_back({name, value}); };
  report.checks.push_back({"cells_total", static_cast<double>(stability.cells.size()), "", "",
                           static_cast<double>(stability.cells_asked)});
  add("cells_broken", static_cast<double>(n_broken(stability.cells)));
  if (stability.random_scenes > 0) {
    add("random_scenes", static_cast<double>(stability.random_scenes));
    add("random_scenes_broken", static_cast<double>(stability.broken_random_scenes.size()));
  }
  if (stability.random_worlds > 0) {
    add("random_worlds", static_cast<double>(stability.random_worlds));
    add("random_worlds_broken", static_cast<double>(stability.broken_random_worlds.size()));
  }
  if (stability.cyclic_drift_relaxed)
    add("cyclic_drift_relaxed", *stability.cyclic_drift_relaxed);
  if (stability.cyclic_drift_coupled)
    add("cyclic_drift_coupled", *stability.cyclic_drift_coupled);
}

constexpr const char* introduction = R"(# Stability at the extremes

Written by `studies/lab/run stability{} --markdown docs/stability.md`. Every extreme is asked of every method, each in a process of its own.
Every setting of one: `studies/lab/run stability --only 'NAME' --markdown FILE`; of all: `--json`.
[promises.md](promises.md) says what each method promises, and which test checks it.

A row is *broken* where a process died or had to be ended, an exception came out, a number of the answer is not finite, a method that
promises to obey the limits does not (beyond rounding), something held has moved, something moved is not where it was asked and nothing says so,
a settled answer is more than 1 % from a known truth (`limits` and `dijkstra`: 1e-6), or a refusal has no reason. `literal` and finite elements promise nothing
about limits, and `literal` no truth.
Rows of `worlds: ...` are plays of several objects: there a row is broken where after any frame matter is in other matter or outside the world
(judged by boxes and deformed cells, without the map), a cell is of two objects, a limit does not hold, a number is not finite, a frame has no status or no reason
for one, something has left a closed room, friction holds more than Coulomb's law grants, forces on what is free do not add up to nothing (surfaces), or energy comes from nowhere (dynamics).

- *outcome*: settled; clamped (requests cut back to what the limits permit); budget reached (10 s, or the sweeps of the scene: the state is
  usable and not settled); refused or failed, with the reason.
- *violation*: the largest excess of a link over its limits, in rest lengths.
- *iterations*: and in brackets over those of the first row of that method in the table. Nodes or tiles visited for propagation.
- *error*: the largest over the largest true displacement, where a truth is known: closed forms; for `limits` without one, shortest paths; of
  cycles, the drift of the state from that of the first cycle.

)";

/// "5 settled, 2 clamped"
std::string counted_outcomes(std::span<const StabilityCell> cells, const std::string& method) {
  std::vector<std::pair<std::string, int>> counts;
  for (const StabilityCell& cell : cells) {
    if (cell.method != method)
      continue;
    const auto known = std::ranges::find(counts, cell.outcome, &std::pair<std::string, int>::first);
    if (known != counts.end())
      ++known->second;
    else
      counts.emplace_back(cell.outcome, 1);
  }
  std::string words;
  for (const auto& [outcome, n] : counts)
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", n, outcome);
  return words.empty() ? "-" : words;
}

/// Rows of one extreme, which stand together.
std::vector<std::span<const StabilityCell>> by_extreme(const std::vector<StabilityCell>& cells) {
  std::vector<std::span<const StabilityCell>> parts;
  for (auto first = cells.begin(); first != cells.end();) {
    const auto next = std::find_if(first, cells.end(),
                                   [&](const StabilityCell& cell) { return cell.extreme != first->extreme; });
    parts.emplace_back(first, next);
    first = next;
  }
  return parts;
}

/// A line an extreme: how its settings ended, and the largest error of `coupled` where a truth is known.
std::string overview(const std::vector<StabilityCell>& cells) {
  constexpr std::array methods{"limits", "relaxed", "coupled", "fem_q1"};
  std::string table =
      "\n| extreme | `limits` | `relaxed` | `coupled` | error of `coupled`, at most | `fem_q1` | broken |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n";
  for (const std::span<const StabilityCell> part : by_extreme(cells)) {
    double largest = -1;
    for (const StabilityCell& cell : part)
      if (cell.method == "coupled" && cell.outcome == "settled")
        largest = std::max(largest, cell.error.value_or(-1));
    std::array<std::string, methods.size()> outcomes;
    for (std::size_t m = 0; m < methods.size(); ++m)
      outcomes[m] = counted_outcomes(part, methods[m]);
    table += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", part.front().extreme, outcomes[0],
                         outcomes[1], outcomes[2], largest < 0 ? "-" : short_number(largest), outcomes[3],
                         std::ranges::count_if(part, [](const auto& cell) { return !cell.broken.empty(); }));
  }
  return table;
}

std::string iterations_of(const StabilityCell& cell) {
  if (!cell.violation && cell.iterations == 0)
    return "-";
  return fmt::format("{}{}", cell.iterations,
                     cell.over_normal ? fmt::format(" ({:.2g})", *cell.over_normal) : "");
}

std::string note_of(const StabilityCell& cell) {
  return cell.broken.empty() ? in_a_cell(cell.note, 150) : "**broken**: " + in_a_cell(cell.broken, 150);
}

std::string finite_of(const StabilityCell& cell) {
  return !cell.violation ? "-" : cell.is_finite ? "yes" : "**no**";
}

} // namespace

const ResultTable<StabilityCell>& columns_of_stability() {
  static const ResultTable<StabilityCell> table([](ResultTable<StabilityCell>& columns) {
    using Cell = StabilityCell;
    columns.add({"", "extreme", "", "its name"}, &Cell::extreme);
    columns.add({"", "setting", "", "of the extreme"}, {"setting"}, &Cell::setting);
    columns.add({"", "method", "", "that was asked"}, &Cell::method);
    columns.add({}, {"method"}, [](const Cell& cell) { return "`" + cell.method + "`"; });
    columns.add({"", "outcome", "", "how it ended"}, {"outcome"}, &Cell::outcome);
    columns.add({"", "violation", "", "in rest lengths"}, {"violation", 0, short_number}, &Cell::violation);
    columns.add({"", "finite", "", "every number"}, &Cell::is_finite);
    columns.add({}, {"finite"}, finite_of);
    columns.add({"", "iterations", "", "of the method"}, &Cell::iterations);
    columns.add({}, {"iterations"}, iterations_of);
    columns.add({"", "over_normal", "", "those of the normal setting"}, &Cell::over_normal);
    columns.add({"", "error", "", "over the largest displacement"}, {"error", 0, short_number}, &Cell::error);
    columns.add({"", "seconds", "s", "by the clock"}, &Cell::seconds);
    columns.add({"", "broken", "", "which promise"}, &Cell::broken);
    columns.add({"", "note", "", "what the method says"}, &Cell::note);
    columns.add({}, {"what it says"}, note_of);
  });
  return table;
}

BenchReport stability_report(const Stability& stability) {
  BenchReport report;
  report.machine = describe_machine();
  for (const StabilityCell& cell : stability.cells)
    report.rows.push_back(columns_of_stability().json(cell));
  report.notes = stability.broken_random_scenes;
  report.notes.insert(report.notes.end(), stability.broken_random_worlds.begin(),
                      stability.broken_random_worlds.end());
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
  page += place_of_checks;
  for (const auto* const broken : {&stability.broken_random_scenes, &stability.broken_random_worlds})
    for (const std::string& question : *broken)
      page += "\n```\n" + question + "\n```\n";
  const bool is_whole = by_extreme(stability.cells).size() == stability_extremes().size();
  if (is_whole)
    page += overview(stability.cells);
  for (const std::span<const StabilityCell> part : by_extreme(stability.cells)) {
    std::vector<StabilityCell> shown(part.begin(), part.end());
    if (is_whole) // of all extremes, only what broke
      std::erase_if(shown, [](const StabilityCell& cell) { return cell.broken.empty(); });
    if (!shown.empty())
      page += fmt::format("\n## {}\n\n", part.front().extreme) + columns_of_stability().markdown(shown);
  }
  return page;
}

} // namespace maille::lab
