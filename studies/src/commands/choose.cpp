#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "cli/inputs.hpp"

#include "choose/choose.hpp"
#include "compare/comparison.hpp"
#include "maille/base/arena.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/version.hpp"

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

/// Numbers of a measure: one, three for a vector, one or three per point of a line.
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

/// A measure of the scene as a quantity on any lattice. @pre `lattices` outlives it
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

/// The request, without the quantity of its error.
nlohmann::ordered_json wish_json(const ChooseOptions& options) {
  constexpr const char* an_error = "a percentage such as 5%, or a part of 1 such as 0.05";
  const double error = with_unit("--error", options.error, error_units, an_error);
  if (error >= 1 && !options.error.ends_with('%')) // 5 would be 500 %
    throw UsageError(fmt::format("--error: expected {}, found \"{}\"", an_error, options.error));
  const double seconds =
      with_unit("--time", options.time, time_units, "a time > 0 such as 16ms (units: s, ms, us, min)");
  std::int64_t bytes = available_memory();
  if (options.memory)
    bytes = static_cast<std::int64_t>(
        std::min(with_unit("--memory", *options.memory, memory_units,
                           "a size > 0 such as 1GiB (units: B, KiB, MiB, GiB, kB, MB, GB)"),
                 9e18));
  const double level =
      with_unit("--level", options.level, error_units, "a number between 0 and 1 such as 95%");
  if (level >= 1)
    throw UsageError(
        fmt::format("--level: expected a number between 0 and 1 such as 95%, found \"{}\"", options.level));
  return {{"error", error}, {"seconds", seconds}, {"bytes", bytes}, {"level", level}};
}

/// Value that stands for the tolerance in scene texts until the tolerance is chosen.
constexpr double tolerance_mark = 1.25e-300;

/// Returns the scene texts of all lattices that a file can describe, unchanged and with tolerance_mark.
nlohmann::ordered_json texts_json(Lattices& lattices, int coarsest, int finest) {
  nlohmann::ordered_json texts;
  for (int halvings = coarsest; halvings <= finest; ++halvings) {
    const auto text = lattices.text(halvings, {}), marked = lattices.text(halvings, tolerance_mark);
    texts[fmt::format("{}", halvings)] = {
        {"text", text ? nlohmann::ordered_json(*text) : nlohmann::ordered_json()},
        {"with_tolerance", marked ? nlohmann::ordered_json(*marked) : nlohmann::ordered_json()}};
  }
  return texts;
}

} // namespace

int choose_command(const ChooseOptions& options) {
  keep_inputs({options.scene});
  keep_inputs(options.tables);
  nlohmann::ordered_json wish = wish_json(options);
  auto tables = nlohmann::ordered_json::array();
  for (const auto& table : options.tables)
    tables.push_back(table.string());
  if (const int code = tables.empty()
                           ? exit_done
                           : run_python_program("statistics", {{"kind", "tables"}, {"tables", tables}}))
    return code;
  Lattices lattices(options.scene);
  const Quantity of = asked_quantity(options, lattices);
  wish["of"] = of.name;
  prepare_file("--json", options.json);
  prepare_file("--write", options.write, {}, ".toml");
  if (options.write) // the scene's files must be found from there
    (void)parse_scene(lattices.text(0, {}).value_or(""), *options.write);
  const Control control = terminal_control(options.threads);
  const Probes probes = of.is_displacement() ? probe(lattices, control, options.tables.empty())
                                             : probe_quantity(lattices, of, control);
  // The lattices of the built-in table, and those that a table can have.
  const int coarsest = options.tables.empty() ? -3 : -10, finest = options.tables.empty() ? 1 : 10;
  nlohmann::ordered_json request{{"kind", "choose"},
                                 {"scene", lattices.scene().name},
                                 {"title", lattices.scene().title},
                                 {"maille", version},
                                 {"wish", std::move(wish)},
                                 {"probes", json(probes)},
                                 {"probe_halvings", probes.halvings},
                                 {"why_not", probes.why_not},
                                 {"prospects", nlohmann::ordered_json::array()},
                                 {"texts", nlohmann::ordered_json::object()},
                                 {"tables", std::move(tables)},
                                 {"json", options.json.value_or("")}};
  if (probes.why_not.empty()) {
    request["prospects"] = prospects(lattices, probes, coarsest, finest);
    request["texts"] = texts_json(lattices, coarsest, finest);
  }
  request["options"] = {{"scene", options.scene.string()},
                        {"error", options.error},
                        {"time", options.time},
                        {"of", options.of},
                        {"write", options.write.value_or("")},
                        {"tolerance", lattices.scene().relaxation.tolerance},
                        {"tolerance_mark", fmt::format("{}", tolerance_mark)}};
  end_progress();
  return become_python_program("statistics", request);
}

} // namespace maille::studies
