#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "results/result_table.hpp"
#include "study/plan/read_parameter.hpp"
#include "text.hpp"

#include "compare/comparison.hpp"
#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "identify/identify.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/warp/displacement_field.hpp"
#include "results/measure_values.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

namespace maille::studies {

namespace {

/// Far below what a step of the search looks at.
constexpr double tolerance_of_answers = 1e-7;

/// A scene whose numbers can be changed.
class ChangedScene {
public:
  explicit ChangedScene(const std::filesystem::path& file)
      : file_(file), document_(parse_toml(read_text_file(file, "a scene file"), file.string())) {}

  /// An unknown from now on. @return what stands there @throws UsageError where that is no number > 0
  NumberWithUnit add(const MaterialConstant& unknown) {
    places_.push_back({unknown, {}});
    const toml::node* node =
        unknown.material.empty() ? node_at(unknown.constant) : node_in_material(places_.back());
    const auto number = number_with_unit(*node);
    if (!number || !(number->number > 0))
      throw UsageError(fmt::format("--unknown: expected a number > 0 at \"{}\", found {}", unknown.constant,
                                   describe(*node)));
    return *number;
  }
  /// @param unknown  number of it, in the order of add()
  void put(std::size_t unknown, double number, const std::string& unit) {
    const Place& place = places_[unknown];
    if (place.tables.empty())
      replace_dotted(document_, place.unknown.constant,
                     unit.empty() ? fmt::format("{:.17g}", number)
                                  : fmt::format("\"{:.17g} {}\"", number, unit));
    for (toml::table* table : place.tables)
      if (unit.empty())
        table->insert_or_assign(place.unknown.constant, number);
      else
        table->insert_or_assign(place.unknown.constant, fmt::format("{:.17g} {}", number, unit));
  }
  std::string text() const {
    std::ostringstream text;
    text << toml::toml_formatter(document_) << "\n";
    return text.str();
  }
  /// @throws InputError
  SceneAndMeasures read() const {
    SceneAndMeasures read = parse_scene_and_measures(text(), file_);
    read.scene.relaxation.tolerance = std::min(read.scene.relaxation.tolerance, tolerance_of_answers);
    return read;
  }

private:
  struct Place {
    MaterialConstant unknown;
    std::vector<toml::table*> tables; ///< none: the key of the scene is the place
  };

  const toml::node* node_at(const std::string& key) {
    const DottedNode found = find_dotted(document_, key);
    if (!found.node)
      throw UsageError(fmt::format(
          "--unknown: expected keys of the scene such as specimen.material.youngs_modulus, or "
          "constants of its materials such as \"E_fibre, E_cross of muscle/soleus\", found \"{}\", "
          "which leads to {}",
          key, found.last.empty() ? "nothing" : "\"" + found.last + "\" and no further"));
    return found.node;
  }
  /// Of matter in several places the first, whose number is that of all from now on.
  const toml::node* node_in_material(Place& place) {
    const auto& [constant, material] = place.unknown;
    try {
      place.tables = tables_of(document_, place.unknown);
    } catch (const std::invalid_argument& wanted) {
      throw UsageError(
          fmt::format("--unknown: expected of {} {}, found \"{}\"", material, wanted.what(), constant));
    }
    if (place.tables.empty())
      throw UsageError(
          fmt::format("--unknown: expected the name of a material in [specimen], of the library or "
                      "that a table has as `name`, found \"{}\"",
                      material));
    return place.tables.front()->get(constant);
  }

