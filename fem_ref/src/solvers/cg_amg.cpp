#include "maille/base/arena.hpp"
#include "process/mpi.hpp"
#include "solvers/amg_settings.hpp"
#include "solvers/cg_run.hpp"
#include "solvers/linear_solvers.hpp"

#include <Epetra_CrsMatrix.h>
#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>
#include <Teuchos_ParameterList.hpp>
#include <algorithm>
#include <deal.II/lac/trilinos_precondition.h>
#include <ml_MultiLevelPreconditioner.h>

namespace maille::fem_ref {
namespace {

/// Matrices of all levels: 8 bytes a value, 4 a column; the finest is the caller's.
std::int64_t hierarchy_bytes(const dealii::TrilinosWrappers::PreconditionAMG& amg) {
  const auto* ml = dynamic_cast<const ML_Epetra::MultiLevelPreconditioner*>(&amg.trilinos_operator());
  if (ml == nullptr)
    return 0;
  const ML* levels = ml->GetML();
  double entries = 0;
  for (int level = 0; level < levels->ML_num_levels; ++level) {
    entries += levels->Pmat[level].N_nonzeros + levels->Rmat[level].N_nonzeros;
    if (level != levels->ML_finest_level)
      entries += levels->Amat[level].N_nonzeros;
  }
  return static_cast<std::int64_t>(12 * entries);
}

/// A Trilinos matrix for deal.II's CG. Rows are inserted sorted and once, which takes two thirds of the time
/// of dealii::TrilinosWrappers::SparseMatrix::reinit.
class EpetraMatrix {
public:
  explicit EpetraMatrix(const dealii::SparseMatrix<double>& K);
  const Epetra_CrsMatrix& matrix() const { return matrix_; }
  void vmult(dealii::Vector<double>& product, const dealii::Vector<double>& x) const;

private:
  static std::vector<int> row_lengths(const dealii::SparseMatrix<double>& K);

  Epetra_MpiComm self_{MPI_COMM_SELF};
  Epetra_Map rows_;
  Epetra_CrsMatrix matrix_;
};

std::vector<int> EpetraMatrix::row_lengths(const dealii::SparseMatrix<double>& K) {
  std::vector<int> lengths(K.m());
  for (unsigned i = 0; i < K.m(); ++i)
    lengths[i] = static_cast<int>(K.get_sparsity_pattern().row_length(i));
  return lengths;
}

EpetraMatrix::EpetraMatrix(const dealii::SparseMatrix<double>& K)
    : rows_(static_cast<int>(K.m()), 0, self_), matrix_(Copy, rows_, rows_, row_lengths(K).data(), true) {
  std::vector<int> columns;
  std::vector<double> values;
  for (unsigned i = 0; i < K.m(); ++i) {
    columns.clear();
    values.clear();
    const auto diagonal = K.begin(i); // deal.II stores it first, the others ascending
    const auto add = [&](int column, double value) {
      columns.push_back(column);
      values.push_back(value);
    };
    auto entry = diagonal;
    for (++entry; entry != K.end(i) && entry->column() < i; ++entry)
      add(static_cast<int>(entry->column()), entry->value());
    add(static_cast<int>(i), diagonal->value());
    for (; entry != K.end(i); ++entry)
      add(static_cast<int>(entry->column()), entry->value());
    matrix_.InsertMyValues(static_cast<int>(i), static_cast<int>(columns.size()), values.data(),
                           columns.data());
  }
  matrix_.FillComplete(rows_, rows_);
  matrix_.OptimizeStorage();
}

void EpetraMatrix::vmult(dealii::Vector<double>& product, const dealii::Vector<double>& x) const {
  const Epetra_Vector from(View, rows_, const_cast<double*>(x.begin())); // only read
  Epetra_Vector to(View, rows_, product.begin());
  matrix_.Multiply(false, from, to);
}

/// The matrix in Trilinos' form, the hierarchy on it, and CG.
class AmgSolver : public PreparedSolver {
public:
  AmgSolver(const dealii::SparseMatrix<double>& K, double tolerance) : K_(K), tolerance_(tolerance) {}
  void prepare(const LinearSystem& system) {
    std::vector<double> motions =
        rigid_motions(system.positions, system.dimension, box_around(system.positions));
    multigrid_.initialize(K_.matrix(), amg_settings(system.dimension, motions));
  }
  std::int64_t bytes() const { return hierarchy_bytes(multigrid_); }
  Solution solve(const dealii::Vector<double>& f, Watch& watch) override {
    Solution solution;
    solution.u.reinit(f.size());
    run_cg(K_, solution.u, f, multigrid_, tolerance_, watch, solution);
    return solution;
  }

private:
  EpetraMatrix K_;
  dealii::TrilinosWrappers::PreconditionAMG multigrid_;
  double tolerance_;
};

} // namespace

Preparation prepare_amg(LinearSystem& system, double tolerance, Watch& watch) {
  const double before = watch.seconds();
  start_mpi_once();
  watch.exclude(watch.seconds() - before);

  // ML ends the process if a level finds no memory, so check first: the copy, the hierarchy, and as much
  // temporarily.
  const double needed = 3 * 12.0 * static_cast<double>(system.n_entries());
  if (const auto available = static_cast<double>(available_memory()); needed > available)
    return give_up(Status::refused, fmt::format("the hierarchy of AMG needs about {}, {} are available",
                                                bytes_in_words(needed), bytes_in_words(available)));
  Preparation preparation;
  auto solver = std::make_unique<AmgSolver>(system.matrix, tolerance);
  const std::int64_t copy_bytes = 12 * system.n_entries(); // a value and a column each
  preparation.bytes = system.bytes() + copy_bytes;
  system.matrix.clear(); // from here on only the copy is used
  system.pattern.reinit(0, 0, 0);
  if (watch.should_stop())
    return give_up(watch.status(), "stopped before the first iteration");
  solver->prepare(system);
  const std::int64_t d = system.dimension, vectors = d * (d + 1) / 2 + 5;
  preparation.bytes =
      std::max(preparation.bytes, system.bytes() + copy_bytes + solver->bytes() +
                                      vectors * system.n() * static_cast<std::int64_t>(sizeof(double)));
  preparation.solver = std::move(solver);
  return preparation;
}

} // namespace maille::fem_ref
