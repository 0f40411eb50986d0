#include "compare/methods.hpp"
#include "export/calculix/calculix.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"
#include "results/result_table.hpp"
#include "results/value.hpp"
#include "verify/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace maille::lab {

Verification::Verification(const VerificationOptions& options)
    : options_(options), methods_({"coupled", "fem_q1", "fem_q2"}) {
  if (has_calculix())
    methods_.push_back("calculix");
}

Scene Verification::scene(const std::string& text) {
  Scene scene = parse_scene("units = \"m, rad\"\n" + text, "verification.toml");
  scene.relaxation.tolerance = 1e-11; // what is verified is the model, not where its iterations end
  return scene;
}

std::optional<Answer> Verification::answer(const Scene& scene, const std::string& method,
                                           const VerificationRow& row) {
  Answer answer = answer_by(scene, method, {});
  if (is_converged(answer.status))
    return answer;
  VerificationRow failed = row;
  failed.method = method;
  failed.quantity += ": " + answer.message;
  failed.computed = std::numeric_limits<double>::quiet_NaN();
  add(std::move(failed));
  return std::nullopt;
}

void Verification::report(std::string_view what, double fraction) const {
  if (options_.progress)
    options_.progress(fraction, what);
}

std::vector<VerificationRow> verify(const VerificationOptions& options) {
  Verification verification(options);
  verification.report("bars", 0);
  verify_bars(verification);
  verification.report("patches", 0.1);
  verify_patches(verification);
  verification.report("orders of convergence", 0.2);
  verify_orders(verification);
  verification.report("beams", 0.6);
  verify_beams(verification);
  verification.report("membrane and plate", 0.7);
  verify_curved(verification);
  verification.report("indentation", 0.8);
  verify_indentation(verification);
  verification.report("done", 1);
  return verification.take();
}

std::optional<double> worst_difference_from_calculix() {
  if (!has_calculix())
    return std::nullopt;
  const std::string
      box = "[specimen]\nshape = \"box\"\nspacing = [\"1 mm\", \"0.8 mm\", \"1.1 mm\"]\ncells = [8, 6, 5]\n",
      pulled = "[[hold]]\nwhere = \"x-\"\n[[load]]\nwhere = \"x+\"\ntraction = [\"1 kPa\", \"0.3 kPa\", 0]\n",
      isotropic = "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.45 }\n",
      orthotropic = "material = { E = [\"50 kPa\", \"20 kPa\", \"10 kPa\"], nu = [0.3, 0.25, 0.35], "
                    "G = [\"12 kPa\", \"9 kPa\", \"5 kPa\"] }\n";
  double worst = 0;
  for (const std::string& matter : {isotropic, orthotropic, orthotropic + "fibre = [0.8, 0.5, 0.3]\n"}) {
    const Scene scene = Verification::scene(box + matter + pulled);
    fem_ref::Options options;
    options.solver = fem_ref::LinearSolver::cholmod;
    const Answer ours = fem_ref::solve(scene, options).answer, theirs = solve_by_calculix(scene);
    if (!is_converged(ours.status) || !is_converged(theirs.status))
      return std::numeric_limits<double>::infinity();
    worst = std::max(worst, compare(scene, theirs.displacement, ours.displacement).relative_max);
  }
  return worst;
}

namespace {

const ResultTable<VerificationRow>& columns_of_verification() {
  static const ResultTable<VerificationRow> table([](ResultTable<VerificationRow>& columns) {
    const auto in_six = [](double value) { return fmt::format("{:.6g}", value); };
    const auto in_two = [](double value) { return fmt::format("{:.1e}", value); };
    columns.add({"", "problem", "", "whose answer is known"}, {"problem"}, &VerificationRow::problem);
    columns.add({"", "method", "", "that answered"}, &VerificationRow::method);
    columns.add({}, {"method"}, [](const VerificationRow& row) { return "`" + row.method + "`"; });
    columns.add({"", "quantity", "", "of the answer"}, {"quantity"}, &VerificationRow::quantity);
    columns.add({"", "expected", "", "see source"}, {"expected", 0, in_six}, &VerificationRow::expected);
    columns.add({"", "computed", "", "by the method"}, {"computed", 0, in_six}, &VerificationRow::computed);
    columns.add({"", "error", "", "relative or absolute"}, {"error", 0, in_two}, &VerificationRow::error);
    columns.add({"", "tolerance", "", "of the error"}, {"tolerance", 0, in_two}, &VerificationRow::tolerance);
    columns.add({"", "met", "", "whether it is"}, &VerificationRow::is_met);
    columns.add({}, {"met"}, [](const VerificationRow& row) { return row.is_met() ? "yes" : "**no**"; });
    columns.add({"", "source", "", "of the expected value"}, &VerificationRow::source);
  });
  return table;
}

} // namespace

BenchReport verification_report(const std::vector<VerificationRow>& rows,
                                std::optional<double> ccx_difference,
                                std::optional<double> ranks_difference) {
  BenchReport report;
  report.machine = describe_machine();
  for (const VerificationRow& row : rows)
    report.rows.push_back(columns_of_verification().json(row));
  const auto missed = std::ranges::count_if(rows, [](const VerificationRow& row) { return !row.is_met(); });
  report.checks.push_back({"verify_missed", static_cast<double>(missed)});
  if (ccx_difference)
    report.checks.push_back({"ccx_worst_relative_difference", *ccx_difference});
  if (ranks_difference) // solved to a relative residual of 1e-12
    report.checks.push_back({"mpi_2_ranks_difference", *ranks_difference});
  return report;
}

std::string verification_page(const std::vector<VerificationRow>& rows) {
  std::string page =
      "# Verification\n\nWritten by `studies/lab/run verify --markdown FILE`. An error is relative to "
      "the "
      "expected value, or, where that is an order\nof convergence or zero, the difference from it.\n\n";
  page += columns_of_verification().markdown(rows);
  page += "\n" + std::string(place_of_checks);
  page += "\nWhere the expected values come from:\n\n";
  std::vector<std::string> known;
  for (const VerificationRow& row : rows)
    if (std::ranges::find(known, row.problem + row.source) == known.end()) {
      known.push_back(row.problem + row.source);
      page += fmt::format("- {}: {}\n", row.problem, row.source);
    }
  return page;
}

} // namespace maille::lab
