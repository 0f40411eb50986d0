#include "cli/commands.hpp"
#include "cli/inputs.hpp"

#include "export/whole_file.hpp"
#include "maille/scene/read_scene.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"
#include "study/study_sensitivity.hpp"
#include "study/table_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
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
  options.overwrite = asked.overwrite;
  if (asked.overwrite && (asked.resume || !asked.shard.empty()))
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

/// What a study was, and what became of it.
struct StudyResult {
  const StudyFile* study;
  const StudyOutcome* outcome;
};

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

nlohmann::ordered_json json(const StudyFile& study, const StudyOutcome& outcome,
                            const std::vector<StudySensitivity>& sensitivity) {
  nlohmann::ordered_json out = columns_of_result().json({&study, &outcome});
  out["sensitivity"] = json(sensitivity);
  return out;
}

std::string words(const StudyFile& study, const StudyOutcome& outcome,
                  const std::vector<StudySensitivity>& sensitivity) {
  std::string text = fmt::format(
      "{}\n{} cases in {}{}{}{}\n\n", study.title, outcome.n_cases, time_in_words(outcome.seconds),
      outcome.is_interrupted ? ", interrupted" : "",
      outcome.n_reused > 0 ? fmt::format(", {} rows were there", outcome.n_reused) : "",
      outcome.n_left_over > 0 ? fmt::format(", {} rows of other scenes put aside", outcome.n_left_over) : "");
  text += summary(outcome.rows);
  text += in_words(sensitivity, default_response(outcome.rows));
  for (const StudyRow& row : outcome.rows)
    if (lacks_file(study, row))
      text += fmt::format("case {}, {}: {}; --resume tries again\n", row.number, row.method, row.message);
  if (const auto n = std::ranges::count_if(outcome.rows, may_end_otherwise); n > 0)
    text += fmt::format("{} of these failures may be the machine's: --resume tries them again\n", n);
  for (const auto& file : outcome.files)
    text += fmt::format("wrote {}\n", file.string());
  return text;
}

/// What `maille report` says about the study beside its table. @return the file
std::filesystem::path write_about(const StudyFile& study, const StudyOptions& options,
                                  const std::vector<StudySensitivity>& sensitivity) {
  std::string explained;
  for (const StudyScene& scene : study.scenes)
    explained += fmt::format("{}\n{}\n", scene.file.filename().string(),
                             explanation(parse_scene(scene.text, scene.file)));
  nlohmann::ordered_json about{{"kind", "study"}, {"study", study.name()}, {"title", study.title}};
  about.update(asked_about(study.file, explained));
  about["sensitivity"] = json(sensitivity);
  const std::filesystem::path file = table_stem(study, options).string() + "_about.json";
  write_whole(file, about.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  return file;
}

/// Draws the picture; on failure says why on stderr.
bool draw(const StudyFile& study, const StudyOutcome& outcome, const StudyCommandOptions& asked) {
  const auto why_not = draw_study(outcome.rows, study.title, *asked.picture, asked.picture_of);
  if (why_not)
    no_picture(*why_not, *asked.picture);
  else if (asked.json != "-")
    fmt::print("wrote {}\n", *asked.picture);
  return !why_not;
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
  prepare_file("--picture", asked.picture);
  prepare_file("--json", asked.json);
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
  const auto sensitivity =
      options.shards == 1 ? sensitivities(study, outcome.rows) : std::vector<StudySensitivity>();
  outcome.files.push_back(write_about(study, options, sensitivity));
  if (asked.json != "-")
    deliver(words(study, outcome, sensitivity), std::nullopt);
  if (asked.json)
    deliver(json_text(json(study, outcome, sensitivity)), asked.json);
  const bool is_drawn = !asked.picture || draw(study, outcome, asked);
  const bool any_failed = std::ranges::any_of(
      outcome.rows, [&](const StudyRow& row) { return is_failed(row) || lacks_file(study, row); });
  return !is_drawn || outcome.is_interrupted || any_failed ? exit_run_failed : exit_done;
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
      const auto sensitivity = sensitivities(*study, table.rows);
      text += fmt::format("wrote {}\n", write_about(*study, whole, sensitivity).string()) +
              in_words(sensitivity, default_response(table.rows));
    }
    deliver(text, std::nullopt);
    is_whole = is_whole && table.missing == 0;
  }
  return is_whole ? exit_done : exit_run_failed;
}

} // namespace maille::studies
