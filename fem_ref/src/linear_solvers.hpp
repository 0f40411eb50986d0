#pragma once
/// Ways to solve an assembled system, and the choice between them.

#include "linear_system.hpp"
#include "watch.hpp"

#include "maille/fem_ref/solve.hpp"

namespace maille::fem_ref {

struct Solution {
  Status status = Status::done;
  std::string message;
  std::string algorithm;    ///< as in Answer
  dealii::Vector<double> u; ///< without the prescribed values; empty where there is none
  std::int64_t iterations = 0;
  double residual = 0;      ///< |f - K u|_2 / |f|_2, computed from the result
  double seconds_setup = 0; ///< by the watch: when factor or hierarchy were ready
  std::int64_t bytes = 0;   ///< of the system and the solver together, at their peak
};

/// A solution without displacement that says why.
Solution end_with(Status status, std::string message);

/// Empties `system.matrix` where that saves memory.
Solution solve_linear_system(LinearSystem& system, const Options& options, Watch& watch);

/// These fill everything but `algorithm`, and for UMFPACK the residual.
Solution solve_by_umfpack(const LinearSystem& system, Watch& watch);
Solution solve_by_cg(LinearSystem& system, double tolerance, Watch& watch);

} // namespace maille::fem_ref
