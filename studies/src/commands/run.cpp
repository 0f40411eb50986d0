#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"
#include "compare/force_curve.hpp"
#include "export/calculix/calculix.hpp"
#include "json_parts.hpp"
#include "mechanics/mechanics_report.hpp"

#include "compare/comparison.hpp"
#include "compare/methods.hpp"
#include "export/voxel_maps.hpp"
#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"
#include "maille/deform/solve.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/images/image.hpp"
#include "maille/scene/measure/measure.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <exception>
#include <optional>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Options for images and surfaces of a run.
WarpOptions warp_options(const RunOptions& options) {
  WarpOptions warp = options.warp;
  warp.unit = options.unit.value_or(warp.unit);
  return warp;
}

/// Files of one method: for several steps, a series that starts at rest, so that it can be played; for one
/// step, only the final state.
class MethodFiles {
public:
  MethodFiles(const Scene& scene, const std::string& method, const RunOptions& options, ResultsFolder& folder)
      : scene_(scene), method_(method), steps_(options.steps), threads_(options.threads),
        has_maps_(options.maps), unit_(length_unit(options.unit.value_or("m"))),
        warp_(options.is_warped ? std::optional(warp_request(warp_options(options))) : std::nullopt),
        folder_(folder), stem_(folder.file("_" + method)),
        series_(stem_, static_cast<std::size_t>(options.steps) + 1) {}

  /// Adds a step; writes nothing before the first answer.
  void add(const Scene& part, const ComparisonRow& row, double fraction) {
    ExportFields fields;
    fields.show(row.answer);
    if (const auto& found = row.estimation; found && found->estimate)
      fields.error_estimate = &found->estimate->error;
    fields.provenance = provenance(part, row.answer, threads_);
    fields.unit = unit_;
    fields.threads = threads_;
    if (has_maps_)
      maps_ = write_voxel_maps(part, row.answer, has_stress(method_), stem_);
    if (warp_ && fraction == 1)
      write_images(part, row.answer);
    if (steps_ == 1) {
      fs::path stem = stem_;
      stem += "_0001";
      fields.time = fraction;
      files_.push_back(write_vtk(part, fields, stem));
      return;
    }
    if (files_.empty())
      add_rest();
    files_.push_back(series_.add(part, fields, fraction));
  }

  const std::vector<fs::path>& finish(const ForceCurve& curve, const std::vector<MeasureStep>& measures) {
    if (steps_ > 1 && !files_.empty()) {
      files_.push_back(series_.write());
      if (const std::string text = measure_steps_csv(measures); !text.empty()) {
        files_.push_back(folder_.file("_" + method_ + "_measures.csv"));
        write_whole(files_.back(), text);
      }
      files_.push_back(folder_.file("_" + method_ + "_force.csv"));
      write_whole(files_.back(), columns_of_curve().csv(curve.points));
    }
    if (!files_.empty() && !measures.empty())
      write_lines_of_measures(method_, measures.back().rows, folder_, files_);
    files_.insert(files_.end(), maps_.begin(), maps_.end());
    if (warped_)
      files_.insert(files_.end(), warped_->files.begin(), warped_->files.end());
    folder_.add(files_);
    return files_;
  }
  /// Warped images, if requested and the last step has an answer.
  const std::optional<WarpedFiles>& images() const { return warped_; }
  /// File of the last step, which represents the method.
  std::string last() const { return files_.back().filename().string(); }

private:
  void write_images(const Scene& scene, const Answer& answer) {
    fs::path stem = stem_;
    stem += "_";
    warped_ = write_warp(scene, answer, *warp_, stem);
    const std::vector<std::string> in_table = file_warnings();
    std::erase_if(warped_->warnings, [&](const std::string& warning) {
      return std::ranges::find(in_table, warning) != in_table.end();
    });
  }

  void add_rest() {
    const Displacement rest(scene_.specimen.grid);
    ExportFields fields;
    fields.has_stress = has_stress(method_);
    fields.displacement = &rest;
    fields.unit = unit_;
    files_.push_back(series_.add(scene_, fields, 0));
  }

  const Scene& scene_;
  const std::string& method_;
  int steps_, threads_;
  bool has_maps_;
  LengthUnit unit_;
  std::optional<WarpRequest> warp_;
  std::optional<WarpedFiles> warped_;
  ResultsFolder& folder_;
  fs::path stem_;
  PvdSeries series_;
  std::vector<fs::path> files_, maps_;
};

/// Requests and answers so far.
struct Course {
  std::vector<AnswerFile> answers;
  nlohmann::ordered_json results = nlohmann::ordered_json::array(); ///< one comparison per method and step
  std::vector<ForceCurve> curves;
  bool has_answers = false, has_failed = false;
};

/// Measures of those steps of one method that have an answer.
std::vector<MeasureStep> measures_of(const std::vector<Comparison>& steps, int n_steps) {
  std::vector<MeasureStep> measures;
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (const ComparisonRow& row : steps[i].rows)
      if (is_under_way(row.answer))
        measures.push_back({static_cast<int>(i) + 1, static_cast<double>(i + 1) / n_steps, row.measures});
  return measures;
}

