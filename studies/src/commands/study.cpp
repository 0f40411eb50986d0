#include "cli/commands.hpp"
#include "cli/inputs.hpp"

#include "export/whole_file.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/version.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"
#include "study/table_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <thread>

namespace maille::studies {

namespace {

/// `3/16`: the third of sixteen parts.
void read_shard(const std::string& text, StudyOptions& options) {
  const std::size_t slash = text.find('/');
  const auto whole = [](std::string_view part, int& number) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    return error == std::errc{} && end == part.data() + part.size();
  };
  if (slash == std::string::npos || !whole(std::string_view(text).substr(0, slash), options.shard) ||
      !whole(std::string_view(text).substr(slash + 1), options.shards) || options.shard < 1 ||
      options.shard > options.shards)
    throw UsageError(
        fmt::format("--shard: expected i/N with i from 1 to N, such as 3/16, found \"{}\"", text));
}

/// `3 h 12 min`, `12 min 5 s`, `5 s`.
std::string time_in_words(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  if (s >= 3600)
    return fmt::format("{} h {} min", s / 3600, s % 3600 / 60);
  return s >= 60 ? fmt::format("{} min {} s", s / 60, s % 60) : fmt::format("{} s", s);
}

StudyOptions options_of(const StudyCommandOptions& asked, const StudyFile& study) {
  StudyOptions options;
  options.out = asked.out.value_or(std::filesystem::path("out") / study.name());
  options.resume = asked.resume;
  options.overwrite = may_overwrite();
  if (options.overwrite && (asked.resume || !asked.shard.empty()))
    throw UsageError("--overwrite: expected neither --resume nor --shard beside it, found one of them");
  options.jobs = asked.jobs;
  options.solver = check_fem_solver(asked.fem_solver);
  options.unit = length_unit(asked.unit);
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  options.threads = asked.threads > 0 ? asked.threads : std::max(1, cores / asked.jobs);
  if (!asked.shard.empty())
    read_shard(asked.shard, options);
  return options;
}

/// True if a requested file for ParaView is missing.
bool lacks_file(const StudyFile& study, const StudyRow& row) {
  return row.vtk.empty() && study.wants_vtk(row.number) && has_displacement(row.status);
}

bool is_failed(const StudyRow& row) {
  if (row.status == Status::clamped && !row.cut_is_allowed)
    return true;
  return !is_converged(row.status) && !(row.status == Status::refused && !row.reference.empty());
}

/// A study and its results.
struct StudyResult {
  const StudyFile* study;
  const StudyOutcome* outcome;
};

std::filesystem::path about_file(const StudyFile& study, const StudyOptions& options) {
  return table_stem(study, options).string() + "_about.json";
}

std::vector<std::string> files_of(const StudyOutcome& outcome) {
  return {outcome.files.begin(), outcome.files.end()};
}

const ResultTable<StudyResult>& columns_of_result() {
  static const ResultTable<StudyResult> table([](ResultTable<StudyResult>& columns) {
    constexpr auto study = &StudyResult::study;
    constexpr auto outcome = &StudyResult::outcome;
    columns.add({"", "study", "", "its name"}, study, &StudyFile::name);
    columns.add({"", "title", "", "as the study has it"}, study, &StudyFile::title);
    columns.add({"", "cases", "", "of this part"}, outcome, &StudyOutcome::n_cases);
    columns.add({"", "reused_rows", "", "that --resume found"}, outcome, &StudyOutcome::n_reused);
    columns.add({"", "left_over_rows", "", "of other scenes, put aside"}, outcome,
                &StudyOutcome::n_left_over);
    columns.add({"", "interrupted", "", "before the last case"}, outcome, &StudyOutcome::is_interrupted);
    columns.add({"", "seconds", "s", "of this run"}, outcome, &StudyOutcome::seconds);
    columns.add({"", "files", "", "that were written"}, outcome, files_of);
    columns.add_rows({"", "rows", "", "a row a case and a method"}, columns_of_study(), outcome,
                     &StudyOutcome::rows);
  });
  return table;
}

std::string head_in_words(const StudyFile& study, const StudyOutcome& outcome) {
  return fmt::format(
      "{}\n{} cases in {}{}{}{}\n\n", study.title, outcome.n_cases, time_in_words(outcome.seconds),
      outcome.is_interrupted ? ", interrupted" : "",
      outcome.n_reused > 0 ? fmt::format(", {} rows were there", outcome.n_reused) : "",
      outcome.n_left_over > 0 ? fmt::format(", {} rows of other scenes put aside", outcome.n_left_over) : "");
}

std::string notes_in_words(const StudyFile& study, const StudyOutcome& outcome) {
  std::string text;
  for (const StudyRow& row : outcome.rows)
    if (lacks_file(study, row))
      text += fmt::format("case {}, {}: {}; --resume tries again\n", row.number, row.method, row.message);
  if (const auto n = std::ranges::count_if(outcome.rows, may_end_otherwise); n > 0)
    text += fmt::format("{} of these failures may be the machine's: --resume tries them again\n", n);
  for (const auto& file : outcome.files)
    text += fmt::format("wrote {}\n", file.string());
  return text;
}

nlohmann::ordered_json parameter_json(const StudyParameter& parameter) {
  nlohmann::ordered_json out{{"column", parameter.column()}};
  if (parameter.values.empty() && parameter.range) {
    out["range"] = {parameter.range->from, parameter.range->to};
    out["logarithmic"] = parameter.range->is_logarithmic;
    out["normal"] = parameter.range->is_normal;
    return out;
  }
  out["values"] = nlohmann::ordered_json::array();
  for (const StudyValue& value : parameter.values)
    std::visit([&](const auto& shown) { out["values"].push_back(shown); }, value.shown);
  return out;
}

/// Sampling plan, which determines the estimator of sensitivity.
nlohmann::ordered_json plan_json(const StudyFile& study) {
  constexpr std::array names{"grid", "zip", "latin_hypercube", "sobol", "saltelli"};
  nlohmann::ordered_json plan{{"combine", names.at(static_cast<std::size_t>(study.combination))},
                              {"points", n_cases(study) / static_cast<std::int64_t>(study.scenes.size())},
                              {"scenes", nlohmann::ordered_json::array()},
                              {"methods", study.row_methods()},
                              {"parameters", nlohmann::ordered_json::array()}};
  for (const StudyScene& scene : study.scenes)
    plan["scenes"].push_back(scene.name());
  for (const StudyParameter& parameter : study.parameters)
    plan["parameters"].push_back(parameter_json(parameter));
  return plan;
}

/// Request to the Python program for either command: rows, plan, and the file for `maille report`.
nlohmann::ordered_json request_of(const char* kind, const StudyFile& study, const StudyOptions& options,
                                  nlohmann::ordered_json document, int exit_code) {
  std::string explained;
  for (const StudyScene& scene : study.scenes)
    explained += fmt::format("{}\n{}\n", scene.file.filename().string(),
                             explanation(parse_scene(scene.text, scene.file)));
  nlohmann::ordered_json about{{"kind", "study"}, {"study", study.name()}, {"title", study.title}};
  about.update(asked_about(study.file, explained));
  const bool is_whole = options.shards == 1;
  return {{"kind", kind},
          {"document", std::move(document)},
          {"plan", is_whole ? plan_json(study) : nlohmann::ordered_json()},
          {"about", std::move(about)},
          {"about_file", about_file(study, options).string()},
          {"exit_code", exit_code}};
}

} // namespace

