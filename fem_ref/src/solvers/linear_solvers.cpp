#include "solvers/linear_solvers.hpp"

#include "maille/base/arena.hpp"

#include "maille/plugins/sparse_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace maille::fem_ref {
namespace {

/// Times on one core of a server of 2023 with OpenBLAS, fitted to bodies of 2,000 to 130,000 unknowns, Q1 and
/// Q2, in 2D and 3D (within 30 %). Only their ratio matters: a slower machine is slower at both.
constexpr double seconds_per_flop = 1 / 3.5e10;
constexpr double seconds_per_factor_byte = 1.2e-9;
constexpr double seconds_per_entry_of_cg = 2.4e-7; ///< copy, hierarchy and iterations to 1e-10

/// Lower bound of smallest over largest pivot. For motions of zero energy rounding gives about 1e-16; a
/// contrast of 1e9 between materials is far above.
constexpr double smallest_pivot_ratio = 1e-15;

/// Largest over smallest diagonal entry: contrast of stiffness from materials, anisotropy and voids.
double contrast(const LinearSystem& system) {
  double least = std::numeric_limits<double>::infinity(), greatest = 0;
  for (dealii::types::global_dof_index i = 0; i < system.matrix.m(); ++i) {
    if (system.constraints.is_constrained(i))
      continue;
    least = std::min(least, system.matrix.diag_element(i));
    greatest = std::max(greatest, system.matrix.diag_element(i));
  }
  return greatest > 0 && least > 0 ? greatest / least : 1;
}

/// Iterations take half of the time for a homogeneous body. Their number grows with the contrast: measured 14
/// at 1, 136 at 3,000 (muscle between tendons).
double seconds_by_cg(const LinearSystem& system) {
  const double growth = 1 + 2.5 * std::log10(contrast(system));
  return seconds_per_entry_of_cg * static_cast<double>(system.n_entries()) * (0.5 + 0.5 * growth);
}

/// Lower bound of the factor's flops by nested dissection, from the mean cross-section of the body only: 17
/// dense factors of the first separator for every stretch as long as it is wide. Within 10 % on cubes, too
/// low elsewhere.
double flops_at_least(const LinearSystem& system) {
  const double nodes = static_cast<double>(system.n()) / system.dimension;
  const auto longest = static_cast<double>(system.longest);
  const double section = std::max(1.0, nodes / longest);
  const double width = system.dimension > 1 ? std::pow(section, 1.0 / (system.dimension - 1)) : 1.0;
  return 17.0 / 3.0 * std::pow(system.dimension * section, 3) * std::max(1.0, longest / width);
}

std::string with_commas(std::int64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t place = text.size(); place > 3; place -= 3)
    text.insert(place - 3, 1, ',');
  return text;
}

std::string in_words(const LinearSystem& system, std::string_view solver, const std::string& why = {}) {
  return solver_in_words(system.degree, system.n_free(), solver, why);
}

Preparation by_cg(LinearSystem& system, const Options& options, Watch& watch, const std::string& why = {}) {
  const std::string words = in_words(system, "CG with smoothed-aggregation AMG", why);
  Preparation preparation = prepare_amg(system, options.tolerance, watch);
  preparation.algorithm = words;
  return preparation;
}

/// A factor of the whole system, analysed at construction.
class FactorSolver : public PreparedSolver {
public:
  /// Orders by nodes, keeping their unknowns together: in 3D the graph has a ninth of the edges.
  explicit FactorSolver(const LinearSystem& system)
      : lower_(lower_triangle(system.matrix)), bytes_(system.bytes()) {
    std::vector<std::int32_t> node(system.n());
    for (std::size_t i = 0; i < node.size(); ++i)
      node[i] = static_cast<std::int32_t>(i) / system.dimension;
    factor_ = sparse_cholesky(lower_, node, false);
  }
  const SparseCholesky& factor() const { return *factor_; }

  /// Result without `solver`: that is this object.
  Preparation factorise(Watch& watch);
  Solution solve(const dealii::Vector<double>& f, Watch& watch) override {
    if (watch.should_stop())
      return end_with(watch.status(), "stopped before the solution");
    Solution solution;
    const Eigen::MatrixXd u = factor_->solve(Eigen::Map<const Eigen::VectorXd>(f.begin(), lower_.rows()));
    solution.u = dealii::Vector<double>(u.data(), u.data() + u.size());
    return solution;
  }

private:
  /// Rows of the symmetric matrix, from the diagonal on, are columns of its lower triangle.
  static Eigen::SparseMatrix<double> lower_triangle(const dealii::SparseMatrix<double>& K);

  Eigen::SparseMatrix<double> lower_;
  std::int64_t bytes_;
  std::unique_ptr<SparseCholesky> factor_;
};

