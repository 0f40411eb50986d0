/// Reading of a study file to a StudyFile, or to all errors in it and its scenes.

#include "compare/methods.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"
#include "study/plan/formula.hpp"
#include "study/plan/read_parameter.hpp"
#include "study/plan/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

class StudyReader {
public:
  StudyReader(std::string_view text, const fs::path& file)
      : file_(file), document_(parse_toml(text, file.string())), faults_(file.string()),
        root_(document_, "", faults_, "study") {}

  /// @throws InputError
  StudyFile read() {
    StudyFile study;
    study.file = file_;
    study.title = root_.text("title").value_or(file_.stem().string());
    read_scenes(study);
    read_methods(study);
    read_plan(study);
    read_parameters(study);
    read_vtk(study);
    root_.finish();
    throw_if_any();
    return study;
  }

private:
  void read_scenes(StudyFile& study);
  void read_scene_of(StudyFile& study, const fs::path& file);
  static void add_measures(const SceneAndMeasures& read, StudyFile& study);
  void read_methods(StudyFile& study);
  void read_plan(StudyFile& study);
  void read_parameters(StudyFile& study);
  void read_vtk(StudyFile& study);
  void check_sizes(const StudyFile& study);
  /// Throws the errors, those of the study first.
  void throw_if_any();

  fs::path file_;
  toml::table document_;
  FaultList faults_;
  TableReader root_;
  std::vector<Fault> of_scenes_;
};

void StudyReader::read_scenes(StudyFile& study) {
  constexpr const char* expected = "a scene file, or a list of them, relative to the study";
  const toml::node* node = root_.require("scene", expected);
  if (!node)
    return;
  constexpr std::size_t most_scenes = 10'000;
  const std::vector<std::string> names = texts_of(*node, "scene", expected, faults_);
  if (names.size() > most_scenes)
    return root_.fault("scene", fmt::format("at most {} scenes", most_scenes),
                       fmt::format("{}", names.size()));
  // Check names before reading.
  std::vector<fs::path> files;
  std::set<std::string> stems, twice;
  for (const std::string& name : names) {
    NamedFile named = named_file(name, file_.parent_path());
    if (std::error_code no_matter; !named.file.empty() && fs::exists(named.file, no_matter) &&
                                   !fs::is_regular_file(named.file, no_matter) &&
                                   !fs::is_directory(named.file, no_matter)) {
      root_.fault("scene", "scene files", fmt::format("\"{}\", which is a pipe or a device", name));
      named.file.clear(); // a pipe would block
    } else if (named.file.empty())
      root_.fault("scene", named.expected, named.found);
    else if (!stems.insert(named.file.stem().string()).second)
      twice.insert(named.file.stem().string());
    files.push_back(std::move(named.file));
  }
  for (const std::string& name : twice)
    root_.fault("scene", "scenes of different names", fmt::format("{} twice", name));
  if (twice.empty())
    for (const fs::path& file : files)
      if (!file.empty())
        read_scene_of(study, file);
}

/// Adds columns that no earlier scene has.
void StudyReader::add_measures(const SceneAndMeasures& read, StudyFile& study) {
  for (const Measure& measure : read.measures) {
    std::vector<MeasureColumn> columns;
    for (std::string& name : measure.columns())
      columns.push_back({std::move(name), std::string(unit_of(measure, read.scene.dimension()))});
    columns.push_back({measure.name + "_error", ""});
    for (MeasureColumn& column : columns)
      if (std::ranges::find(study.measures, column.name, &MeasureColumn::name) == study.measures.end())
        study.measures.push_back(std::move(column));
  }
}

void StudyReader::read_scene_of(StudyFile& study, const fs::path& file) {
  try {
    std::string text = read_text_file(file, "a scene file");
    const SceneAndMeasures read = parse_scene_and_measures(text, file);
    add_measures(read, study);
    study.scenes.push_back({file, std::move(text)});
  } catch (const InputError& error) {
    of_scenes_.insert(of_scenes_.end(), error.faults().begin(), error.faults().end());
  }
}

void StudyReader::read_methods(StudyFile& study) {
  const std::string choices = fmt::format("{}", fmt::join(all_methods(), ", "));
  const std::string expected = "methods: some of " + choices;
  if (const toml::node* node = root_.require("methods", expected))
    study.methods = texts_of(*node, "methods", expected, faults_);
  for (std::size_t i = 0; i < study.methods.size(); ++i) {
    if (!is_method(study.methods[i]))
      root_.fault("methods", "some of " + choices, fmt::format("\"{}\"", study.methods[i]));
    if (std::find(study.methods.begin(), study.methods.begin() + static_cast<std::ptrdiff_t>(i),
                  study.methods[i]) != study.methods.begin() + static_cast<std::ptrdiff_t>(i))
      root_.fault("methods", "each method once", fmt::format("\"{}\" twice", study.methods[i]));
  }
  study.reference = root_.text("reference").value_or(default_reference(study.methods));
  if (study.reference == "none")
    study.reference.clear();
  else if (study.reference != "best" && !is_method(study.reference))
    root_.fault("reference", "best, none, or one of " + choices, fmt::format("\"{}\"", study.reference));
  if (root_.has("reference_seconds")) {
    const auto seconds = root_.quantity("reference_seconds", Dimension::dimensionless);
    study.reference_seconds = seconds.value_or(study.reference_seconds);
    if (seconds && (*seconds <= 0 || study.reference != "best"))
      root_.fault("reference_seconds", "a number > 0 beside reference = \"best\"",
                  fmt::format("{} and \"{}\"", *seconds, study.reference));
  }
  root_.read("repetitions", study.repetitions);
}

