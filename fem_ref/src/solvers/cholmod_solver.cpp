#include "solvers/cholmod_solver.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace maille::fem_ref {
namespace {

/// Smallest over largest pivot. Rounding leaves about 1e-16 where a motion costs nothing; a contrast of 1e9
/// between materials stays far above.
constexpr double smallest_pivot_ratio = 1e-15;

} // namespace

CholmodSolver::CholmodSolver(const LinearSystem& system) : system_(&system) {
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.error_handler = nullptr;
  common_.supernodal = CHOLMOD_AUTO;
  common_.final_ll = 1; // LL': a negative pivot is seen
  common_.quick_return_if_not_posdef = 1;
}

CholmodSolver::~CholmodSolver() {
  cholmod_l_free_factor(&factor_, &common_);
  cholmod_l_free_sparse(&matrix_, &common_);
  cholmod_l_finish(&common_);
}

/// Rows of the symmetric matrix up to the diagonal are the columns of its upper triangle.
void CholmodSolver::fill_matrix() {
  const auto n = static_cast<std::size_t>(system_->n());
  const auto& K = system_->matrix;
  const std::size_t entries =
      (K.n_nonzero_elements() + n) / 2; // the pattern is symmetric with a full diagonal
  matrix_ = cholmod_l_allocate_sparse(n, n, entries, 1, 1, 1, CHOLMOD_REAL, &common_);
  if (matrix_ == nullptr)
    return;
  auto* start = static_cast<SuiteSparse_long*>(matrix_->p);
  auto* row = static_cast<SuiteSparse_long*>(matrix_->i);
  auto* value = static_cast<double*>(matrix_->x);
  SuiteSparse_long k = 0;
  for (unsigned i = 0; i < n; ++i) {
    start[i] = k;
    auto entry = K.begin(i); // deal.II keeps the diagonal first, then ascending columns
    const double diagonal = entry->value();
    for (++entry; entry != K.end(i) && entry->column() < i; ++entry, ++k) {
      row[k] = entry->column();
      value[k] = entry->value();
    }
    row[k] = i;
    value[k++] = diagonal;
  }
  start[n] = k;
}

std::vector<SuiteSparse_long> CholmodSolver::nested_dissection() {
  const auto d = static_cast<unsigned>(system_->dimension);
  const auto n_nodes = static_cast<unsigned>(system_->n()) / d;
  // Columns of the upper triangle of the node graph. Any free unknown of a node sees all its neighbours.
  std::vector<SuiteSparse_long> start{0}, rows;
  for (unsigned node = 0; node < n_nodes; ++node) {
    unsigned unknown = d * node;
    while (unknown + 1 < d * (node + 1) && system_->constraints.is_constrained(unknown))
      ++unknown;
    SuiteSparse_long last = -1;
    for (auto entry = ++system_->pattern.begin(unknown);
         entry != system_->pattern.end(unknown) && entry->column() < d * node; ++entry)
      if (const SuiteSparse_long neighbour = entry->column() / d; neighbour != last) {
        rows.push_back(neighbour);
        last = neighbour;
      }
    rows.push_back(node);
    start.push_back(static_cast<SuiteSparse_long>(rows.size()));
  }
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = n_nodes;
  graph.nzmax = rows.size();
  graph.p = start.data();
  graph.i = rows.data();
  graph.stype = 1;
  graph.itype = CHOLMOD_LONG;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = graph.packed = 1;
  std::vector<SuiteSparse_long> order(n_nodes), unknowns;
  if (cholmod_l_metis(&graph, nullptr, 0, 1, order.data(), &common_) == 0)
    return {};
  unknowns.reserve(static_cast<std::size_t>(system_->n()));
  for (const SuiteSparse_long node : order)
    for (unsigned c = 0; c < d; ++c)
      unknowns.push_back(d * node + c);
  return unknowns;
}

bool CholmodSolver::analyse() {
  std::vector<SuiteSparse_long> order = nested_dissection();
  if (order.empty())
    return false;
  fill_matrix();
  if (matrix_ == nullptr)
    return false;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.postorder = 1;
  factor_ = cholmod_l_analyze_p(matrix_, order.data(), nullptr, 0, &common_);
  return factor_ != nullptr;
}

std::int64_t CholmodSolver::factor_bytes() const {
  const std::size_t entries = factor_->is_super != 0 ? factor_->xsize + factor_->ssize + factor_->maxcsize
                                                     : 2 * static_cast<std::size_t>(common_.lnz);
  return static_cast<std::int64_t>(entries * sizeof(double));
}

std::string CholmodSolver::why_not_factorised() const {
  if (common_.status == CHOLMOD_NOT_POSDEF)
    return fmt::format(
        "the stiffness matrix is not positive definite (pivot {} of {}): part of the body can still "
        "move without deforming",
        factor_->minor + 1, factor_->n);
  if (common_.status == CHOLMOD_OUT_OF_MEMORY)
    return "out of memory for the factor";
  return fmt::format("CHOLMOD gave up with status {}", common_.status);
}

Preparation CholmodSolver::factorise(Watch& watch) {
  if (watch.should_stop())
    return give_up(watch.status(), "stopped before the factorisation");
  watch.report(0.3, "factorising");
  Preparation preparation;
  cholmod_l_factorize(matrix_, factor_, &common_);
  preparation.bytes = system_->bytes() + static_cast<std::int64_t>(common_.memory_usage);
  if (common_.status != CHOLMOD_OK)
    return give_up(Status::failed, why_not_factorised());
  if (cholmod_l_rcond(factor_, &common_) < smallest_pivot_ratio)
    return give_up(Status::failed,
                   "the stiffness matrix is singular to working precision: part of the body can "
                   "still move without deforming");
  cholmod_l_free_sparse(&matrix_, &common_);
  return preparation;
}

Solution CholmodSolver::solve(const dealii::Vector<double>& f, Watch& watch) {
  if (watch.should_stop())
    return end_with(watch.status(), "stopped before the solution");
  Solution solution;
  cholmod_dense load{};
  load.nrow = load.nzmax = load.d = f.size();
  load.ncol = 1;
  load.x = const_cast<double*>(f.begin()); // only read
  load.xtype = CHOLMOD_REAL;
  cholmod_dense* u = cholmod_l_solve(CHOLMOD_A, factor_, &load, &common_);
  if (u == nullptr)
    return end_with(Status::failed, "out of memory for the solution");
  solution.u.reinit(f.size());
  std::copy_n(static_cast<const double*>(u->x), f.size(), solution.u.begin());
  cholmod_l_free_dense(&u, &common_);
  return solution;
}

} // namespace maille::fem_ref