Eigen::SparseMatrix<double> FactorSolver::lower_triangle(const dealii::SparseMatrix<double>& K) {
  const auto n = static_cast<int>(K.m());
  Eigen::SparseMatrix<double> lower(n, n);
  lower.reserve(static_cast<Eigen::Index>(K.n_nonzero_elements() + K.m()) / 2);
  for (int i = 0; i < n; ++i) {
    lower.startVec(i);
    for (auto entry = K.begin(i); entry != K.end(i); ++entry) // deal.II keeps the diagonal first
      if (const auto column = static_cast<int>(entry->column()); column >= i)
        lower.insertBack(column, i) = entry->value();
  }
  lower.finalize();
  return lower;
}

Preparation FactorSolver::factorise(Watch& watch) {
  if (watch.should_stop())
    return give_up(watch.status(), "stopped before the factorisation");
  watch.report(0.3, "factorising");
  Preparation preparation;
  preparation.bytes =
      bytes_ + factor_->bytes() + lower_.nonZeros() * static_cast<std::int64_t>(sizeof(double) + sizeof(int));
  const double pivots = factor_->factor(lower_);
  if (pivots < smallest_pivot_ratio)
    return give_up(
        Status::failed,
        fmt::format("the stiffness matrix is {}: part of the body can still move without deforming",
                    pivots == 0 ? "not positive definite" : "singular to working precision"));
  lower_ = Eigen::SparseMatrix<double>(lower_.rows(), 0);
  return preparation;
}

Preparation by_factor(const LinearSystem& system, std::unique_ptr<FactorSolver> solver, Watch& watch,
                      const std::string& why = {}) {
  Preparation preparation = solver->factorise(watch);
  preparation.algorithm = in_words(system, solver->factor().name(), why);
  if (preparation.status == Status::done)
    preparation.solver = std::move(solver);
  return preparation;
}

Preparation by_factor_alone(const LinearSystem& system, Watch& watch) {
  auto solver = std::make_unique<FactorSolver>(system);
  const auto needed = static_cast<double>(solver->factor().bytes()),
             available = static_cast<double>(available_memory());
  if (needed > available)
    return give_up(Status::refused, fmt::format("CHOLMOD's factor needs {}, {} are available",
                                                bytes_in_words(needed), bytes_in_words(available)));
  return by_factor(system, std::move(solver), watch);
}

/// Selects the faster solver by the times above; CG if the factor does not fit into memory.
Preparation by_the_quicker(LinearSystem& system, const Options& options, Watch& watch) {
  const double by_iterations = seconds_by_cg(system);
  // If a factor is far too expensive, even counting its entries takes too long.
  if (const double flops = flops_at_least(system); flops * seconds_per_flop > 1.2 * by_iterations)
    return by_cg(system, options, watch, fmt::format("a factor would take some {:.0f} GFLOP", flops / 1e9));
  std::string why_not;
  try {
    auto solver = std::make_unique<FactorSolver>(system);
    const auto needed = static_cast<double>(solver->factor().bytes());
    const double operations = solver->factor().n_operations();
    if (needed > static_cast<double>(available_memory()))
      why_not = fmt::format("a factor would need {}", bytes_in_words(needed));
    else if (operations * seconds_per_flop + needed * seconds_per_factor_byte > by_iterations)
      why_not =
          fmt::format("a factor would take {:.2g} GFLOP and {}", operations / 1e9, bytes_in_words(needed));
    else
      return by_factor(system, std::move(solver), watch,
                       fmt::format("a factor of {}", bytes_in_words(needed)));
  } catch (const std::bad_alloc&) {
    why_not = "no memory for a factor";
  }
  return by_cg(system, options, watch, why_not);
}

} // namespace

std::string solver_in_words(int degree, std::int64_t n_free, std::string_view solver,
                            const std::string& why) {
  return fmt::format("Q{}, {}{}{}{}, {} unknowns", degree, solver, why.empty() ? "" : " (", why,
                     why.empty() ? "" : ")", with_commas(n_free));
}

Solution end_with(Status status, std::string message) {
  Solution solution;
  solution.status = status;
  solution.message = std::move(message);
  return solution;
}

Preparation give_up(Status status, std::string message) {
  Preparation preparation;
  preparation.status = status;
  preparation.message = std::move(message);
  return preparation;
}

Preparation prepare(LinearSystem& system, const Options& options, Watch& watch) {
  switch (options.solver) {
  case LinearSolver::cholmod:
    return by_factor_alone(system, watch);
  case LinearSolver::cg_amg:
    return by_cg(system, options, watch);
  default:
    return by_the_quicker(system, options, watch);
  }
}

} // namespace maille::fem_ref
