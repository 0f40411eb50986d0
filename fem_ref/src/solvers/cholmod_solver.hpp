#pragma once
/// Sparse Cholesky by CHOLMOD, in steps, so that its price is known before it is paid.

#include "solvers/linear_solvers.hpp"

#include <cholmod.h>

namespace maille::fem_ref {

class CholmodSolver : public PreparedSolver {
public:
  explicit CholmodSolver(const LinearSystem& system);
  ~CholmodSolver() override;
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  /// Orders by METIS' nested dissection on the graph of the nodes (whose unknowns stay together, so the graph
  /// has a ninth of the edges in 3D) and counts what the factor will hold. False where memory ran out.
  bool analyse();
  double flops() const { return common_.fl; }
  std::int64_t factor_bytes() const;
  bool is_supernodal() const { return factor_ != nullptr && factor_->is_super != 0; }

  /// Factorises; the system is not needed afterwards. Without a solver, which this is. @pre analyse() gave
  /// true
  Preparation factorise(Watch& watch);
  Solution solve(const dealii::Vector<double>& f, Watch& watch) override;

private:
  std::vector<SuiteSparse_long> nested_dissection();
  void fill_matrix();
  std::string why_not_factorised() const;

  const LinearSystem* system_;
  cholmod_common common_{};
  cholmod_sparse* matrix_ = nullptr; ///< upper triangle
  cholmod_factor* factor_ = nullptr;
};

} // namespace maille::fem_ref
