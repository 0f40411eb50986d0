/// Running of one case.

#include "compare/comparison.hpp"
#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/measure/measure.hpp"
#include "study/study_run.hpp"
#include "study/table_files.hpp"
#include "study/worker_pool.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <new>
#include <system_error>

namespace maille::studies {

namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

/// Seconds of one method for each repetition.
struct Repeated {
  std::vector<double> setup, solve, total;
  void add(const Seconds& seconds) {
    setup.push_back(seconds.setup);
    solve.push_back(seconds.solve);
    total.push_back(seconds.total());
  }
};

/// Errors in one line, without line numbers, because the text is generated.
std::string words_of(const InputError& error) {
  std::vector<std::string> faults;
  for (const Fault& fault : error.faults())
    faults.push_back(fmt::format("{}: expected {}, found {}", fault.key, fault.expected, fault.found));
  return fmt::format("{}", fmt::join(faults, "; "));
}

/// True if the error is in a file named by the scene, not in the scene.
bool is_of_a_file(const InputError& error) {
  return std::ranges::any_of(
      error.faults(), [](const Fault& fault) { return fault.expected.find("file") != std::string::npos; });
}

/// Magnitude of the total force of all moves; nothing for methods without forces or scenes without moves.
std::optional<double> force_on_moves(const Scene& scene, const Answer& answer) {
  const std::vector<Resultant> moves = resultants_of(scene, answer).moves;
  const Vec3 sum = total_force(moves);
  return moves.empty() ? std::nullopt : std::optional(std::hypot(sum[0], sum[1], sum[2]));
}

class CaseRunner {
public:
  CaseRunner(const StudyFile& study, const StudyCase& one, const std::vector<std::string>& methods,
             const std::vector<std::string>& hashes, const StudyOptions& options, const Control& control,
             deform::ElasticBody* body)
      : study_(study), case_(one), methods_(methods), hashes_(hashes), options_(options), control_(control),
        body_(body) {
    control_.threads = options.threads;
  }

  std::vector<StudyRow> run() {
    try {
      SceneAndMeasures read =
          parse_scene_and_measures(resolved_scene(study_, case_), study_.scenes[case_.scene].file);
      scene_ = std::move(read.scene);
      measures_ = std::move(read.measures);
      solve();
    } catch (const InputError& error) {
      add_failed_rows(words_of(error), is_of_a_file(error));
    } catch (const std::bad_alloc&) {
      add_failed_rows("out of memory", true);
    } catch (const std::system_error& error) {
      add_failed_rows(error.what(), true);
    } catch (const std::exception& error) {
      add_failed_rows(error.what(), false);
    }
    return rows_;
  }

private:
  StudyRow blank(std::size_t method) const {
    return blank_row(study_, case_, methods_[method], method < hashes_.size() ? hashes_[method] : "",
                     options_);
  }
  /// Adds failed rows for the methods without a row; answers of other methods stay.
  void add_failed_rows(const std::string& message, bool is_of_machine);
  void solve();
  Comparison compare_once(const std::vector<std::string>& methods, const std::string& reference);
  void add_row(std::size_t method, const Comparison& comparison, const ComparisonRow& result,
               const Repeated& seconds, const MachineWatch& watch);
  std::string write_file(const StudyRow& row, const ComparisonRow& result, const Comparison& comparison);

