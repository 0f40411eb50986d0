#include "maille/studies/comparison.hpp"

#include "json_parts.hpp"
#include "limits_once.hpp"
#include "maille/deform/solve.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/memory.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/studies/best_reference.hpp"
#include "text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// In the frame or the frames that the method measures in.
double violation_of(const Scene& scene, const LinkLimits& limits, const Answer& answer) {
  if (answer.method == "coupled" && in_blocks(scene))
    return largest_violation_in_blocks(scene, limits, answer.displacement);
  return largest_violation(scene, limits, answer.displacement, object_frame(scene));
}

std::string size(std::int64_t bytes) {
  return bytes == 0 ? "-" : bytes_in_words(static_cast<double>(bytes)); // 0: another program's
}

/// Sum of the reactions of holds, or of moves, along every axis of the object [N].
std::vector<double> total_reaction(const Scene& scene, const Answer& answer, bool held) {
  std::vector<double> total(static_cast<std::size_t>(scene.dimension()), 0);
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (scene.prescribed[i].held == held)
      total[static_cast<std::size_t>(scene.prescribed[i].component)] += answer.reaction[i];
  return total;
}

bool has_reactions(const Scene& scene, const Answer& answer) {
  return answer.reaction.size() == scene.prescribed.size() && !answer.reaction.empty();
}

/// Components that are rounding beside the largest are 0.
std::string in_newtons(const std::vector<double>& force) {
  double largest = 0;
  for (const double component : force)
    largest = std::max(largest, std::abs(component));
  std::string text;
  for (const double component : force)
    text += fmt::format("{}{:.4g}", text.empty() ? "(" : ", ",
                        std::abs(component) > 1e-7 * largest ? component : 0);
  return text + ")";
}

double largest_length(const Displacement& u) {
  double largest = 0;
  for (std::size_t node = 0; !u.component.empty() && node < u.component[0].size(); ++node) {
    double square = 0;
    for (const auto& component : u.component)
      square += component[node] * component[node];
    largest = std::max(largest, square);
  }
  return std::sqrt(largest);
}

/// Of every method that knows forces, what keeps holds and moves where they are, as it acts on the body,
/// along the axes that the scene's moves have.
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
                        length_in_words(largest_length(answer.displacement)));
    const char* const unit = scene.dimension() == 2 ? "N/m" : "N";
    for (const bool held : {true, false})
      if (has_reactions(scene, answer) && is_any(held))
        text += fmt::format("; force on {} {} {}", held ? "holds" : "moves",
                            in_newtons(total_reaction(scene, answer, held)), unit);
    if (answer.strain_energy)
      text += fmt::format("; strain energy {:.4g} J{}", *answer.strain_energy,
                          scene.dimension() == 2 ? "/m" : "");
    text += "\n";
  }
  return text.empty() ? text : text + "\n";
}

void add_estimate_json(const deform::ErrorEstimation& found, nlohmann::ordered_json& row) {
  row["estimated_error"] = nullptr;
  if (!found.estimate) {
    row["estimated_error_message"] = found.reason;
    return;
  }
  const deform::EstimatedError& estimate = *found.estimate;
  auto& out = row["estimated_error"] = norms_json(estimate.norms);
  out["other_lattice"] = deform::to_string(estimate.lattice);
  out["cycles"] = estimate.cycles;
  out["seconds"] = estimate.seconds;
  out["bytes"] = estimate.bytes;
}

nlohmann::ordered_json row_json(const Scene& scene, const ComparisonRow& row) {
  const Answer& answer = row.answer;
  nlohmann::ordered_json out{{"method", answer.method}, {"status", to_string(answer.status)}};
  if (!answer.message.empty())
    out["message"] = answer.message;
  out["algorithm"] = answer.algorithm;
  out["seconds"] = seconds_json(answer.seconds);
  out["bytes"] = answer.bytes;
  out["n_cut"] = answer.n_cut;
  out["iterations"] = answer.iterations;
  out["residual"] = json_number(answer.residual);
  out["limit_violation"] = json_number(row.limit_violation);
  if (answer.strain_energy)
    out["strain_energy"] = json_number(*answer.strain_energy);
  if (has_reactions(scene, answer))
    out["reaction"] = {{"held", total_reaction(scene, answer, true)},
                       {"moved", total_reaction(scene, answer, false)}};
  if (row.error)
    out["error"] = norms_json(*row.error);
  if (row.estimation)
    add_estimate_json(*row.estimation, out);
  return out;
}

std::string estimated(const ComparisonRow& row) {
  return row.estimation && row.estimation->estimate ? in_percent(row.estimation->estimate->norms.relative_l2)
                                                    : "-";
}

