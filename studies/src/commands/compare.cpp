#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"
#include "cli/worlds.hpp"
#include "compare/comparison.hpp"
#include "compare/comparison_columns.hpp"
#include "compare/methods.hpp"
#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/measure/measure.hpp"
#include "picture/comparison_picture.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <deque>

namespace maille::studies {

namespace {

/// Writes one grid file per method, the table as JSON and CSV, and a .vtm with a named block per method.
std::vector<std::filesystem::path> write_files(const Scene& scene, const Comparison& comparison,
                                               const CompareOptions& options, ResultsFolder& folder) {
  std::vector<std::filesystem::path> files;
  std::vector<NamedBlock> blocks;
  std::vector<AnswerFile> answers;
  const ComparisonRow* reference = comparison.reference_row();
  for (const ComparisonRow& row : comparison.rows) {
    if (!is_under_way(row.answer))
      continue;
    ExportFields fields;
    fields.show(row.answer);
    if (row.estimation && row.estimation->estimate)
      fields.error_estimate = &row.estimation->estimate->error;
    fields.unit = length_unit(options.unit.value_or("m"));
    fields.reference = row.error ? &reference->answer.displacement : nullptr;
    fields.provenance = provenance(scene, row.answer, options.threads);
    files.push_back(write_vtk(scene, fields, folder.file("_" + row.answer.method)));
    blocks.push_back({row.answer.method, files.back()});
    answers.push_back({row.answer.method, files.back().filename().string()});
  }
  files.push_back(folder.file(".vtm"));
  write_blocks(blocks, files.back());
  files.push_back(folder.file("_compare.json"));
  write_whole(files.back(), json_text(json(scene, comparison)));
  for (const ComparisonRow& row : comparison.rows)
    write_lines_of_measures(row.answer.method, row.measures, folder, files);
  files.push_back(folder.file("_compare.csv"));
  write_whole(files.back(), csv(scene, comparison));
  Scene known = scene;
  if (comparison.taut_scale > 0 && scene.limit_source() == LimitSource::taut)
    known.limits.taut_scale = comparison.taut_scale; // already computed
  folder.add(files);
  files.push_back(finish(folder, known, answers, nlohmann::ordered_json::array({json(scene, comparison)})));
  return files;
}

/// Draws fast methods first, then the reference. On failure prints the reason to stderr and deletes an older
/// picture.
bool draw(const Scene& scene, const Comparison& comparison, const CompareOptions& options) {
  const std::filesystem::path file(*options.picture);
  std::vector<PicturePanel> panels;
  std::deque<Displacement> shown;
  for (const ComparisonRow& row : comparison.rows)
    if (auto field =
            is_under_way(row.answer) ? shown_field(scene, comparison, row, options.picture_of) : std::nullopt)
      panels.push_back({row.answer.method, &row.answer.displacement,
                        row.error ? std::optional(row.error->relative_l2) : std::nullopt,
                        row.answer.method == comparison.reference, &shown.emplace_back(std::move(*field))});
  PictureSettings settings = settings_of_field(scene.title, options.picture_of);
  if (options.picture_of == "displacement")
    settings.draw_body = draw_grey_values(scene, options.scene, options.threads);
  settings.is_anatomical = is_of_a_patient(options.scene);
  return tell_of_picture(panels.empty() ? "no method has an answer with " + options.picture_of
                                        : render_comparison(scene, panels, file, settings),
                         file);
}

/// Checks options for errors that need no scene.
void check_options(const CompareOptions& options) {
  if (!options.reference.empty() && options.reference != "best")
    if (!is_method(options.reference))
      throw UsageError(fmt::format("--reference: expected one of best, {}, found \"{}\"",
                                   fmt::join(all_methods(), ", "), options.reference));
  if (options.json == "-" && options.csv == "-")
    throw UsageError("--json and --csv: expected at most one of them on stdout, found both");
  if (options.picture && !options.picture->ends_with(".png"))
    throw UsageError(
        fmt::format("--picture: expected a name that ends in .png, found \"{}\"", *options.picture));
}

/// Prepares the folder first: output files may be inside it.
void prepare_outputs(const CompareOptions& options, const Scene& scene,
                     const std::vector<std::string>& methods, std::optional<ResultsFolder>& folder) {
  std::vector<std::string> sure{".vtm", "_compare.json"};
  for (const std::string& method : methods)
    sure.push_back("_" + method + ending_of_vtk(scene));
  if (options.out)
    folder.emplace(*options.out, scene.name, options.scene, "compare", sure);
  prepare_file("--json", options.json, folder);
  prepare_file("--csv", options.csv, folder, "", columns_of_comparison().csv_head());
  prepare_file("--picture", options.picture, folder);
}

} // namespace

int compare_command(const CompareOptions& options) {
  auto names = check_methods(options.methods);
  if (names.empty())
    names = default_compare_methods();
  check_options(options);
  Methods methods(check_fem_solver(options.fem_solver), options.out.has_value());
  keep_inputs({options.scene}); // before reading: the list of opened files starts here
  const SceneAndMeasures read = read_scene_and_measures(options.scene);
  const Scene& scene = read.scene;
  const auto reference = options.reference.empty() ? default_reference(names) : options.reference;
  if (!ranks_agree_on(&scene, fmt::format("{} {} {} {} {}", fmt::join(names, " "), reference,
                                          options.reference_seconds, options.fem_solver, options.estimate)))
    return exit_faulty_input;
  std::optional<ResultsFolder> folder;
  if (fem_ref::ranks().is_first())
    prepare_outputs(options, scene, names, folder);
  const Control control = terminal_control(options.threads);
  Comparison comparison =
      compare_methods(scene, names, reference, control, methods, options.reference_seconds);
  end_progress();
  if (!fem_ref::ranks().is_first())
    return exit_done; // only the first rank prints
  if (options.estimate)
    add_estimates(scene, comparison, control);
  const auto tell = [&control](const char* phase) {
    if (control.progress)
      control.progress(1, phase);
  };
  tell("mechanics");
  if (!control.should_stop()) // the remaining time is for files
    add_mechanics(scene, comparison);
  add_measures(scene, read.measures, comparison);
  comparison.warnings = reference_warnings(scene, comparison, control);
  end_progress();

  const bool quiet = options.json == "-" || options.csv == "-";
  const bool has_answers = std::any_of(comparison.rows.begin(), comparison.rows.end(),
                                       [](const auto& row) { return is_under_way(row.answer); });
  const bool is_cut =
      is_cut_short(control, has_answers, folder || options.json || options.csv || options.picture);
  if (options.json && (!is_cut || options.json == "-"))
    deliver(json_text(json(scene, comparison)), options.json);
  if (options.csv && (!is_cut || options.csv == "-"))
    deliver(csv(scene, comparison), options.csv);
  std::vector<std::filesystem::path> files;
  if (folder && control.should_stop())
    folder->keep_earlier();
  tell("files");
  if (folder && has_answers)
    files = write_files(scene, comparison, options, *folder);
  bool is_drawn = true;
  if (options.picture && !is_cut) {
    tell("picture");
    is_drawn = draw(scene, comparison, options);
    if (is_drawn)
      files.emplace_back(*options.picture);
  }
  end_progress();
  if (!quiet) { // last: after a failed print the files are complete
    std::string text = table(scene, comparison);
    for (const auto& file : files)
      text += fmt::format("wrote {}\n", file.string());
    deliver(text, std::nullopt);
  }
  return is_cut || !is_drawn || comparison.any_failed() ? exit_run_failed : exit_done;
}

} // namespace maille::studies
