#include "solvers/linear_solvers.hpp"

#include "maille/scene/memory.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <umfpack.h>

namespace maille::fem_ref {
namespace {

/// The matrix by columns; it is symmetric, so rows serve.
struct Columns {
  std::vector<SuiteSparse_long> start{0}, row;
  std::vector<double> value;

  explicit Columns(const dealii::SparseMatrix<double>& K) {
    row.reserve(K.n_nonzero_elements());
    value.reserve(K.n_nonzero_elements());
    for (unsigned i = 0; i < K.m(); ++i) {
      const std::size_t first = row.size();
      const auto diagonal = K.begin(i); // deal.II keeps it first
      auto entry = diagonal;
      for (++entry; entry != K.end(i); ++entry) {
        row.push_back(entry->column());
        value.push_back(entry->value());
      }
      const auto place = std::lower_bound(row.begin() + static_cast<std::ptrdiff_t>(first), row.end(),
                                          static_cast<SuiteSparse_long>(i)) -
                         row.begin();
      row.insert(row.begin() + place, i);
      value.insert(value.begin() + place, diagonal->value());
      start.push_back(static_cast<SuiteSparse_long>(row.size()));
    }
  }
  std::size_t bytes() const {
    return (start.size() + row.size()) * sizeof(SuiteSparse_long) + value.size() * sizeof(double);
  }
};

struct Umfpack {
  double control[UMFPACK_CONTROL];
  double info[UMFPACK_INFO];
  void* symbolic = nullptr;
  void* numeric = nullptr;

  Umfpack() {
    umfpack_dl_defaults(control);
    control[UMFPACK_PRL] = 0;
    control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  }
  ~Umfpack() {
    umfpack_dl_free_numeric(&numeric);
    umfpack_dl_free_symbolic(&symbolic);
  }
  Umfpack(const Umfpack&) = delete;
  Umfpack& operator=(const Umfpack&) = delete;
};

std::string reason(SuiteSparse_long status) {
  if (status == UMFPACK_WARNING_singular_matrix)
    return "the stiffness matrix is singular: part of the body can still move without deforming";
  if (status == UMFPACK_ERROR_out_of_memory)
    return "out of memory for the factors";
  return fmt::format("UMFPACK gave up with status {}", status);
}

/// The matrix is kept beside its factors: UMFPACK refines its solutions with it.
class UmfpackSolver : public PreparedSolver {
public:
  explicit UmfpackSolver(const dealii::SparseMatrix<double>& K) : A_(K) {}
  Preparation factorise(const LinearSystem& system, Watch& watch);
  Solution solve(const dealii::Vector<double>& f, Watch& watch) override;

private:
  Columns A_;
  Umfpack umfpack_;
};

Preparation UmfpackSolver::factorise(const LinearSystem& system, Watch& watch) {
  const auto n = static_cast<SuiteSparse_long>(system.n());
  SuiteSparse_long status = umfpack_dl_symbolic(n, n, A_.start.data(), A_.row.data(), A_.value.data(),
                                                &umfpack_.symbolic, umfpack_.control, umfpack_.info);
  if (status != UMFPACK_OK)
    return give_up(Status::failed, reason(status));
  // Entries of L + U without pivoting; fronts and growth of the arrays come on top, hence twice.
  const double needed = 2 * 8 * umfpack_.info[UMFPACK_SYMMETRIC_LUNZ];
  if (const auto available = static_cast<double>(available_memory()); needed > available)
    return give_up(Status::refused, fmt::format("UMFPACK's factors need about {}, {} are available",
                                                bytes_in_words(needed), bytes_in_words(available)));
  if (watch.should_stop())
    return give_up(watch.status(), "stopped before the factorisation");
  watch.report(0.3, "factorising");
  status = umfpack_dl_numeric(A_.start.data(), A_.row.data(), A_.value.data(), umfpack_.symbolic,
                              &umfpack_.numeric, umfpack_.control, umfpack_.info);
  if (status != UMFPACK_OK)
    return give_up(Status::failed, reason(status));
  Preparation preparation;
  preparation.bytes =
      system.bytes() + static_cast<std::int64_t>(A_.bytes()) +
      static_cast<std::int64_t>(umfpack_.info[UMFPACK_PEAK_MEMORY] * umfpack_.info[UMFPACK_SIZE_OF_UNIT]);
  return preparation;
}

Solution UmfpackSolver::solve(const dealii::Vector<double>& f, Watch& watch) {
  if (watch.should_stop())
    return end_with(watch.status(), "stopped before the solution");
  Solution solution;
  solution.u.reinit(f.size());
  const SuiteSparse_long status =
      umfpack_dl_solve(UMFPACK_A, A_.start.data(), A_.row.data(), A_.value.data(), solution.u.begin(),
                       f.begin(), umfpack_.numeric, umfpack_.control, umfpack_.info);
  return status == UMFPACK_OK ? solution : end_with(Status::failed, reason(status));
}

} // namespace

Preparation prepare_umfpack(const LinearSystem& system, Watch& watch) {
  auto solver = std::make_unique<UmfpackSolver>(system.matrix);
  Preparation preparation = solver->factorise(system, watch);
  if (preparation.status == Status::done)
    preparation.solver = std::move(solver);
  return preparation;
}

} // namespace maille::fem_ref