  std::filesystem::path file_;
  toml::table document_;
  std::vector<Place> places_;
};

std::string name_of(const MaterialConstant& unknown) {
  return unknown.material.empty() ? unknown.constant : unknown.constant + " of " + unknown.material;
}

std::vector<std::pair<std::string, std::string>> columns_of(const SceneAndMeasures& asked) {
  std::vector<std::pair<std::string, std::string>> columns;
  for (const Measure& measure : asked.measures)
    for (const std::string& name : measure.columns())
      columns.emplace_back(name, unit_of(measure, asked.scene.dimension()));
  return columns;
}

struct ObservedRow {
  const Observation* observation;
  std::string unit;
  std::optional<double> computed;
};

struct UnknownRow {
  const Identified* found;
  double start = 0;
  std::string unit;
};

std::string interval_in_words(const UnknownRow& row) {
  if (!row.found->interval)
    return "-";
  return fmt::format("{:.4g} to {:.4g} {}", row.found->interval->first, row.found->interval->second,
                     row.unit);
}

const ResultTable<UnknownRow>& columns_of_unknowns() {
  static const ResultTable<UnknownRow> table([](ResultTable<UnknownRow>& columns) {
    constexpr auto found = &UnknownRow::found;
    columns.add({"", "unknown", "", "its key in the scene"}, {"unknown", -36}, found, &Identified::name);
    columns.add({"", "unit", "", "as the scene has it; empty: SI, or none"}, &UnknownRow::unit);
    columns.add({"", "start", "", "what the scene has"},
                {"start", 12, [](double value) { return fmt::format("{:.4g}", value); }}, &UnknownRow::start);
    columns.add({"", "value", "", "that fits best"},
                {"value", 12, [](double value) { return fmt::format("{:.5g}", value); }}, found,
                &Identified::value);
    columns.add({"", "low", "", "of the interval of 95 %"}, [](const UnknownRow& row) {
      return row.found->interval ? std::optional(row.found->interval->first) : std::nullopt;
    });
    columns.add({"", "high", "", "of the interval of 95 %"}, [](const UnknownRow& row) {
      return row.found->interval ? std::optional(row.found->interval->second) : std::nullopt;
    });
    columns.add({"", "", "", "of 95 %"}, {"  interval of 95 %", 0},
                [](const UnknownRow& row) { return "  " + interval_in_words(row); });
    columns.add({"", "is_determined", "", "by the data"}, found, &Identified::is_determined);
  });
  return table;
}

const ResultTable<ObservedRow>& columns_of_observations() {
  static const ResultTable<ObservedRow> table([](ResultTable<ObservedRow>& columns) {
    constexpr auto of = &ObservedRow::observation;
    columns.add({"", "measure", "", "its column"}, {"measure", -20}, of, &Observation::column);
    columns.add({"", "unit", "", "SI"}, &ObservedRow::unit);
    columns.add({"", "measured", "", "by the file"}, of, &Observation::value);
    columns.add({"", "sigma", "", "its standard deviation, where the file has it"}, of, &Observation::sigma);
    columns.add({"", "computed", "", "with the values that were found"}, &ObservedRow::computed);
    columns.add({"", "", "", ""}, {"measured", 14},
                [](const ObservedRow& row) { return measure_in_words(row.observation->value, row.unit); });
    columns.add({"", "", "", ""}, {"computed", 14, nullptr, true}, [](const ObservedRow& row) {
      return row.computed ? std::optional(measure_in_words(*row.computed, row.unit)) : std::nullopt;
    });
    columns.add({"", "", "", "computed over measured, less one"}, {"off by", 10, in_percent, true},
                [](const ObservedRow& row) {
                  return row.computed && row.observation->value != 0
                             ? std::optional(*row.computed / row.observation->value - 1)
                             : std::nullopt;
                });
  });
  return table;
}

constexpr std::size_t most_rows = 20; ///< images give more data than a reader can use

/// Those whose computed values are furthest from the measured ones, over sigma where there is one; the worst
/// first.
std::vector<ObservedRow> furthest_off(std::vector<ObservedRow> rows) {
  const auto off = [](const ObservedRow& row) {
    return row.computed
               ? std::abs(*row.computed - row.observation->value) / row.observation->sigma.value_or(1)
               : std::numeric_limits<double>::infinity();
  };
  std::ranges::stable_sort(rows, std::ranges::greater{}, off);
  rows.resize(std::min(rows.size(), most_rows));
  return rows;
}

std::string words(const std::vector<UnknownRow>& unknowns, const std::vector<ObservedRow>& observed,
                  const Identification& found) {
  std::string text = columns_of_unknowns().text(unknowns) + "\n";
  if (observed.size() <= most_rows)
    text += columns_of_observations().text(observed) + "\n";
  else
    text += columns_of_observations().text(furthest_off(observed)) +
            fmt::format("the {} of {} data that are furthest off\n\n", most_rows, observed.size());
  text += fmt::format("{} solves, {}", found.solves, to_string(found.status));
  if (!found.message.empty())
    text += ": " + found.message;
  text += "\n";
  if (found.sigma_is_known && found.freedom > 0)
    text += fmt::format(
        "misfit {:.3g} with {} degrees of freedom: about 1 each where model and sigmas are right\n",
        found.misfit, found.freedom);
  else if (!found.sigma_is_known && found.freedom > 0)
    text +=
        "no sigma in the file: intervals take what is left for the error of the data, alike in per cent\n";
  else if (!found.sigma_is_known)
    text += "as many data as unknowns, and no sigma: nothing tells how sure the values are\n";
  return text;
}

nlohmann::ordered_json in_json(const Scene& scene, const std::string& method,
                               const std::vector<UnknownRow>& unknowns,
                               const std::vector<ObservedRow>& observed, const Identification& found) {
  nlohmann::ordered_json out{{"scene", scene.name},
                             {"method", method},
                             {"status", to_string(found.status)},
                             {"message", found.message},
                             {"solves", found.solves},
                             {"misfit", found.misfit},
                             {"degrees_of_freedom", found.freedom},
                             {"sigma_is_known", found.sigma_is_known}};
  out["unknowns"] = columns_of_unknowns().json_rows(unknowns);
  out["observations"] = columns_of_observations().json_rows(observed);
  return out;
}

} // namespace

namespace {

std::optional<double> sigma_of(const FitOptions& options) {
  if (!options.sigma)
    return std::nullopt;
  const auto sigma = parse_quantity(*options.sigma, Dimension::length);
  if (!sigma || !(*sigma > 0))
    throw UsageError("--sigma: expected a length > 0 such as \"0.1 mm\", found \"" + *options.sigma + "\"");
  return sigma;
}

} // namespace

int identify_command(const FitOptions& options) {
  if (options.scenes.size() != 1)
    throw UsageError(fmt::format("--measured: expected one scene, found {}", options.scenes.size()));
  const std::string method = options.method.empty() ? "coupled" : options.method;
  keep_inputs({options.scenes.front(), options.measured});
  check_methods({method}, "--method");
  if (!has_stress(method))
    throw UsageError("--method: expected one that knows forces, such as coupled, found \"" + method + "\"");
  ChangedScene scene(options.scenes.front());
  SceneAndMeasures asked = scene.read();
  const std::string text = is_image_file(options.measured)
                               ? std::string{}
                               : read_text_file(options.measured, "a table of measured numbers");
  const bool is_of_places = is_image_file(options.measured) || is_table_of_points(text);
  if (options.sigma && !is_of_places)
    throw UsageError(
        "--sigma: expected an image or points of displacements with it, found a table of measures, "
        "which has a column of its own");
  DisplacementData data;
  if (is_of_places) {
    data = read_displacement_data(options.measured, sigma_of(options), asked.scene);
    asked.measures = data.measures;
  }
  const auto columns = columns_of(asked);
  if (columns.empty())
    throw UsageError("SCENE: expected [[measure]] tables, which say what was measured, found none");
  std::vector<Unknown> unknowns;
  std::vector<NumberWithUnit> starts;
  for (const MaterialConstant& unknown : constants_in(options.unknowns)) {
    starts.push_back(scene.add(unknown));
    unknowns.push_back({name_of(unknown), starts.back().number});
  }
  const std::vector<Observation> observations =
      is_of_places ? data.observations : read_observations(text, options.measured, columns);
  if (observations.size() < unknowns.size())
    throw UsageError(
        fmt::format("--measured: expected at least as many numbers as there are unknowns, {}, found {}",
                    unknowns.size(), observations.size()));
  if (std::ranges::all_of(observations, [](const Observation& one) { return one.value == 0 && !one.sigma; }))
    throw UsageError("--measured: expected a number that is not 0, or sigmas, found zeros alone");
  prepare_file("--json", options.json);
  prepare_file("--out", options.out);
  const Control control = terminal_control(options.threads);
  Control quiet;
  quiet.threads = control.threads;
  quiet.stop_requested = control.stop_requested;
  std::string refusal;
  Methods solver;
  const Model model = [&](const std::vector<double>& values) -> std::optional<std::vector<double>> {
    for (std::size_t i = 0; i < values.size(); ++i)
      scene.put(i, values[i], starts[i].unit);
    try {
      const SceneAndMeasures now = scene.read();
      const Answer answer = solver.answer(now.scene, method, quiet);
      if (!is_converged(answer.status)) {
        refusal = fmt::format("{}: {}", to_string(answer.status), answer.message);
        return std::nullopt;
      }
      std::vector<double> numbers;
      if (is_of_places) { // in the order of the observations
        for (const MeasuredValue& value : measured(now.scene, data.measures, answer))
          for (std::size_t a = 0; a < static_cast<std::size_t>(now.scene.dimension()); ++a)
            numbers.push_back(value.vector ? (*value.vector)[a] : NAN);
        return numbers;
      }
      const auto all = measured_answer(now.scene, now.measures, answer);
      for (const Observation& one : observations)
        for (const MeasuredValue& value : all)
          for (const auto& [name, number] : value.columns())
            if (name == one.column)
              numbers.push_back(number.value_or(NAN));
      return numbers;
    } catch (const InputError& error) {
      refusal = error.what();
      return std::nullopt;
    }
  };
  Identification found = identify(unknowns, observations, model, {}, control);
  end_progress();
  if (found.status == IdentifyStatus::failed && !refusal.empty())
    found.message += ": " + refusal;
  std::vector<UnknownRow> rows;
  for (std::size_t i = 0; i < found.unknowns.size(); ++i)
    rows.push_back({&found.unknowns[i], starts[i].number, starts[i].unit});
  std::vector<ObservedRow> observed;
  const std::map<std::string, std::string> unit_of_column(columns.begin(), columns.end());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    observed.push_back({&observations[i], unit_of_column.at(observations[i].column),
                        i < found.computed.size() ? std::optional(found.computed[i]) : std::nullopt});
  }
  const bool is_quiet = options.json == "-";
  if (!is_quiet)
    deliver(words(rows, observed, found), std::nullopt);
  constexpr std::size_t most_in_json = 1000;
  observed.resize(std::min(observed.size(), most_in_json));
  if (options.json)
    deliver(json_text(in_json(asked.scene, method, rows, observed, found)), options.json);
  if (options.out && found.status == IdentifyStatus::done) {
    for (std::size_t i = 0; i < rows.size(); ++i)
      scene.put(i, found.unknowns[i].value, starts[i].unit);
    write_whole(*options.out, scene.text());
    if (!is_quiet)
      fmt::print("wrote {}\n", *options.out);
  }
  return found.status == IdentifyStatus::done ? exit_done : exit_run_failed;
}

} // namespace maille::studies