void StudyReader::read_plan(StudyFile& study) {
  root_.read("combine", study.combination);
  if (is_drawn_plan(study.combination)) {
    root_.require("samples");
    study.samples = static_cast<int>(root_.whole("samples").value_or(1));
  } else
    root_.refuse("samples", "no such key unless combine is latin_hypercube, sobol or saltelli");
  if (study.combination == Combination::latin_hypercube)
    study.seed = static_cast<std::uint64_t>(root_.whole("seed").value_or(1));
  else
    root_.refuse("seed", "no such key unless combine is latin_hypercube");
}

void StudyReader::read_parameters(StudyFile& study) {
  const toml::node* node = root_.find("parameter");
  if (!node)
    return;
  const toml::array* list = node->as_array();
  if (!list || !list->is_array_of_tables()) {
    root_.fault("parameter", "[[parameter]] tables");
    return;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    TableReader table(*(*list)[i].as_table(), fmt::format("parameter[{}]", i + 1), faults_, "parameter");
    if (auto parameter = read_parameter(table, study))
      (parameter->formula.empty() ? study.parameters : study.formulas).push_back(std::move(*parameter));
  }
  std::set<std::string> named;
  for (const StudyParameter& formula : study.formulas)
    for (const std::string& name : names_in_formula(formula.formula))
      named.insert(name);
  for (std::size_t i = 0; i < study.n_varied(); ++i) {
    const StudyParameter& parameter = study.varied(i);
    if (std::ranges::find(study.measures, parameter.column(), &MeasureColumn::name) != study.measures.end())
      root_.fault("parameter", "parameters whose names are no columns of a measure of the scenes",
                  "\"" + parameter.column() + "\"");
    if (parameter.keys.empty() && !named.contains(parameter.label) && faults_.empty())
      root_.fault("parameter", "a key, or a formula that names the parameter", "\"" + parameter.label + "\"");
  }
  check_sizes(study);
}

void StudyReader::check_sizes(const StudyFile& study) {
  constexpr double most = 1e6;
  double n = static_cast<double>(std::max<std::size_t>(study.scenes.size(), 1));
  if (is_drawn_plan(study.combination))
    n *= study.samples;
  if (study.combination == Combination::saltelli)
    n *= static_cast<double>(study.parameters.size()) + 2;
  for (const StudyParameter& parameter : study.parameters) {
    if (study.combination == Combination::grid)
      n *= static_cast<double>(parameter.values.size());
    if (study.combination == Combination::zip &&
        parameter.values.size() != study.parameters.front().values.size())
      root_.fault("parameter", "as many values of every parameter: they are zipped",
                  fmt::format("{} of {} and {} of {}", study.parameters.front().values.size(),
                              study.parameters.front().label, parameter.values.size(), parameter.label));
  }
  if (n > most)
    root_.fault("parameter", fmt::format("at most {:g} cases", most), fmt::format("{:g}", n));
  constexpr double most_values = 1e7; // of about a hundred bytes each
  if (const double values = n * static_cast<double>(study.parameters.size()); values > most_values)
    root_.fault("parameter", fmt::format("at most {:g} values of all cases", most_values),
                fmt::format("{:g}", values));
}

void StudyReader::read_vtk(StudyFile& study) {
  const toml::node* node = root_.find("vtk");
  if (!node || node->value<std::string>() == "none")
    return;
  if (node->value<std::string>() == "all") {
    study.vtk_of_all = true;
    return;
  }
  const bool is_known = faults_.empty() && of_scenes_.empty(); // otherwise the number of cases is unknown
  const auto n = is_known ? n_cases(study) : 1'000'000;
  const std::string expected = fmt::format("\"all\", \"none\" or a list of cases from 1 to {}", n);
  const toml::array* list = node->as_array();
  if (!list)
    root_.fault("vtk", expected);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    const auto number = (*list)[i].as_integer();
    if (number && number->get() >= 1 && number->get() <= n)
      study.vtk_cases.push_back(static_cast<int>(number->get()));
    else
      root_.fault("vtk", expected, describe((*list)[i]));
  }
}

void StudyReader::throw_if_any() {
  try {
    faults_.throw_if_any();
  } catch (const InputError& error) {
    auto all = error.faults();
    all.insert(all.end(), of_scenes_.begin(), of_scenes_.end());
    throw InputError(all);
  }
  if (!of_scenes_.empty())
    throw InputError(of_scenes_);
}

} // namespace

StudyFile parse_study(std::string_view text, const fs::path& file) {
  return StudyReader(text, file).read();
}

StudyFile read_study(const fs::path& file) {
  return parse_study(read_text_file(file, "a study file"), file);
}

bool StudyFile::wants_vtk(int number) const {
  return vtk_of_all || std::find(vtk_cases.begin(), vtk_cases.end(), number) != vtk_cases.end();
}

std::vector<std::string> StudyFile::row_methods() const {
  auto names = methods;
  if (!reference.empty() && std::find(names.begin(), names.end(), reference) == names.end())
    names.push_back(reference);
  return names;
}

} // namespace maille::studies