int study_command(const StudyCommandOptions& asked) {
  const StudyFile study = read_study(asked.study);
  keep_inputs({asked.study});
  const StudyOptions options = options_of(asked, study);
  if (asked.picture && !asked.picture->ends_with(".png") && !asked.picture->ends_with(".svg"))
    throw UsageError(
        fmt::format("--picture: expected a name that ends in .png or .svg, found \"{}\"", *asked.picture));
  auto names = study_responses();
  for (const MeasureColumn& column : study.measures)
    names.push_back(column.name);
  if (!asked.picture_of.empty() && std::ranges::find(names, asked.picture_of) == names.end())
    throw UsageError(fmt::format("--picture-of: expected one of {}, found \"{}\"", fmt::join(names, ", "),
                                 asked.picture_of));
  prepare_folder(options.out);
  for (const auto& [option, file] : {std::pair("--picture", asked.picture), {"--json", asked.json}}) {
    prepare_file(option, file);
    refuse_name_of_result(option, file, options.out,
                          [&](const std::string& name) { return is_name_of_result(name, study.name()); });
  }
  const Control control = terminal_control(options.threads);
  StudyProgress progress;
  if (control.progress)
    progress = [&](int done, int of, double seconds_left) {
      control.progress(static_cast<double>(done) / of,
                       fmt::format("{} of {} cases{}", done, of,
                                   seconds_left > 0 ? ", " + time_in_words(seconds_left) + " left" : ""));
    };
  StudyOutcome outcome;
  try {
    outcome = run_study(study, options, control, progress);
  } catch (const FolderTaken& error) {
    throw UsageError(fmt::format("--out {}", error.what()));
  }
  end_progress();
  outcome.files.push_back(about_file(study, options));
  const bool any_failed = std::ranges::any_of(
      outcome.rows, [&](const StudyRow& row) { return is_failed(row) || lacks_file(study, row); });
  nlohmann::ordered_json request =
      request_of("study", study, options, columns_of_result().json({&study, &outcome}),
                 outcome.is_interrupted || any_failed ? exit_run_failed : exit_done);
  if (!asked.json) // statistics do not use the rest, and there may be many rows
    for (nlohmann::ordered_json& row : request["document"]["rows"])
      for (const char* key : {"study", "cases", "hash", "maille", "algorithm", "vtk", "threads", "dimension",
                              "cells", "nodes", "repetitions", "processor_share", "load_average"})
        row.erase(key);
  request["head"] = head_in_words(study, outcome);
  request["notes"] = notes_in_words(study, outcome);
  request["document"]["maille"] = version;
  request["json"] = asked.json.value_or("");
  request["picture"] = asked.picture.value_or("");
  request["picture_of"] = asked.picture_of;
  return become_python_program("statistics", request);
}

