/// A comparison as text for people, JSON and CSV.

#include "compare/comparison_columns.hpp"
#include "json_parts.hpp"
#include "maille/images/image.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/plausibility.hpp"
#include "mechanics/mechanics_report.hpp"
#include "results/figures.hpp"
#include "text.hpp"

#include <algorithm>

namespace maille::studies {

namespace {

/// Sum of the reactions of holds, or of moves, along every axis of the object [N].
std::vector<double> total_reaction(const Scene& scene, const Answer& answer, bool held) {
  std::vector<double> total(scene.dimension(), 0);
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (scene.prescribed[i].held == held)
      total[scene.prescribed[i].component] += answer.reaction[i];
  return total;
}

bool has_reactions(const Scene& scene, const Answer& answer) {
  return answer.reaction.size() == scene.prescribed.size() && !answer.reaction.empty();
}

/// Rotates a force to the axes of the world, for the text.
std::vector<double> in_world(const Scene& scene, std::vector<double> force) {
  if (scene.specimen.placement.direction == Placement{}.direction)
    return force;
  force.resize(3, 0);
  const Vec3 turned = to_world(scene.specimen.placement, {force[0], force[1], force[2]});
  return {turned.begin(), turned.end()};
}

/// For every method with forces: the forces of holds and moves on the body, along the axes of the world.
std::string mechanics_in_words(const Scene& scene, const Comparison& comparison) {
  std::string text;
  const auto is_any = [&](bool held) {
    return std::ranges::find(scene.prescribed, held, &Prescribed::held) != scene.prescribed.end();
  };
  for (const ComparisonRow& row : comparison.rows) {
    const Answer& answer = row.answer;
    if (!is_under_way(answer))
      continue;
    text += fmt::format("{:<9} moves by up to {}", answer.method,
                        length_in_words(largest_displacement(scene, answer.displacement)));
    const char* const unit = scene.dimension() == 2 ? "N/m" : "N";
    for (const bool held : {true, false})
      if (has_reactions(scene, answer) && is_any(held))
        text += fmt::format("; force on {} {} {}", held ? "holds" : "moves",
                            vector_in_words(in_world(scene, total_reaction(scene, answer, held))), unit);
    if (answer.strain_energy)
      text += fmt::format("; strain energy {:.4g} J{}", *answer.strain_energy,
                          scene.dimension() == 2 ? "/m" : "");
    text += "\n";
    if (const auto check = check_forces(scene, answer))
      for (const std::string& caveat : check->caveats)
        text += fmt::format("{:<9} {}\n", "", caveat);
  }
  return text.empty() ? text : text + "\n";
}

using Line = ComparisonLine;

std::vector<Line> lines_of(const Scene& scene, const Comparison& comparison) {
  std::vector<Line> lines;
  for (const ComparisonRow& row : comparison.rows)
    lines.push_back({&scene, &comparison, &row, test_result(scene, row.answer)});
  return lines;
}

using Table = ResultTable<Line>;

constexpr auto of_row = &Line::row;
constexpr auto of_answer = &ComparisonRow::answer;

void add_cost(Table& columns) {
  add_seconds(columns, of_row, of_answer, &Answer::seconds);
  add_total(columns, of_row, of_answer, &Answer::seconds, &Seconds::total);
  add_bytes(columns, of_row, of_answer, &Answer::bytes);
  columns.add({"", "n_cut", "", "prescribed components that limits cut"}, of_row, of_answer, &Answer::n_cut);
  add_iterations(columns, of_row, of_answer, &Answer::iterations).text_behind("total");
  columns.add({"", "residual", "", "relative error of the solver itself"}, of_row, of_answer,
              &Answer::residual);
}

Value reactions_of(const Line& line) {
  const Answer& answer = line.row->answer;
  if (!has_reactions(*line.scene, answer))
    return nullptr;
  return {{"held", total_reaction(*line.scene, answer, true)},
          {"moved", total_reaction(*line.scene, answer, false)}};
}

/// For every method with forces: the result of the scene's [test].
std::string test_in_words(const Scene& scene, const std::vector<Line>& lines) {
  std::string text;
  for (const Line& line : lines)
    if (line.test) {
      const bool is_moment = scene.test->kind == TestKind::bend;
      const std::string per = scene.dimension() == 2 ? "/m" : "";
      text +=
          fmt::format("{:<9} {} test along {} to a strain of {}: {} {:.4g} {}{}, stiffness {:.4g} {}{}",
                      line.row->answer.method, to_string(scene.test->kind), "xyz"[scene.test->axis],
                      in_percent(scene.test->strain), is_moment ? "moment" : "force", line.test->reaction,
                      is_moment ? "N m" : "N", per, line.test->stiffness, is_moment ? "N m/rad" : "N/m", per);
      if (line.test->apparent_modulus)
        text += fmt::format(", apparent modulus {:.4g} kPa", 1e-3 * *line.test->apparent_modulus);
      if (line.test->failure)
        text += fmt::format("; fails at {:.4g} N (Pistoia 2002)", *line.test->failure);
      text += "\n";
    }
  return text.empty() ? text : text + "\n";
}

/// Every measure of every method.
std::string measures_in_words(const Comparison& comparison) {
  std::vector<MeasureLine> lines;
  for (const ComparisonRow& row : comparison.rows)
    std::ranges::move(lines_of(row.answer.method, row.measures), std::back_inserter(lines));
  const std::string text = studies::measures_in_words(lines);
  return text.empty() ? text : text + "\n";
}

void add_measures(Table& columns) {
  columns
      .add({"", "measures", "", "of [[measure]]: name, unit, value, vector or line"}, of_row,
           &ComparisonRow::measures, measures_json)
      .json_where([](const Line& line) { return !line.row->measures.empty(); });
  columns.add({"", "error.measures", "", "of each measure"}, of_row, &ComparisonRow::measures,
              measure_errors_json);
  columns
      .add({"", "", "", "NAME of each measure, of vectors NAME_x, _y, _z; NAME_error"},
           [](const Line& line) {
             return measure_cells(line.row->measures, !line.comparison->reference.empty());
           })
      .open();
}

constexpr auto of_mechanics = &ComparisonRow::mechanics;
constexpr auto of_mechanics_errors = &ComparisonRow::mechanics_errors;

Value mechanics_json(const Line& line) {
  if (!line.row->mechanics)
    return nullptr;
  Value out = in_json(*line.row->mechanics);
  if (const auto check = check_forces(*line.scene, line.row->answer)) {
    out["missing"] = {{"centroid", check->missing.centroid},
                      {"force", check->missing.force},
                      {"moment", check->missing.moment},
                      {"force_share", json_number(check->force_share)},
                      {"moment_share", json_number(check->moment_share)}};
    out["caveats"] = check->caveats;
  }
  return out;
}

Value rubbing_json(const Answer& answer) {
  Value rows = Value::array();
  for (const RubbingBorder& border : answer.rubbing)
    rows.push_back({{"between", {border.one, border.other}},
                    {"pressed_n", border.pressed},
                    {"rubbed_n", border.rubbed},
                    {"slipping", border.slipping}});
  return rows;
}

std::string rubbing_in_words(const Answer& answer) {
  std::string text;
  for (const RubbingBorder& border : answer.rubbing)
    text += fmt::format("{:<9} labels {} and {}: {:.4g} N press, {:.4g} N rub, {:.3g} % of the nodes slip\n",
                        "", border.one, border.other, border.pressed, border.rubbed, 100 * border.slipping);
  return text;
}

/// @param is_shown  true: also in the text table
void add_mechanics_errors(Table& columns, bool is_shown) {
  const auto add = [&](const char* name, const char* heading, const char* meaning,
                       std::optional<double> MechanicsErrors::*error) {
    columns.add({fmt::format("{}_error", name), fmt::format("error.{}", name), "", meaning},
                is_shown ? Shown{heading, 12, in_percent} : Shown{}, of_row, of_mechanics_errors, error);
  };
  add("force", "force", "of the reactions on moves, else holds", &MechanicsErrors::force);
  add("strain_energy", "energy", "of the strain energy", &MechanicsErrors::strain_energy);
  add("strain", "strain", "L2 over cells, not those at edges of holds and moves", &MechanicsErrors::strain);
  add("stress", "stress", "the same of the stress", &MechanicsErrors::stress);
  add("recovered_stress", "recovered", "of the stress recovered at nodes, over eighths of the same cells",
      &MechanicsErrors::recovered_stress);
}

/// Columns of errors: displacement and other requested quantities.
const Table& columns_of_errors() {
  static const Table table([](Table& columns) {
    add_method(columns, of_row, of_answer, &Answer::method);
    columns.add({"", "", "", ""}, {"displacement", 12, in_percent}, of_row, &ComparisonRow::error,
                &ErrorNorms::relative_l2);
    add_mechanics_errors(columns, true);
  });
  return table;
}

/// Members by their JSON keys.
constexpr std::array<std::pair<const char*, std::optional<double> MechanicsErrors::*>, 4> parts_of_mechanics{
    {{"force", &MechanicsErrors::force},
     {"strain_energy", &MechanicsErrors::strain_energy},
     {"strain", &MechanicsErrors::strain},
     {"stress", &MechanicsErrors::stress}}};

Value estimate_json(const deform::ErrorEstimation& found) {
  if (!found.estimate)
    return nullptr;
  Value out = norms_json(found.estimate->norms);
  for (const auto& [key, error] : parts_of_mechanics)
    out[key] = json_number(found.estimate->mechanics.*error);
  out["other_lattice"] = deform::to_string(found.estimate->lattice);
  out["cycles"] = found.estimate->cycles;
  out["seconds"] = found.estimate->seconds;
  out["bytes"] = found.estimate->bytes;
  return out;
}

void add_estimate(Table& columns) {
  constexpr auto of_estimation = &ComparisonRow::estimation;
  columns.add({"estimated_relative_l2", "", "", "relative_l2 without a reference"},
              {"estimated", 10, in_percent, true}, of_row, of_estimation, &deform::ErrorEstimation::estimate,
              &deform::EstimatedError::norms, &ErrorNorms::relative_l2);
  columns.add({"", "estimated_error", "", "against elasticity"}, of_row, of_estimation, estimate_json)
      .json_where([](const Line& line) { return line.row->estimation.has_value(); });
  columns
      .add({"", "estimated_error_message", "", "why no estimate exists"}, of_row, of_estimation,
           &deform::ErrorEstimation::reason)
      .json_where([](const Line& line) { return line.row->estimation && !line.row->estimation->estimate; });
}

/// Adds estimates of force and the other quantities of compare_mechanics(). @param is_shown true: also in the
/// text table
void add_mechanics_estimates(Table& columns, bool is_shown) {
  constexpr auto of_estimation = &ComparisonRow::estimation;
  for (const auto& [key, error] : parts_of_mechanics)
    columns.add(
        {fmt::format("estimated_{}", key), "", "", fmt::format("{}_error without a reference", key)},
        is_shown ? Shown{key == parts_of_mechanics[1].first ? "energy" : key, 12, in_percent} : Shown{},
        of_row, of_estimation, &deform::ErrorEstimation::estimate, &deform::EstimatedError::mechanics, error);
}

/// Columns of estimated errors.
const Table& columns_of_estimates() {
  static const Table table([](Table& columns) {
    add_method(columns, of_row, of_answer, &Answer::method);
    columns.add({"", "", "", ""}, {"displacement", 12, in_percent}, of_row, &ComparisonRow::estimation,
                &deform::ErrorEstimation::estimate, &deform::EstimatedError::norms, &ErrorNorms::relative_l2);
    add_mechanics_estimates(columns, true);
  });
  return table;
}

/// Cost of each estimate and what it omits, or why it is missing.
std::string estimates_in_words(const Comparison& comparison, const std::vector<Line>& lines) {
  std::string text = "\nEstimated errors against elasticity, without finite elements:\n" +
                     columns_of_estimates().text(lines) + "\n";
  for (const ComparisonRow& row : comparison.rows) {
    if (!row.estimation)
      continue;
    text += fmt::format("{:<9} ", row.answer.method);
    if (!row.estimation->estimate) {
      text += row.estimation->reason + "\n";
      continue;
    }
    const deform::EstimatedError& estimate = *row.estimation->estimate;
    text += fmt::format("{} multigrid cycles, {}; {}\n", estimate.cycles, in_seconds(estimate.seconds),
                        estimate.lattice == deform::OtherLattice::none
                            ? "the model's error hides the lattice's, which is left out"
                            : fmt::format("the lattice's own from one {}", to_string(estimate.lattice)));
  }
  return text;
}

/// Warnings about the reference, the question, and the answers.
std::vector<std::string> all_warnings(const Scene& scene, const Comparison& comparison) {
  const Plausibility question = plausibility(scene);
  std::vector<std::string> warnings = file_warnings();
  warnings.insert(warnings.end(), question.warnings.begin(), question.warnings.end());
  warnings.insert(warnings.end(), comparison.warnings.begin(), comparison.warnings.end());
  std::vector<std::string> methods;
  for (const ComparisonRow& row : comparison.rows)
    methods.push_back(row.answer.method);
  std::ranges::move(unused_settings(scene, methods), std::back_inserter(warnings));
  for (const ComparisonRow& row : comparison.rows)
    if (row.mechanics)
      for (std::string& warning :
           implausible_answer(scene, question, row.answer.method,
                              largest_displacement(scene, row.answer.displacement), row.mechanics->body))
        warnings.push_back(std::move(warning));
  return warnings;
}

} // namespace

const Table& columns_of_comparison() {
  static const Table table = [] {
    Table columns({.digits = 9, .digits_of_seconds = 6});
    columns.add({"scene", "", "", "its name"}, &Line::scene, &Scene::name);
    add_method(columns, of_row, of_answer, &Answer::method);
    add_status(columns, of_row, of_answer, &Answer::status);
    columns.add({"", "message", "", "why the method ended"}, of_row, of_answer, &Answer::message)
        .json_where([](const Line& line) { return !line.row->answer.message.empty(); });
    add_cost(columns);
    add_limit_violation(columns, of_row, &ComparisonRow::limit_violation);
    columns.add({"", "strain_energy", "J", "J/m in 2D"}, of_row, of_answer, &Answer::strain_energy).omitted();
    columns.add({"", "reaction", "N", "sums of forces on holds and on moves, object's axes"}, reactions_of)
        .omitted();
    add_test(columns, &Line::test);
    add_norms(columns, "", "error", of_row, &ComparisonRow::error);
    columns.add({"reference", "", "", "that errors are measured against"}, &Line::comparison,
                &Comparison::reference);
    columns.add({"algorithm", "algorithm", "", "that the method took"}, of_row, of_answer, &Answer::algorithm)
        .json_behind("message");
    add_estimate(columns);
    add_force(columns, "move", of_row, of_mechanics, [](const Mechanics& all) { return sum_of(all.moves); });
    add_force(columns, "hold", of_row, of_mechanics, [](const Mechanics& all) { return sum_of(all.holds); });
    columns.add({"strain_energy_j", "", "J", "J/m in 2D"}, of_row, of_answer, &Answer::strain_energy);
    add_mechanics_errors(columns, false);
    add_mechanics_estimates(columns, false);
    add_measures(columns);
    columns
        .add({"", "rubbing", "",
              "borders that slide with friction: labels, N that press and rub, slipping share"},
             of_row, of_answer, rubbing_json)
        .json_where([](const Line& line) { return !line.row->answer.rubbing.empty(); });
    columns.add({"", "mechanics", "", "of labels, materials and the body, see below"}, mechanics_json)
        .omitted();
    return columns;
  }();
  return table;
}

std::string table(const Scene& scene, const Comparison& comparison) {
  const Specimen& body = scene.specimen;
  std::string text = fmt::format(
      "{}\n{}D, {} cells, {} nodes, {} thread{}{}\n\n", scene.title, scene.dimension(), body.n_matter_cells(),
      body.n_matter_nodes(), comparison.threads, comparison.threads == 1 ? "" : "s",
      comparison.reference.empty() ? "" : ", errors against " + comparison.reference);
  const bool has_estimates = std::ranges::any_of(
      comparison.rows, [](const ComparisonRow& row) { return row.estimation.has_value(); });
  const std::vector<Line> lines = lines_of(scene, comparison);
  text += columns_of_comparison().text(lines);
  text += "\n" + mechanics_in_words(scene, comparison) + test_in_words(scene, lines) +
          measures_in_words(comparison);
  if (std::ranges::any_of(comparison.rows,
                          [](const ComparisonRow& row) { return row.mechanics_errors.has_value(); }))
    text += fmt::format("Errors against {}, of cells away from edges of holds and moves:\n{}\n",
                        comparison.reference, columns_of_errors().text(lines));
  for (const ComparisonRow& row : comparison.rows)
    text += fmt::format("{:<9} {}{}{}\n", row.answer.method, row.answer.algorithm,
                        row.answer.algorithm.empty() || row.answer.message.empty() ? "" : "; ",
                        row.answer.message) +
            rubbing_in_words(row.answer);
  if (has_estimates)
    text += estimates_in_words(comparison, lines);
  if (comparison.reference_error)
    text += fmt::format("best      itself some {} (L2) and {} (max) off at most: its difference from {}\n",
                        in_percent(comparison.reference_error->relative_l2),
                        in_percent(comparison.reference_error->relative_max), comparison.reference_coarser);
  else if (const ComparisonRow* best = comparison.reference_row(); best && comparison.reference == "best")
    text += fmt::format(
        "best      how far it is off is not known: {}\n",
        is_converged(best->answer.status)
            ? "nothing finer than linear elements could be afforded"
            : fmt::format("it ended {}, and nothing is measured against it", to_string(best->answer.status)));
  for (const std::string& warning : all_warnings(scene, comparison))
    text += fmt::format("warning: {}\n", warning);
  return text;
}

nlohmann::ordered_json json(const Scene& scene, const Comparison& comparison) {
  nlohmann::ordered_json out = question_json(scene, comparison.threads);
  if (!comparison.reference.empty())
    out["reference"] = comparison.reference;
  if (comparison.reference_error) {
    out["reference_error"] = norms_json(*comparison.reference_error);
    out["reference_error"]["against"] = comparison.reference_coarser;
  } else if (comparison.reference == "best")
    out["reference_error"] = nullptr;
  out["taut_scale_pa"] = comparison.taut_scale > 0 ? json_number(comparison.taut_scale) : nullptr;
  out["left_out"] = nlohmann::ordered_json::array();
  for (const LeftOutPiece& piece : scene.left_out)
    if (piece.cells > 0)
      out["left_out"].push_back({{"cells", piece.cells}, {"name", piece.name}});
  out["warnings"] = all_warnings(scene, comparison);
  out["results"] = columns_of_comparison().json_rows(lines_of(scene, comparison));
  return out;
}

std::string csv(const Scene& scene, const Comparison& comparison) {
  return columns_of_comparison().csv(lines_of(scene, comparison));
}

} // namespace maille::studies