  const StudyFile& study_;
  const StudyCase& case_;
  const std::vector<std::string>&methods_, &hashes_;
  const StudyOptions& options_;
  Control control_;
  deform::ElasticBody* body_;
  Scene scene_;
  std::vector<Measure> measures_;
  std::vector<StudyRow> rows_;
};

void CaseRunner::add_failed_rows(const std::string& message, bool is_of_machine) {
  for (std::size_t i = rows_.size(); i < methods_.size(); ++i) {
    StudyRow& row = rows_.emplace_back(blank(i));
    row.status = Status::failed;
    row.message = message;
    row.is_of_machine = is_of_machine;
  }
}

/// Runs the methods once. Finite elements and `coupled` cache their set-up between scenes; for comparable
/// times every repetition starts without a cache and without freed memory of others. In a study of answers
/// only, `coupled` keeps the set-up for the body of the previous case.
Comparison CaseRunner::compare_once(const std::vector<std::string>& methods, const std::string& reference) {
  malloc_trim(0);
  Methods fresh(options_.solver, study_.wants_vtk(case_.number));
  if (body_ != nullptr && study_.repetitions == 1)
    fresh.keep(*body_);
  return compare_methods(scene_, methods, reference, control_, fresh, study_.reference_seconds);
}

void CaseRunner::solve() {
  std::vector<std::string> asked, again;
  for (const std::string& method : methods_)
    if (method != "best")
      asked.push_back(method);
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(again),
               [&](const std::string& method) { return method != study_.reference; });
  const MachineWatch watch;
  Comparison first = compare_once(asked, study_.reference);
  add_measures(scene_, measures_, first);
  std::vector<Repeated> seconds(first.rows.size());
  for (std::size_t i = 0; i < first.rows.size(); ++i)
    seconds[i].add(first.rows[i].answer.seconds);
  for (int repetition = 1; repetition < study_.repetitions && !again.empty(); ++repetition)
    for (const ComparisonRow& row : compare_once(again, "").rows)
      for (std::size_t i = 0; i < first.rows.size(); ++i)
        if (first.rows[i].answer.method == row.answer.method)
          seconds[i].add(row.answer.seconds);
  if (control_.should_stop())
    return;
  for (std::size_t m = 0; m < methods_.size(); ++m)
    for (std::size_t i = 0; i < first.rows.size(); ++i)
      if (first.rows[i].answer.method == methods_[m])
        add_row(m, first, first.rows[i], seconds[i], watch);
}

void CaseRunner::add_row(std::size_t method, const Comparison& comparison, const ComparisonRow& result,
                         const Repeated& seconds, const MachineWatch& watch) {
  const Answer& answer = result.answer;
  StudyRow row = blank(method);
  row.status = answer.status;
  row.message = answer.message;
  row.cut_is_allowed = comparison.cut_is_allowed;
  row.error = result.error;
  row.seconds = {median(seconds.setup), median(seconds.solve)};
  row.total_seconds = median(seconds.total);
  row.timing = options_.jobs > 1 ? Timing::side_by_side : watch.was_busy() ? Timing::busy : Timing::alone;
  row.processor_share = watch.processor_share();
  row.load_average = watch.load_average();
  row.bytes = answer.bytes;
  row.iterations = answer.iterations;
  row.limit_violation = result.limit_violation;
  row.force = force_on_moves(scene_, answer);
  row.strain_energy = answer.strain_energy;
  row.test = test_result(scene_, answer);
  const auto cells = measure_cells(result.measures, true);
  for (StudyMeasure& measure : row.measures)
    if (cells.contains(measure.name) && cells[measure.name].is_number())
      measure.value = cells[measure.name].get<double>();
  row.reference_error = comparison.reference_error;
  row.algorithm = answer.algorithm;
  row.dimension = scene_.dimension();
  row.cells = scene_.specimen.n_matter_cells();
  row.nodes = scene_.specimen.n_matter_nodes();
  if (study_.wants_vtk(case_.number) && has_displacement(answer.status))
    try {
      row.vtk = write_file(row, result, comparison);
    } catch (const std::exception& error) { // results are valid without it
      row.message +=
          fmt::format("{}no file for ParaView: {}", row.message.empty() ? "" : "; ", message_of(error));
    }
  rows_.push_back(std::move(row));
}

std::string CaseRunner::write_file(const StudyRow& row, const ComparisonRow& result,
                                   const Comparison& comparison) {
  ExportFields fields;
  fields.show(result.answer);
  fields.time = case_.number;
  fields.unit = options_.unit;
  const ComparisonRow* reference = comparison.reference_row();
  fields.reference = result.error && reference ? &reference->answer.displacement : nullptr;
  fields.provenance = json_line(row);
  return write_vtk(scene_, fields,
                   options_.out / fmt::format("{}_{:04}_{}", study_.name(), case_.number, row.method))
      .filename()
      .string();
}

} // namespace

std::vector<StudyRow> run_case(const StudyFile& study, const StudyCase& one,
                               const std::vector<std::string>& methods,
                               const std::vector<std::string>& hashes, const StudyOptions& options,
                               const Control& control, deform::ElasticBody* body) {
  return CaseRunner(study, one, methods, hashes, options, control, body).run();
}

} // namespace maille::studies
