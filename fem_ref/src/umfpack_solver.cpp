#include "linear_solvers.hpp"

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

} // namespace

Solution solve_by_umfpack(const LinearSystem& system, Watch& watch) {
  const Columns A(system.matrix);
  Umfpack umfpack;
  const auto n = static_cast<SuiteSparse_long>(system.n());
  SuiteSparse_long status = umfpack_dl_symbolic(n, n, A.start.data(), A.row.data(), A.value.data(),
                                                &umfpack.symbolic, umfpack.control, umfpack.info);
  if (status != UMFPACK_OK)
    return end_with(Status::failed, reason(status));
  // Entries of L + U without pivoting; fronts and growth of the arrays come on top, hence twice.
  const double needed = 2 * 8 * umfpack.info[UMFPACK_SYMMETRIC_LUNZ];
  if (const auto available = static_cast<double>(available_memory()); needed > available)
    return end_with(Status::refused, fmt::format("UMFPACK's factors need about {}, {} are available",
                                                 bytes_in_words(needed), bytes_in_words(available)));
  if (watch.should_stop())
    return end_with(watch.status(), "stopped before the factorisation");
  watch.report(0.3, "factorising");
  status = umfpack_dl_numeric(A.start.data(), A.row.data(), A.value.data(), umfpack.symbolic,
                              &umfpack.numeric, umfpack.control, umfpack.info);
  if (status != UMFPACK_OK)
    return end_with(Status::failed, reason(status));
  Solution solution;
  solution.seconds_setup = watch.seconds();
  solution.bytes =
      system.bytes() + static_cast<std::int64_t>(A.bytes()) +
      static_cast<std::int64_t>(umfpack.info[UMFPACK_PEAK_MEMORY] * umfpack.info[UMFPACK_SIZE_OF_UNIT]);
  solution.u.reinit(system.right_hand_side.size());
  status = umfpack_dl_solve(UMFPACK_A, A.start.data(), A.row.data(), A.value.data(), solution.u.begin(),
                            system.right_hand_side.begin(), umfpack.numeric, umfpack.control, umfpack.info);
  return status == UMFPACK_OK ? solution : end_with(Status::failed, reason(status));
}

} // namespace maille::fem_ref
