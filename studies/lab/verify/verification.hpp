#pragma once
/// Problems whose answers are known, and how near the elastic methods come: `studies/lab/run verify`.

#include "bench/bench_report.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

/// One quantity of one problem by one method.
struct VerificationRow {
  std::string problem, method, quantity;
  double expected = 0, computed = 0;
  double tolerance = 0;     ///< of the error
  bool is_absolute = false; ///< the error is computed - expected; else that over expected
  std::string source;       ///< of the expected value

  double error() const { return (computed - expected) / (is_absolute ? 1 : expected); }
  /// False for what is not a number.
  bool is_met() const { return std::abs(error()) <= tolerance; }
};

struct VerificationOptions {
  bool quick =
      false; ///< coarser meshes of what takes long, with the tolerances of the finer ones that they meet
  std::function<void(double fraction, std::string_view what)> progress;
};

/// Runs every problem. Methods: coupled, fem_q1 and fem_q2, and calculix where that program is installed and
/// a displacement is asked for.
/// Cost: some seconds
std::vector<VerificationRow> verify(const VerificationOptions& options);

/// Rows, and the checks verify_missed (problems out of tolerance) and, where CalculiX is installed,
/// ccx_worst_relative_difference (of any displacement from that of fem_q1, over the largest); where
/// mpirun is, mpi_2_ranks_difference.
BenchReport verification_report(const std::vector<VerificationRow>& rows,
                                std::optional<double> ccx_difference,
                                std::optional<double> ranks_difference = {});
/// The largest difference of CalculiX from fem_q1 on an isotropic, an orthotropic and a turned body; nothing
/// without ccx.
std::optional<double> worst_difference_from_calculix();
/// The largest difference of what all ranks solve together from what each solves alone, over the largest
/// displacement: a box and a muscle of two materials, linear and quadratic. Every rank must call it.
double worst_difference_between_ranks();
/// The same, of two ranks of this program, started by mpirun; nothing where that is not installed or fails.
std::optional<double> difference_of_two_ranks(const std::filesystem::path& program);

} // namespace maille::lab
