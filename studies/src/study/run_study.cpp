#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "study/study_run.hpp"
#include "study/table_files.hpp"
#include "study/worker_pool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <set>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// A case and its missing rows.
struct Task {
  StudyCase one;
  std::vector<std::string> methods, hashes;
};

std::string settings_in_words(const StudyOptions& options) {
  return std::string(fem_ref::linear_solver_names[static_cast<std::size_t>(options.solver)]);
}

/// A table to be replaced: renamed while the study runs, and deleted with its files at the end.
class OlderTable {
public:
  /// @throws FolderTaken if an existing file is not a table of a study
  explicit OlderTable(const fs::path& stem)
      : table_(with(stem, ".jsonl")), aside_(with(stem, "_older.jsonl")) {
    const fs::path csv = with(stem, ".csv");
    for (const fs::path& file : {table_, aside_, csv})
      check(file);
    std::error_code error;
    fs::remove(csv, error);
    is_aside_ = fs::exists(table_, error);
    if (is_aside_)
      fs::rename(table_, aside_);
  }

  /// @param rows of the new table @param study its name, the prefix of its files
  void remove_but(const std::vector<StudyRow>& rows, const std::string& study) const {
    if (!is_aside_)
      return;
    std::set<std::string> kept;
    for (const StudyRow& row : rows)
      kept.insert(row.vtk);
    std::error_code error; // a failure harms no result
    StudyTable older;
    try {
      older = read_study_table(aside_);
    } catch (const InputError&) { // keep its files and the table that names them
      return;
    }
    for (const StudyRow& row : older.rows)
      if (const fs::path file = aside_.parent_path() / row.vtk; is_name_of_result(row.vtk, study) &&
                                                                !kept.contains(row.vtk) &&
                                                                has_provenance(file) && !is_kept_input(file))
        remove_result(file);
    fs::remove(aside_, error);
  }

  static void check(const fs::path& file) {
    std::error_code error;
    if (const fs::file_status status = fs::symlink_status(file, error);
        fs::exists(status) && (is_kept_input(file) || !is_own_result(file, columns_of_study().csv_head())))
      throw FolderTaken(fmt::format(
          "{}: expected a table of a study, which --overwrite replaces, found another file", file.string()));
  }

private:
  static fs::path with(fs::path stem, const char* ending) { return stem += ending; }

  fs::path table_, aside_;
  bool is_aside_ = false;
};

class StudyRun {
public:
  StudyRun(const StudyFile& study, const StudyOptions& options, const Control& control,
           const StudyProgress& progress)
      : study_(study), options_(options), control_(control), progress_(progress),
        stem_(table_stem(study, options)),
        lock_(options.out, stem_.filename().string(),
              options.shards > 1 ? FolderLock::Sharing::parts : FolderLock::Sharing::none) {}

  StudyOutcome run();

private:
  void take_up();
  void plan();
  /// Existing row of this case and method, under any case number; nothing if none exists.
  std::optional<StudyRow> known_row(const StudyCase& one, const std::string& method,
                                    const std::string& hash) const;
  void keep_left_overs();
  void work();
  void add(const TaskResult& result);
  /// Adds failed rows for methods of a task that have no row.
  void add_missing(const Task& task, const std::string& reason, std::vector<StudyRow>& rows) const;

  const StudyFile& study_;
  const StudyOptions& options_;
  const Control& control_;
  const StudyProgress& progress_;
  fs::path stem_;
  FolderLock lock_;
  std::optional<OlderTable> older_;            ///< with --overwrite
  std::multimap<std::string, StudyRow> found_; ///< by hash
  int n_cases_of_all_ = 0;
  std::vector<Task> tasks_;
  std::optional<TableAppender> files_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  int n_done_ = 0;
  StudyOutcome outcome_;
};

void StudyRun::take_up() {
  for (const char* ending : {".jsonl", ".csv"}) {
    fs::path file = stem_;
    file += ending;
    std::error_code no_matter;
    if (!fs::exists(file, no_matter) || fs::file_size(file, no_matter) == 0)
      continue;
    if (!options_.resume)
      throw FolderTaken(
          fmt::format("{}: expected no table there, or --resume to go on with it", file.string()));
    OlderTable::check(file);
    if (file.extension() == ".jsonl") // of which the other is a copy
      for (StudyRow& row : read_study_table(file).rows) {
        std::string hash = row.hash;
        found_.emplace(std::move(hash), std::move(row));
      }
  }
}

std::optional<StudyRow> StudyRun::known_row(const StudyCase& one, const std::string& method,
                                            const std::string& hash) const {
  const auto [first, last] = found_.equal_range(hash);
  for (auto entry = first; entry != last; ++entry) {
    StudyRow row = entry->second;
    const bool lacks_file =
        study_.wants_vtk(one.number) && has_displacement(row.status) &&
        (row.number != one.number || row.vtk.empty() || !fs::exists(stem_.parent_path() / row.vtk));
    if (row.method != method || lacks_file || may_end_otherwise(row))
      continue;
    // The same scene may be another case of another, or of the changed, study.
    name_case(row, study_, one);
    row.n_cases = n_cases_of_all_;
    if (!study_.wants_vtk(one.number))
      row.vtk.clear();
    return row;
  }
  return std::nullopt;
}

