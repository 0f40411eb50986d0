#pragma once
/// Linear solvers of K u = f for many f, and the automatic choice.

#include "discretization/body.hpp"
#include "maille/fem_ref/solve.hpp"
#include "process/abandonable.hpp"
#include "solvers/linear_system.hpp"

#include <memory>

namespace maille::fem_ref {

struct Solution {
  Status status = Status::done;
  std::string message;
  dealii::Vector<double> u; ///< zero where prescribed; empty without a solution
  std::int64_t iterations = 0;
};

/// A cached factor or hierarchy, for any number of loads.
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
  std::int64_t bytes = 0;                 ///< peak memory of matrix and solver together
  std::unique_ptr<PreparedSolver> solver; ///< none unless done
};

/// Results without displacement or solver, with the reason.
Solution end_with(Status status, std::string message);
Preparation give_up(Status status, std::string message);

/// Prepares a solver; empties `system.matrix` and `system.pattern` if that saves memory.
Preparation prepare(LinearSystem& system, const Options& options, Watch& watch);

/// These fill all members except `algorithm`.
Preparation prepare_amg(LinearSystem& system, double tolerance, Watch& watch);

/// "Q1, <solver> (<why>), 12,345 unknowns"
std::string solver_in_words(int degree, std::int64_t n_free, std::string_view solver,
                            const std::string& why = {});

/// V-cycles of deal.II's Multigrid in float32 inside its CG in float64: smoothing by Chebyshev polynomials
/// (one before, one after), transfer by MGTransferMatrixFree, a sparse Cholesky factor at the bottom.
/// The element matrix (CellOperator) gives the operators of the levels.
///
/// A coarse node is fixed if a fixed fine node interpolates from it, so coarse corrections never move a fixed
/// node.
/// @pre why_no_hierarchy(scene) is empty, dim >= 2
template<int dim>
Preparation prepare_multigrid(const Scene& scene, const Body<dim>& body,
                              const std::vector<bool>& is_prescribed, const Options& options, Watch& watch);

} // namespace maille::fem_ref
