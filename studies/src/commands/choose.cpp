#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "cli/inputs.hpp"

#include "choose/choose.hpp"
#include "compare/comparison.hpp"
#include "export/whole_file.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace maille::studies {

namespace {

struct Unit {
  std::string_view name;
  double factor;
};
constexpr std::array<Unit, 3> error_units{{{"", 1}, {"%", 1e-2}, {" %", 1e-2}}};
constexpr std::array<Unit, 5> time_units{{{"", 1}, {"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}}};
constexpr std::array<Unit, 8> memory_units{{{"", 1},
                                            {"B", 1},
                                            {"KiB", 1024.0},
                                            {"MiB", 1048576.0},
                                            {"GiB", 1073741824.0},
                                            {"kB", 1e3},
                                            {"MB", 1e6},
                                            {"GB", 1e9}}};

/// A number > 0 and a unit, with or without a space between them. @throws UsageError
template<std::size_t n>
double with_unit(const std::string& option, const std::string& text, const std::array<Unit, n>& units,
                 const char* expected) {
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  std::string_view rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  for (const Unit& unit : units)
    if (fault == std::errc() && rest == unit.name && std::isfinite(value * unit.factor) && value > 0)
      return value * unit.factor;
  throw UsageError(fmt::format("{}: expected {}, found \"{}\"", option, expected, text));
}

/// All that a measure comes to: one number, three of a vector, one or three a point of a line.
std::vector<double> numbers_of(const MeasuredValue& found) {
  std::vector<double> numbers;
  const auto add = [&](const std::optional<double>& value, const std::optional<Vec3>& vector) {
    if (vector)
      numbers.insert(numbers.end(), vector->begin(), vector->end());
    else if (value)
      numbers.push_back(*value);
  };
  if (!found.is_line)
    add(found.value, found.vector);
  for (const LinePoint& point : found.line)
    add(point.value, point.vector);
  return numbers;
}

/// What the scene asks for by name, on any of its lattices. @pre `lattices` outlives it
Quantity measure_as_quantity(const Lattices& lattices, const std::string& name) {
  return quantity_of(name, [&lattices, name](const Scene& scene, const Answer& answer) {
    const std::vector<Measure> measures = lattices.measures_on(scene);
    const auto found = std::ranges::find(measures, name, &Measure::name);
    return found == measures.end() ? std::vector<double>{}
                                   : numbers_of(measured_answer(scene, {*found}, answer).front());
  });
}

/// @throws UsageError
Quantity asked_quantity(const ChooseOptions& options, const Lattices& lattices) {
  if (const auto found = quantity_named(options.of))
    return *found;
  std::vector<std::string> names;
  for (const Quantity& quantity : every_quantity())
    names.push_back(quantity.name);
  for (const Measure& measure : lattices.measures())
    names.push_back(measure.name);
  if (std::ranges::find(names, options.of) != names.end())
    return measure_as_quantity(lattices, options.of);
  throw UsageError(fmt::format("--of: expected one of {}, found \"{}\"{}", fmt::join(names, ", "), options.of,
                               did_you_mean(options.of, names)));
}

/// All of it but what the error is of.
Wish wish_of(const ChooseOptions& options) {
  Wish wish;
  constexpr const char* an_error = "a percentage such as 5%, or a part of 1 such as 0.05";
  wish.error = with_unit("--error", options.error, error_units, an_error);
  if (wish.error >= 1 && !options.error.ends_with('%')) // 5 would be 500 %
    throw UsageError(fmt::format("--error: expected {}, found \"{}\"", an_error, options.error));
  wish.seconds =
      with_unit("--time", options.time, time_units, "a time > 0 such as 16ms (units: s, ms, us, min)");
  if (options.memory) {
    const double bytes = with_unit("--memory", *options.memory, memory_units,
                                   "a size > 0 such as 1GiB (units: B, KiB, MiB, GiB, kB, MB, GB)");
    wish.bytes = static_cast<std::int64_t>(std::min(bytes, 9e18));
  }
  wish.level = with_unit("--level", options.level, error_units, "a number between 0 and 1 such as 95%");
  if (wish.level >= 1)
    throw UsageError(
        fmt::format("--level: expected a number between 0 and 1 such as 95%, found \"{}\"", options.level));
  return wish;
}

/// What to type to have the choice done; writes the scene where --write asks for it.
std::string how_to_do_it(const ChooseOptions& options, const Lattices& lattices, const Candidate& chosen) {
  const Way& way = chosen.way;
  const bool has_own_tolerance = way.method != "fem_q1" && way.method != "fem_q2" && way.tolerance &&
                                 *way.tolerance != lattices.scene().relaxation.tolerance;
  if (!options.write && way.halvings == 0 && !has_own_tolerance)
    return fmt::format("    maille run {} --methods {}\n", in_shell(options.scene.string()), way.method);
  const auto text = lattices.text(way.halvings, has_own_tolerance ? way.tolerance : std::nullopt);
  if (!text)
    return "    no scene file says its lattice: finer ones are those of the scene's own cells, halved\n";
  const std::filesystem::path default_name =
      options.scene.parent_path() / (options.scene.stem().string() + "_chosen.toml");
  const std::filesystem::path file = options.write ? std::filesystem::path(*options.write) : default_name;
  const std::string then =
      fmt::format("    maille run {} --methods {}\n", in_shell(file.string()), way.method);
  if (options.write) {
    (void)parse_scene(*text, file); // its files have to be found from there
    write_whole(file, *text);
    return fmt::format("wrote {}\n{}", file.string(), then);
  }
  return fmt::format("    maille study choose {} --error {}{} --time {} --write {}\n{}",
                     in_shell(options.scene.string()), in_shell(options.error),
                     options.of == Quantity{}.name ? "" : " --of " + options.of, in_shell(options.time),
                     in_shell(file.string()), then);
}

} // namespace

int choose_command(const ChooseOptions& options) {
  keep_inputs({options.scene});
  keep_inputs(options.tables);
  Wish wish = wish_of(options);
  std::vector<StoredRow> rows;
  for (const auto& file : options.tables) {
    const auto more = read_trade_table(file);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  if (options.tables.empty())
    rows = built_in_trade_table();
  Lattices lattices(options.scene);
  wish.of = asked_quantity(options, lattices);
  prepare_file("--json", options.json);
  prepare_file("--write", options.write);
  const Choice choice =
      choose(lattices, wish, Calibration(rows), terminal_control(options.threads), options.tables.empty());
  end_progress();
  const std::string way =
      choice.chosen ? "\nto do it:\n" + how_to_do_it(options, lattices, *choice.chosen) : "";
  if (options.json != "-")
    deliver(table(lattices.scene(), choice) + way, std::nullopt);
  if (options.json)
    deliver(json_text(json(lattices.scene(), choice)), options.json);
  return choice.chosen ? exit_done : exit_run_failed;
}

} // namespace maille::studies