void StudyRun::plan() {
  const std::vector<StudyCase> all = cases(study_);
  n_cases_of_all_ = static_cast<int>(all.size());
  CaseHashes hashes(study_, settings_in_words(options_));
  const std::vector<std::string> methods = study_.row_methods();
  for (const StudyCase& one : all) {
    if ((one.number - 1) % options_.shards != options_.shard - 1)
      continue;
    ++outcome_.n_cases;
    Task task{one, {}, {}};
    const auto of_case = hashes.of_case(one, methods);
    for (std::size_t m = 0; m < methods.size(); ++m)
      if (auto row = known_row(one, methods[m], of_case[m])) {
        outcome_.rows.push_back(std::move(*row));
      } else {
        task.methods.push_back(methods[m]);
        task.hashes.push_back(of_case[m]);
      }
    if (!task.methods.empty())
      tasks_.push_back(std::move(task));
  }
  outcome_.n_reused = static_cast<int>(outcome_.rows.size());
}

/// Moves rows of scenes that are no longer in the study to another file, because they took time.
void StudyRun::keep_left_overs() {
  std::string lines;
  for (const auto& [hash, row] : found_)
    if (!may_end_otherwise(row) && // it has no result
        std::none_of(outcome_.rows.begin(), outcome_.rows.end(),
                     [&hash = hash](const StudyRow& kept) { return kept.hash == hash; })) {
      lines += json_line(row) + "\n";
      ++outcome_.n_left_over;
    }
  if (lines.empty())
    return;
  fs::path file = stem_;
  file += "_older.jsonl";
  const std::string before = fs::exists(file) ? read_own_text_file(file, "a table of a study",
                                                                   std::numeric_limits<std::int64_t>::max())
                                              : std::string();
  write_whole(file, before + lines);
}

void StudyRun::add_missing(const Task& task, const std::string& reason, std::vector<StudyRow>& rows) const {
  for (std::size_t m = 0; m < task.methods.size(); ++m) {
    if (std::ranges::find(rows, task.methods[m], &StudyRow::method) != rows.end())
      continue;
    StudyRow& row = rows.emplace_back(blank_row(study_, task.one, task.methods[m], task.hashes[m], options_));
    row.status = Status::failed;
    row.message = reason;
    row.is_of_machine = true;
  }
}

void StudyRun::add(const TaskResult& result) {
  const Task& task = tasks_[result.task];
  std::vector<StudyRow> rows;
  std::string reason = result.death;
  if (reason.empty())
    try {
      rows = parse_study_table(result.text, stem_).rows;
      reason = "its process wrote a row that cannot be read";
    } catch (const InputError& error) {
      reason = error.what();
    }
  add_missing(task, reason, rows);
  for (StudyRow& row : rows)
    row.n_cases = n_cases_of_all_;
  files_->append(rows);
  outcome_.rows.insert(outcome_.rows.end(), rows.begin(), rows.end());
  ++n_done_;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const int n = static_cast<int>(tasks_.size());
  if (progress_)
    progress_(outcome_.n_cases - n + n_done_, outcome_.n_cases, seconds * (n - n_done_) / n_done_);
}

void StudyRun::work() {
  // Every worker has its own cache. Results of a case do not depend on earlier cases.
  deform::ElasticBody body(deform::Keeping::hierarchy);
  const auto work = [&](std::size_t number, const std::function<bool()>& should_stop) {
    Control control;
    control.stop_requested = should_stop;
    const Task& task = tasks_[number];
    std::string lines;
    for (const StudyRow& row :
         run_case(study_, task.one, task.methods, task.hashes, options_, control, &body))
      lines += json_line(row) + "\n";
    return lines;
  };
  work_through(
      tasks_.size(), options_.jobs, work, [&](const TaskResult& result) { add(result); },
      [&] { return control_.should_stop(); });
}

StudyOutcome StudyRun::run() {
  if (options_.overwrite)
    older_.emplace(stem_);
  take_up();
  plan();
  keep_left_overs();
  const auto methods = study_.row_methods();
  sort_rows(outcome_.rows, methods);
  write_study_table(outcome_.rows, stem_); // removes torn lines and old rows
  if (progress_)
    progress_(outcome_.n_cases - static_cast<int>(tasks_.size()), outcome_.n_cases, 0);
  files_.emplace(stem_);
  work();
  files_.reset();
  outcome_.is_interrupted = n_done_ < static_cast<int>(tasks_.size());
  outcome_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  sort_rows(outcome_.rows, methods);
  outcome_.files = write_study_table(outcome_.rows, stem_);
  if (older_ && !outcome_.is_interrupted)
    older_->remove_but(outcome_.rows, study_.name());
  return std::move(outcome_);
}

} // namespace

fs::path table_stem(const StudyFile& study, const StudyOptions& options) {
  return options.out / (options.shards == 1
                            ? study.name()
                            : fmt::format("{}_{}_of_{}", study.name(), options.shard, options.shards));
}

StudyOutcome run_study(const StudyFile& study, const StudyOptions& options, const Control& control,
                       const StudyProgress& progress) {
  return StudyRun(study, options, control, progress).run();
}

} // namespace maille::studies