/// What each estimate took, and what it leaves out; why there is none.
std::string estimates_in_words(const Comparison& comparison) {
  std::string text = "\nestimated: L2 error against elasticity, without finite elements\n";
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

} // namespace

bool feels_limits(const Scene& scene, std::string_view method) {
  if (method == "coupled")
    return scene.limits_bind_coupled();
  if (method == "relaxed")
    return scene.limits_bind_relaxed() || scene.relaxation.mode == RelaxationMode::deformable;
  return std::ranges::find(deform::methods(), method) != deform::methods().end();
}

Scene with_known_limits(const Scene& scene) {
  Scene known = scene;
  known.limits.taut_scale = with_limits(scene).limits.taut_scale;
  return known;
}

const ComparisonRow* Comparison::reference_row() const {
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const ComparisonRow& r) { return r.answer.method == reference; });
  return row == rows.end() ? nullptr : &*row;
}

bool is_under_way(const Answer& answer) {
  return is_settled(answer.status) || (has_displacement(answer.status) && answer.iterations > 0);
}

bool Comparison::any_failed() const {
  const ComparisonRow* truth = reference_row();
  if (!reference.empty() && (!truth || !is_settled(truth->answer.status)))
    return true;
  return std::any_of(rows.begin(), rows.end(), [&](const ComparisonRow& row) {
    // Beside a reference, a method that cannot carry the scene is a result; alone, nothing was answered.
    const bool accepted = row.answer.status == Status::refused && !reference.empty();
    const bool cut = (row.answer.n_cut > 0 || row.answer.status == Status::clamped) && !cut_is_allowed;
    return cut || (!is_settled(row.answer.status) && !accepted);
  });
}

Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control) {
  Methods methods;
  return compare_methods(scene, std::move(names), reference, control, methods);
}

Comparison compare_methods(const Scene& scene, std::vector<std::string> names, const std::string& reference,
                           const Control& control, Methods& methods, double seconds_for_reference) {
  const bool against_best = reference == "best";
  if (!reference.empty() && !against_best && std::find(names.begin(), names.end(), reference) == names.end())
    names.push_back(reference);
  Comparison comparison;
  comparison.reference = reference;
  comparison.threads = control.threads;
  comparison.cut_is_allowed = scene.limits.cut_is_allowed;
  const LimitsOnce limits(scene, names);
  comparison.taut_scale = limits.taut_scale();
  for (const std::string& method : names) {
    if (fem_ref::agree(control.should_stop()))
      break;
    if (!fem_ref::ranks().is_first() && !method.starts_with("fem_"))
      continue; // ranks share finite elements only
    ComparisonRow row;
    const bool feels = feels_limits(scene, method);
    row.answer = methods.answer(feels ? limits.known(scene) : scene, method, control);
    if (has_displacement(row.answer.status) && feels)
      row.answer.seconds.setup += limits.seconds();
    if (is_under_way(row.answer) && limits.limits() && (feels || scene.limits_bind_relaxed()))
      row.limit_violation = violation_of(scene, *limits.limits(), row.answer);
    comparison.rows.push_back(std::move(row));
  }
  if (against_best && !fem_ref::agree(control.should_stop())) {
    BestReference best = best_reference(scene, seconds_for_reference, control, methods);
    comparison.reference_error = best.estimated_error;
    comparison.reference_coarser = best.coarser;
    comparison.rows.push_back({std::move(best.answer), std::nullopt, std::nullopt});
  }
  const ComparisonRow* truth = comparison.reference_row();
  if (truth && is_settled(truth->answer.status))
    for (ComparisonRow& row : comparison.rows)
      if (&row != truth && is_under_way(row.answer))
        row.error = compare(scene, row.answer.displacement, truth->answer.displacement);
  return comparison;
}

void add_estimates(const Scene& scene, Comparison& comparison, const Control& control) {
  for (ComparisonRow& row : comparison.rows) {
    if (!is_under_way(row.answer) || control.should_stop())
      continue;
    const bool is_of_lattice =
        std::ranges::find(deform::methods(), row.answer.method) != deform::methods().end();
    row.estimation =
        is_of_lattice ? deform::estimate_error(scene, row.answer.displacement, control)
                      : deform::ErrorEstimation{{}, "of finite elements there is none: see --reference best"};
  }
}

