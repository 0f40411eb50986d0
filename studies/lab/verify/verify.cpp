#include "compare/methods.hpp"
#include "export/calculix/calculix.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"
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

BenchReport verification_report(const std::vector<VerificationRow>& rows,
                                std::optional<double> ccx_difference,
                                std::optional<double> ranks_difference) {
  BenchReport report;
  report.machine = describe_machine();
  for (const VerificationRow& row : rows)
    report.rows.push_back({{"problem", row.problem},
                           {"method", row.method},
                           {"quantity", row.quantity},
                           {"expected", row.expected},
                           {"computed", row.computed},
                           {"error", row.error()},
                           {"tolerance", row.tolerance},
                           {"met", row.is_met()},
                           {"source", row.source}});
  const auto missed = std::ranges::count_if(rows, [](const VerificationRow& row) { return !row.is_met(); });
  report.checks.push_back({"verify_missed", static_cast<double>(missed)});
  if (ccx_difference)
    report.checks.push_back({"ccx_worst_relative_difference", *ccx_difference});
  if (ranks_difference) // solved to a relative residual of 1e-12
    report.checks.push_back({"mpi_2_ranks_difference", *ranks_difference});
  return report;
}

} // namespace maille::lab
