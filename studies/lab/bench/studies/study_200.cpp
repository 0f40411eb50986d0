#include "bench/studies/studies.hpp"

#include "maille/materials/text_file.hpp"
#include "median.hpp"
#include "study/study_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include <sys/resource.h>

namespace maille::lab {

namespace {

/// Of processes that have ended: the workers.
double processor_seconds_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// A line a method over all cases.
void add_rows(const StudyFile& study, const StudyOutcome& outcome, BenchReport& report) {
  for (const std::string& method : study.row_methods()) {
    std::vector<double> errors, seconds;
    double sum = 0;
    int settled = 0;
    for (const StudyRow& row : outcome.rows) {
      if (row.method != method)
        continue;
      settled += is_converged(row.status);
      seconds.push_back(row.total_seconds);
      sum += row.total_seconds;
      if (row.error)
        errors.push_back(row.error->relative_l2);
    }
    report.rows.push_back(
        {{"study", study.name()},
         {"method", method},
         {"cases", seconds.size()},
         {"settled", settled},
         {"seconds_of_all", sum},
         {"median_seconds", upper_median(seconds)},
         {"median_relative_l2", upper_median(errors)},
         {"largest_relative_l2", errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end())}});
  }
}

} // namespace

void bench_study_200(const BenchOptions& options, BenchReport& report) {
  StudyFile study = read_study(std::filesystem::path(MAILLE_STUDIES) / "anisotropy" / "cube_200.toml");
  if (options.quick)
    for (StudyParameter& parameter : study.parameters)
      parameter.values.resize(1);
  const WorkFolder folder("maille_study");
  StudyOptions run;
  run.out = folder.path();
  run.jobs = 2;
  const double before = processor_seconds_of_children();
  const StudyOutcome outcome = run_study(study, run);
  const double used = processor_seconds_of_children() - before;
  add_rows(study, outcome, report);
  const auto failed = std::count_if(outcome.rows.begin(), outcome.rows.end(),
                                    [](const StudyRow& row) { return !is_converged(row.status); });
  report.notes.push_back(fmt::format("{}: {} cases, {} rows, {} of them not settled; two cases at a time, "
                                     "one thread each; wall seconds, files included",
                                     study.name(), outcome.n_cases, outcome.rows.size(), failed));
  report.checks.push_back(
      {"study_200_seconds", outcome.seconds,
       "250: 2 s a case for the reference, 0.5 s for the rest, on two cores",
       fmt::format("{:.3g}: the processor time of its workers, {:.3g} s, on two cores that "
                   "nothing else wants",
                   used / 2, used)});
}

} // namespace maille::lab