/// Text of a method's last step; for several steps also the course of force and measures.
std::string text_of_steps(const Scene& scene, const std::vector<Comparison>& steps, const ForceCurve& curve,
                          int n_steps) {
  std::string text = table(scene, steps.back());
  for (const ComparisonRow& row : steps.back().rows)
    if (row.mechanics)
      text += "\n" + in_words(*row.mechanics);
  if (n_steps > 1)
    text += "\n" + columns_of_curve().text(curve.points);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) // the last one is in the table
    for (const ComparisonRow& row : steps[i].rows)
      if (!is_converged(row.answer.status))
        text += fmt::format("step {} of {} ended {}{}{}: no files, exit code {}\n", i + 1, n_steps,
                            to_string(row.answer.status), row.answer.message.empty() ? "" : ": ",
                            row.answer.message, exit_run_failed);
  if (const std::string measures = measure_steps_in_words(measures_of(steps, n_steps));
      n_steps > 1 && !measures.empty())
    text += "\n" + measures;
  return text;
}

/// Solves the scene in equal steps by one method; each step is a quasi-static solution from rest at its
/// fraction of the moves and loads.
/// @param files  null: no files are written
std::vector<Comparison> run_in_steps(const SceneAndMeasures& asked, const std::string& method,
                                     const RunOptions& options, const Control& control, Methods& methods,
                                     MethodFiles* files, Course& course) {
  const Scene& scene = asked.scene;
  std::vector<Comparison> steps;
  std::optional<Scene> known, scaled_down; // copies only if they differ, to save memory
  if (options.steps > 1 && deform::feels_limits(scene, method))
    known = with_known_limits(scene);
  for (int step = 1; step <= options.steps && !fem_ref::agree(control.should_stop()); ++step) {
    const double fraction = static_cast<double>(step) / options.steps;
    if (options.steps > 1)
      scaled_down = scaled(known ? *known : scene, fraction);
    const Scene& part = scaled_down ? *scaled_down : scene;
    Comparison result = compare_methods(part, {method}, "", control, methods);
    if (options.estimate && fem_ref::ranks().is_first())
      add_estimates(part, result, control);
    if (fem_ref::ranks().is_first()) {
      if (control.progress)
        control.progress(fraction, "mechanics");
      add_mechanics(part, result);
      add_measures(part, asked.measures, result);
    }
    for (const ComparisonRow& row : result.rows) {
      course.has_answers = course.has_answers || is_under_way(row.answer);
      if (files && is_converged(row.answer.status)) {
        if (control.progress)
          control.progress(fraction, "files");
        files->add(part, row, fraction);
        if (!course.answers.empty() && course.answers.back().method == method)
          course.answers.pop_back();
        course.answers.push_back({method, files->last()});
      }
    }
    course.has_failed = course.has_failed || result.any_failed();
    course.results.push_back(json(scene, result));
    course.results.back()["step"] = step;
    steps.push_back(std::move(result));
  }
  return steps;
}

/// One JSON object, as for compare: the question, and a row per method and step.
nlohmann::ordered_json json(const Course& course, const Scene& scene, const RunOptions& options) {
  nlohmann::ordered_json out = question_json(scene, options.threads);
  out["steps"] = options.steps;
  for (const char* key : {"taut_scale_pa", "left_out"})
    if (!course.results.empty())
      out[key] = course.results.front()[key];
  out["warnings"] = nlohmann::ordered_json::array();
  for (const auto& comparison : course.results)
    for (const auto& warning : comparison["warnings"])
      if (std::ranges::find(out["warnings"], warning) == out["warnings"].end())
        out["warnings"].push_back(warning);
  out["results"] = nlohmann::ordered_json::array();
  for (const auto& comparison : course.results)
    for (nlohmann::ordered_json row : comparison["results"]) {
      row["step"] = comparison["step"];
      out["results"].push_back(std::move(row));
    }
  return out;
}

void check_pictures(const RunOptions& options, const std::string& method) {
  if (options.picture && !options.picture->ends_with(".png") && !options.picture->ends_with(".svg"))
    throw UsageError(
        fmt::format("--picture: expected a name that ends in .png or .svg, found \"{}\"", *options.picture));
  if (options.picture && options.steps == 1)
    throw UsageError("--picture: expected --steps 2 or more, whose forces it draws, found one step");
  if (options.film && !options.film->ends_with(".mp4"))
    throw UsageError(fmt::format("--film: expected a name that ends in .mp4, found \"{}\"", *options.film));
  if (options.film && options.steps == 1)
    throw UsageError("--film: expected --steps 2 or more, found one step");
  if (options.field == "error" && !options.estimate)
    throw UsageError("--field error: expected --estimate, found none");
  if (options.field == "stress" && !has_stress(method))
    throw UsageError(fmt::format("--field stress: expected a method that has stress, found {}", method));
}

void check_maps(const RunOptions& options, const Scene& scene) {
  if (!options.maps)
    return;
  if (!options.out)
    throw UsageError("--maps: expected --out, the folder for them, found none");
  if (const std::string why_not = why_no_maps(scene); !why_not.empty())
    throw UsageError("--maps: expected " + why_not);
}

