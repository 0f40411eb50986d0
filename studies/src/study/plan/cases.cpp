/// Plan of a study: from parameters to cases, and from cases to scenes.
///
/// Combinations: grid (all values of all parameters), zip (value by value), and plans sampled in the unit
/// cube (Latin hypercube, Sobol, Saltelli; sampling.hpp), mapped to ranges linearly or logarithmically. A
/// case is a list of values; its scene is the study's scene file with these values at dotted keys
/// (replace_dotted). So a case can be reproduced from its text alone, and its hash identifies it when a study
/// is resumed.

#include "maille/materials/toml_reader.hpp"
#include "study/plan/formula.hpp"
#include "study/plan/read_parameter.hpp"
#include "study/plan/sampling.hpp"
#include "study/plan/study.hpp"

#include <sstream>

namespace maille::studies {

namespace {

using Point = std::vector<StudyValue>;

std::vector<Point> grid_points(const StudyFile& study) {
  std::vector<Point> points{{}};
  for (const StudyParameter& parameter : study.parameters) {
    std::vector<Point> longer;
    for (const Point& point : points)
      for (const StudyValue& value : parameter.values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    points = std::move(longer);
  }
  return points;
}

std::vector<Point> zipped_points(const StudyFile& study) {
  std::vector<Point> points(study.parameters.empty() ? 1 : study.parameters.front().values.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const StudyParameter& parameter : study.parameters)
      points[i].push_back(parameter.values[i]);
  return points;
}

std::vector<Point> drawn_points(const StudyFile& study) {
  const int dimensions = static_cast<int>(study.parameters.size());
  const UnitPoints unit = study.combination == Combination::sobol ? sobol_points(study.samples, dimensions)
                          : study.combination == Combination::saltelli
                              ? saltelli_points(study.samples, dimensions)
                              : latin_hypercube(study.samples, dimensions, study.seed);
  std::vector<Point> points(unit.size());
  for (std::size_t i = 0; i < unit.size(); ++i)
    for (std::size_t d = 0; d < study.parameters.size(); ++d)
      points[i].push_back(study.parameters[d].at(unit[i][d]));
  return points;
}

/// Appends the values of formulas.
void add_formulas(const StudyFile& study, Point& point) {
  NamedNumbers known;
  for (std::size_t i = 0; i < study.n_varied(); ++i) {
    const StudyParameter& of = study.varied(i);
    if (!of.formula.empty())
      point.push_back(drawn(value_of_formula(of.formula, known), of.unit));
    if (const double* number = std::get_if<double>(&point[i].shown))
      known.emplace_back(of.label, *number);
  }
}

} // namespace

std::vector<StudyCase> cases(const StudyFile& study) {
  std::vector<Point> points = is_drawn_plan(study.combination)        ? drawn_points(study)
                              : study.combination == Combination::zip ? zipped_points(study)
                                                                      : grid_points(study);
  for (Point& point : points)
    add_formulas(study, point);
  std::vector<StudyCase> all;
  for (std::size_t scene = 0; scene < study.scenes.size(); ++scene)
    for (const Point& point : points)
      all.push_back({static_cast<int>(all.size()) + 1, scene, point});
  return all;
}

std::int64_t n_cases(const StudyFile& study) {
  std::int64_t n = static_cast<std::int64_t>(study.scenes.size());
  if (study.combination == Combination::saltelli)
    n *= static_cast<std::int64_t>(study.parameters.size()) + 2;
  if (is_drawn_plan(study.combination))
    return n * study.samples;
  if (study.combination == Combination::zip)
    return study.parameters.empty() ? n
                                    : n * static_cast<std::int64_t>(study.parameters.front().values.size());
  for (const StudyParameter& parameter : study.parameters)
    n *= static_cast<std::int64_t>(parameter.values.size());
  return n;
}

std::string resolved_scene(const StudyFile& study, const StudyCase& one) {
  const StudyScene& scene = study.scenes[one.scene];
  toml::table document = parse_toml(scene.text, scene.file.string());
  for (std::size_t p = 0; p < study.n_varied(); ++p)
    for (const std::string& key : study.varied(p).keys)
      replace_dotted(document, key, one.values[p].toml);
  std::ostringstream text;
  text << toml::toml_formatter(document) << "\n";
  return text.str();
}

} // namespace maille::studies
