#include "commands.hpp"

#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/comparison.hpp"
#include "maille/studies/export/vtk_files.hpp"
#include "maille/studies/methods.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace maille::studies {

namespace {

/// A series begins with the body at rest, so that it can be played from there.
void add_rest(PvdSeries& series, const Scene& scene, std::vector<std::filesystem::path>& files) {
  const Displacement rest(scene.specimen.grid);
  ExportFields fields;
  fields.displacement = &rest;
  files.push_back(series.add(scene, fields, 0));
}

/// Answers the scene in steps of equal size by one method and writes each; the rows of all steps.
/// Each step is a quasi-static answer from rest to its fraction of the moves and loads.
void run_in_steps(const Scene& scene, const std::string& method, const RunOptions& options,
                  const Control& control, Methods& methods, std::vector<Comparison>& steps,
                  std::vector<std::filesystem::path>& files, std::vector<AnswerFile>& answers) {
  std::optional<PvdSeries> series;
  if (!options.out.empty() && fem_ref::ranks().is_first()) {
    series.emplace(options.out / fmt::format("{}_{}", scene.name, method),
                   static_cast<std::size_t>(options.steps) + 1);
    add_rest(*series, scene, files);
  }
  const Scene whole = options.steps > 1 && feels_limits(scene, method) ? with_known_limits(scene) : scene;
  for (int step = 1; step <= options.steps && !fem_ref::agree(control.should_stop()); ++step) {
    const double fraction = static_cast<double>(step) / options.steps;
    const Scene part = options.steps == 1 ? scene : scaled(whole, fraction);
    Comparison result = compare_methods(part, {method}, "", control, methods);
    if (options.estimate && fem_ref::ranks().is_first())
      add_estimates(part, result, control);
    if (series && !result.rows.empty() && is_settled(result.rows.front().answer.status)) {
      ExportFields fields;
      const Answer& answer = result.rows.front().answer;
      fields.show(answer);
      if (const auto& found = result.rows.front().estimation; found && found->estimate)
        fields.error_estimate = &found->estimate->error;
      fields.provenance = provenance(part, answer, options.threads);
      files.push_back(series->add(part, fields, fraction));
      if (!answers.empty() && answers.back().method == method)
        answers.pop_back(); // the last step speaks for the method
      answers.push_back({method, files.back().filename().string()});
    }
    steps.push_back(std::move(result));
  }
  if (series)
    files.push_back(series->write());
}

} // namespace

int run_command(const RunOptions& options) {
  auto names = check_methods(options.methods);
  if (names.empty())
    names = {"limits"};
  Methods methods(check_fem_solver(options.fem_solver), !options.out.empty());
  if (options.steps < 1 || options.steps > 100'000)
    throw UsageError(fmt::format("--steps: expected a number from 1 to 100000, found {}", options.steps));
  const Scene scene = read_scene(options.scene);
  const bool speaks = fem_ref::ranks().is_first(); // for all ranks
  if (speaks && !options.out.empty())
    prepare_folder(options.out);
  if (speaks)
    prepare_file("--json", options.json); // may be asked for in that folder
  const Control control = terminal_control(options.threads);
  bool failed = false;
  std::vector<AnswerFile> answers;
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const std::string& method : names) {
    std::vector<Comparison> steps;
    std::vector<std::filesystem::path> files;
    run_in_steps(scene, method, options, control, methods, steps, files, answers);
    end_progress();
    for (std::size_t i = 0; i < steps.size(); ++i) {
      failed = failed || steps[i].any_failed();
      auto row = json(scene, steps[i]);
      row["step"] = i + 1;
      all.push_back(std::move(row));
    }
    if (speaks && options.json != "-") {
      if (!steps.empty())
        deliver(table(scene, steps.back()), std::nullopt);
      for (const auto& file : files)
        fmt::print("wrote {}\n", file.string());
    }
  }
  if (speaks && !options.out.empty()) {
    const auto file = write_results(scene, options, "run", answers, all);
    if (options.json != "-")
      fmt::print("wrote {}\n", file.string());
  }
  if (speaks && options.json)
    deliver(all.dump(2) + "\n", options.json);
  return speaks && failed ? exit_run_failed : exit_done;
}

} // namespace maille::studies