std::string table(const Scene& scene, const Comparison& comparison) {
  const Specimen& body = scene.specimen;
  std::string text = fmt::format(
      "{}\n{}D, {} cells, {} nodes, {} thread{}{}\n\n", scene.title, scene.dimension(), body.n_matter_cells(),
      body.n_matter_nodes(), comparison.threads, comparison.threads == 1 ? "" : "s",
      comparison.reference.empty() ? "" : ", errors against " + comparison.reference);
  const bool has_estimates = std::ranges::any_of(
      comparison.rows, [](const ComparisonRow& row) { return row.estimation.has_value(); });
  text += fmt::format("{:<9} {:<14} {:>9} {:>9} {:>9} {:>9} {:>11} {:>10} {:>10} {:>10}{}\n", "method",
                      "status", "set-up", "solve", "total", "iter.", "memory", "violation", "L2 error",
                      "max error", has_estimates ? fmt::format(" {:>10}", "estimated") : "");
  for (const ComparisonRow& row : comparison.rows) {
    const Answer& answer = row.answer;
    text += fmt::format("{:<9} {:<14} {:>9} {:>9} {:>9} {:>9} {:>11} {:>10} {:>10} {:>10}{}\n", answer.method,
                        to_string(answer.status), in_seconds(answer.seconds.setup),
                        in_seconds(answer.seconds.solve), in_seconds(answer.seconds.total()),
                        answer.iterations, size(answer.bytes),
                        row.limit_violation ? fmt::format("{:.2g}", *row.limit_violation) : "-",
                        row.error ? in_percent(row.error->relative_l2) : "-",
                        row.error ? in_percent(row.error->relative_max) : "-",
                        has_estimates ? fmt::format(" {:>10}", estimated(row)) : "");
  }
  text += "\n" + mechanics_in_words(scene, comparison);
  for (const ComparisonRow& row : comparison.rows)
    text += fmt::format("{:<9} {}{}{}\n", row.answer.method, row.answer.algorithm,
                        row.answer.algorithm.empty() || row.answer.message.empty() ? "" : "; ",
                        row.answer.message);
  if (has_estimates)
    text += estimates_in_words(comparison);
  if (comparison.reference_error)
    text += fmt::format("best      itself some {} (L2) and {} (max) off at most: its difference from {}\n",
                        in_percent(comparison.reference_error->relative_l2),
                        in_percent(comparison.reference_error->relative_max), comparison.reference_coarser);
  else if (const ComparisonRow* best = comparison.reference_row(); best && comparison.reference == "best")
    text += fmt::format(
        "best      how far it is off is not known: {}\n",
        is_settled(best->answer.status)
            ? "nothing finer than linear elements could be afforded"
            : fmt::format("it ended {}, and nothing is measured against it", to_string(best->answer.status)));
  for (const std::string& warning : comparison.warnings)
    text += fmt::format("warning: {}\n", warning);
  for (const LeftOutPiece& piece : scene.left_out)
    text += fmt::format("left out: {}\n", piece.name);
  for (const std::string& warning : plausibility(scene).warnings)
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
    out["left_out"].push_back({{"cells", piece.cells}, {"name", piece.name}});
  out["warnings"] = plausibility(scene).warnings;
  for (const std::string& warning : comparison.warnings)
    out["warnings"].push_back(warning);
  out["results"] = nlohmann::ordered_json::array();
  for (const ComparisonRow& row : comparison.rows)
    out["results"].push_back(row_json(scene, row));
  return out;
}

std::string csv(const Scene& scene, const Comparison& comparison) {
  std::string text =
      "scene,method,status,setup_s,solve_s,total_s,bytes,iterations,limit_violation,relative_l2,"
      "relative_max,rms_m,reference,algorithm,estimated_relative_l2\n";
  const auto cell = [](std::optional<double> value) {
    return value ? fmt::format("{:.9g}", *value) : std::string();
  };
  for (const ComparisonRow& row : comparison.rows) {
    const Answer& a = row.answer;
    const auto error = [&](double ErrorNorms::*norm) {
      return row.error ? cell((*row.error).*norm) : std::string();
    };
    text += fmt::format(
        "{},{},{},{:.6g},{:.6g},{:.6g},{},{},{},{},{},{},{},{},{}\n", csv_text(scene.name), a.method,
        to_string(a.status), a.seconds.setup, a.seconds.solve, a.seconds.total(), a.bytes, a.iterations,
        cell(row.limit_violation), error(&ErrorNorms::relative_l2), error(&ErrorNorms::relative_max),
        error(&ErrorNorms::rms), comparison.reference, csv_text(a.algorithm),
        row.estimation && row.estimation->estimate ? cell(row.estimation->estimate->norms.relative_l2) : "");
  }
  return text;
}

} // namespace maille::studies