int merge_command(const MergeOptions& options) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  for (const fs::path& place : options.places) {
    if (!fs::is_directory(place)) {
      files.push_back(place);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(place))
      if (entry.path().extension() == ".jsonl" && !entry.path().stem().string().ends_with("_older"))
        files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty())
    throw UsageError("DIR: expected folders that hold tables (*.jsonl), found none in them");
  const auto study = options.study ? std::optional(read_study(*options.study)) : std::nullopt;
  if (study)
    keep_inputs({*options.study});
  prepare_folder(options.out);
  bool is_whole = true;
  nlohmann::ordered_json request; // request of the study's table
  for (const MergedTable& table : merge_study_tables(files, options.out)) {
    const auto written = write_study_table(table.rows, options.out / table.study);
    std::string text =
        fmt::format("{}: {} rows{}\n", table.study, table.rows.size(),
                    table.missing > 0 ? fmt::format(", {} cases are missing", table.missing) : "");
    for (const fs::path& file : written)
      text += fmt::format("wrote {}\n", file.string());
    if (study && study->name() == table.study) {
      StudyOptions whole;
      whole.out = options.out;
      request = request_of("merge", *study, whole, {{"rows", columns_of_study().json_rows(table.rows)}}, 0);
    }
    deliver(text, std::nullopt);
    is_whole = is_whole && table.missing == 0;
  }
  const int exit_code = is_whole ? exit_done : exit_run_failed;
  if (request.is_null())
    return exit_code;
  request["exit_code"] = exit_code;
  return become_python_program("statistics", request);
}

} // namespace maille::studies