void check_warp(const RunOptions& options, const Scene& scene) {
  if (!options.is_warped)
    return;
  if (!options.out)
    throw UsageError("--warp: expected --out, the folder for the images, found none");
  if (const std::string why_not = why_no_warp(scene, warp_request(warp_options(options))); !why_not.empty())
    throw UsageError("--warp: expected " + why_not);
}

void write_deck(const Scene& scene, const std::string& file) {
  if (const std::string reason = why_no_deck(scene); !reason.empty())
    throw UsageError("--write: expected a scene that a deck of CalculiX can say: " + reason);
  deliver(calculix_deck(scene), file);
}

} // namespace

int run_command(const RunOptions& options) {
  auto names = check_methods(options.methods);
  if (names.empty())
    names = {default_run_method};
  Methods methods(check_fem_solver(options.fem_solver), options.out.has_value());
  if (options.steps < 1 || options.steps > 100'000)
    throw UsageError(fmt::format("--steps: expected a number from 1 to 100000, found {}", options.steps));
  check_pictures(options, names.front());
  keep_inputs({options.scene}); // before reading: the list of opened files starts here
  const SceneAndMeasures asked = read_scene_and_measures(options.scene);
  const Scene& scene = asked.scene;
  check_maps(options, scene);
  check_warp(options, scene);
  if (options.write) {
    prepare_file("--write", options.write, {}, ".inp");
    write_deck(scene, *options.write);
    if (options.methods.empty() && !options.out && !options.json) // no other output is requested
      return exit_done;
  }
  if (!ranks_agree_on(&scene, fmt::format("{} {} {} {}", fmt::join(names, " "), options.fem_solver,
                                          options.steps, options.estimate)))
    return exit_faulty_input;
  const bool speaks = fem_ref::ranks().is_first(); // prints for all ranks
  std::optional<ResultsFolder> folder;
  if (speaks && options.out) {
    std::vector<std::string> sure;
    for (const std::string& method : names)
      for (const char* end : {"_0000", "_0001", ".pvd"})
        if (options.steps > 1 || end == std::string_view("_0001"))
          sure.push_back(fmt::format("_{}{}{}", method, end, *end == '_' ? ending_of_vtk(scene) : ""));
    folder.emplace(*options.out, scene.name, options.scene, "run", sure);
    for (const std::string& method : names)
      if (options.steps > 1)
        folder->plan(fmt::format("_{}_force.csv", method));
  }
  if (speaks)
    for (const auto& [option, file] :
         {std::pair("--json", options.json), {"--picture", options.picture}, {"--film", options.film}})
      prepare_file(option, file, folder); // it may be inside that folder
  const Control control = terminal_control(options.threads);
  deform::ElasticBody body; // cache of `coupled` between steps
  if (options.steps > 1)
    methods.keep(body);
  Course course;
  bool is_filmed = !options.film;
  std::exception_ptr not_printed; // after a failed print the files are complete
  for (const std::string& method : names) {
    body.forget();
    std::optional<MethodFiles> files;
    if (folder)
      files.emplace(scene, method, options, *folder);
    const std::vector<Comparison> steps =
        run_in_steps(asked, method, options, control, methods, files ? &*files : nullptr, course);
    end_progress();
    course.curves.push_back(force_curve(scene, method, steps, options.steps));
    std::string text = steps.empty() ? "" : text_of_steps(scene, steps, course.curves.back(), options.steps);
    if (files && files->images())
      text += "\n" + in_words(*files->images());
    if (files)
      for (const auto& file : files->finish(course.curves.back(), measures_of(steps, options.steps)))
        text += fmt::format("wrote {}\n", file.string());
    try {
      if (speaks && options.json != "-")
        deliver(text, std::nullopt);
    } catch (const std::exception&) {
      not_printed = std::current_exception();
    }
    if (options.film && speaks && method == names.front() && !control.should_stop())
      is_filmed = tell_of_picture(film_steps(scene, method, steps, options.field, *options.film),
                                  *options.film, options.json != "-");
  }
  if (!speaks)
    return exit_done;
  const bool is_cut = is_cut_short(control, course.has_answers, folder || options.json || options.picture);
  if (options.json && (!is_cut || options.json == "-"))
    deliver(json_text(json(course, scene, options)), options.json);
  if (folder && control.should_stop())
    folder->keep_earlier();
  if (folder && !course.answers.empty()) {
    const auto file = finish(*folder, scene, course.answers, course.results);
    if (options.json != "-" && !not_printed)
      fmt::print("wrote {}\n", file.string());
  }
  const bool is_drawn = !options.picture || is_cut ||
                        tell_of_picture(draw_curves(scene, course.curves, *options.picture), *options.picture,
                                        options.json != "-");
  if (not_printed)
    std::rethrow_exception(not_printed);
  return is_cut || !is_drawn || !is_filmed || course.has_failed ? exit_run_failed : exit_done;
}

} // namespace maille::studies
