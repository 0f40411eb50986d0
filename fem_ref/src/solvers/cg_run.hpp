#pragma once
/// One run of deal.II's CG with progress, stop requests and a message at its end.

#include "solvers/linear_solvers.hpp"

#include <algorithm>
#include <cmath>
#include <deal.II/lac/solver_cg.h>
#include <fmt/format.h>

namespace maille::fem_ref {

/// Solves A u = f from the initial u, to |f - A u| <= tolerance |f|; fills all members of `solution` except
/// u.
/// @param should_stop  called before the first and after every iteration
template<class Vector, class Matrix, class Preconditioner, class ShouldStop>
void run_cg(const Matrix& A, Vector& u, const Vector& f, const Preconditioner& preconditioner,
            double tolerance, Watch& watch, Solution& solution, const ShouldStop& should_stop) {
  constexpr unsigned most_iterations = 5000;
  const double size = f.l2_norm();
  if (size == 0)
    return;
  if (should_stop()) { // deal.II's CG does not throw if it is stopped before its first iteration
    solution.status = watch.status();
    solution.message = "stopped before the first iteration";
    return;
  }
  dealii::SolverControl control(most_iterations, tolerance * size, false, false);
  dealii::SolverCG<Vector> cg(control);
  cg.connect([&](unsigned iteration, double residual, const Vector&) {
    solution.iterations = iteration;
    const double digits = std::log(size / std::max(residual, tolerance * size)) / std::log(1 / tolerance);
    watch.report(0.5 + 0.5 * std::clamp(digits, 0.0, 1.0), "iterating");
    return should_stop() ? dealii::SolverControl::failure : dealii::SolverControl::success;
  });
  try {
    cg.solve(A, u, f, preconditioner);
  } catch (const dealii::SolverControl::NoConvergence& stop) {
    const bool was_asked = watch.status() != Status::done;
    solution.status = was_asked ? watch.status() : Status::failed;
    solution.message = fmt::format("CG {} a relative residual of {:.2g} after {} iterations",
                                   was_asked ? "was stopped at" : "did not converge: it stood at",
                                   stop.last_residual / size, stop.last_step);
  }
  if (solution.status == Status::done)
    solution.status = watch.status();
}

template<class Vector, class Matrix, class Preconditioner>
void run_cg(const Matrix& A, Vector& u, const Vector& f, const Preconditioner& preconditioner,
            double tolerance, Watch& watch, Solution& solution) {
  run_cg(A, u, f, preconditioner, tolerance, watch, solution, [&] { return watch.should_stop(); });
}

} // namespace maille::fem_ref
