#pragma once
/// Ways to solve K u = f for many f, and the choice between them.

#include "maille/fem_ref/solve.hpp"
#include "process/abandonable.hpp"
#include "solvers/linear_system.hpp"

#include <memory>

namespace maille::fem_ref {

struct Solution {
  Status status = Status::done;
  std::string message;
  dealii::Vector<double> u; ///< zero where prescribed; empty where there is none
  std::int64_t iterations = 0;
};

/// A factor or a hierarchy, kept for as many loads as come.
class PreparedSolver {
public:
  virtual ~PreparedSolver() = default;
  /// @param f zero where prescribed
  virtual Solution solve(const dealii::Vector<double>& f, Watch& watch) = 0;
};

struct Preparation {
  Status status = Status::done;
  std::string message;
  std::string algorithm;                  ///< as in Answer
  std::int64_t bytes = 0;                 ///< of matrix and solver together, at their peak
  std::unique_ptr<PreparedSolver> solver; ///< none unless done
};

/// Without displacement or solver, and why.
Solution end_with(Status status, std::string message);
Preparation give_up(Status status, std::string message);

/// Empties `system.matrix` and `system.pattern` where that saves memory.
Preparation prepare(LinearSystem& system, const Options& options, Watch& watch);

/// These fill everything but `algorithm`.
Preparation prepare_umfpack(const LinearSystem& system, Watch& watch);
Preparation prepare_amg(LinearSystem& system, double tolerance, Watch& watch);

/// "Q1, <solver> (<why>), 12,345 unknowns"
std::string solver_in_words(int degree, std::int64_t n_free, std::string_view solver,
                            const std::string& why = {});

} // namespace maille::fem_ref
