#include "maille/plugins/sparse_cholesky.hpp"

#include <cholmod.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <dlfcn.h>
#include <new>
#include <optional>
#include <stdexcept>
#include <vector>

namespace maille {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
/// 32-bit indices would limit a factor to 2^31 numbers.
using LongSparse = Eigen::SparseMatrix<double, Eigen::ColMajor, SuiteSparse_long>;

/// CHOLMOD's workspace and settings.
class Common {
public:
  Common() { cholmod_l_start(&common_); }
  ~Common() { cholmod_l_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* operator->() { return &common_; }
  cholmod_common* get() { return &common_; }
  /// @throws std::bad_alloc, std::runtime_error if the last call failed
  void check() const {
    if (common_.status == CHOLMOD_OUT_OF_MEMORY)
      throw std::bad_alloc();
    if (common_.status != CHOLMOD_OK)
      throw std::runtime_error(fmt::format("CHOLMOD gave up with status {}", common_.status));
  }

private:
  cholmod_common common_{};
};

/// Sets OpenBLAS to one thread during its lifetime, because its bits depend on the number of threads. No
/// effect for another BLAS.
class OneThread {
public:
  OneThread() {
    if (const auto most = found<int()>("openblas_get_num_threads"))
      before_ = most();
    set(1);
  }
  ~OneThread() { set(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

private:
  template<class Function>
  static Function* found(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
  }
  static void set(int threads) {
    if (const auto to = found<void(int)>("openblas_set_num_threads"))
      to(threads);
  }
  int before_ = 1;
};

/// CHOLMOD view of the lower triangle of `matrix`.
cholmod_sparse seen(const LongSparse& matrix, int xtype) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(matrix.rows());
  view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
  view.p = const_cast<SuiteSparse_long*>(matrix.outerIndexPtr()); // read only
  view.i = const_cast<SuiteSparse_long*>(matrix.innerIndexPtr());
  view.x = xtype == CHOLMOD_PATTERN ? nullptr : const_cast<double*>(matrix.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_LONG;
  view.xtype = xtype;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

/// Graph of the groups: edges join groups with common entries.
LongSparse graph(const LongSparse& lower, std::span<const std::int32_t> group) {
  const Eigen::Index n = group.empty() ? 0 : group.back() + 1;
  LongSparse of_groups(n, n);
  std::vector<std::int32_t> rows;
  for (Eigen::Index column = 0; column < lower.cols();) {
    const std::int32_t own = group[column];
    of_groups.startVec(own);
    rows.clear();
    for (; column < lower.cols() && group[column] == own; ++column)
      for (LongSparse::InnerIterator entry(lower, column); entry; ++entry)
        rows.push_back(group[entry.row()]);
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const std::int32_t row : rows)
      of_groups.insertBack(row, own) = 1;
  }
  of_groups.finalize();
  return of_groups;
}

/// Fill-reducing order of rows: nested dissection (METIS) of the groups, whose rows stay together.
std::vector<SuiteSparse_long> order(const LongSparse& lower, std::span<const std::int32_t> group,
                                    Common& common) {
  const LongSparse of_groups = graph(lower, group);
  cholmod_sparse view = seen(of_groups, CHOLMOD_PATTERN);
  std::vector<SuiteSparse_long> groups(view.nrow), first(groups.size() + 1, 0), rows;
  cholmod_l_metis(&view, nullptr, 0, 1, groups.data(), common.get());
  common.check();
  for (const std::int32_t of : group)
    ++first[static_cast<std::size_t>(of) + 1];
  for (std::size_t i = 1; i < first.size(); ++i)
    first[i] += first[i - 1];
  rows.reserve(group.size());
  for (const SuiteSparse_long next : groups)
    for (SuiteSparse_long row = first[next]; row < first[static_cast<std::size_t>(next) + 1]; ++row)
      rows.push_back(row);
  return rows;
}

class SupernodalFactor : public SparseCholesky {
public:
  SupernodalFactor(const Sparse& lower, std::span<const std::int32_t> group, bool blas_is_serial);
  ~SupernodalFactor() override { cholmod_l_free_factor(&factor_, common_.get()); }
  SupernodalFactor(const SupernodalFactor&) = delete;
  SupernodalFactor& operator=(const SupernodalFactor&) = delete;

  const char* name() const override { return "CHOLMOD supernodal"; }
  double factor(const Sparse& lower) override;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const override;

private:
  /// A block of columns of the factor, and the rows of their non-zeros: first their own.
  struct Supernode {
    Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> numbers;
    std::span<const SuiteSparse_long> rows;
  };
  std::optional<OneThread> limit_threads() const {
    return blas_is_serial_ ? std::optional<OneThread>(std::in_place) : std::nullopt;
  }
  Supernode supernode(std::size_t number) const;
  void solve_lower(Eigen::MatrixXd& values) const;

  bool blas_is_serial_;
  mutable Common common_;
  cholmod_factor* factor_ = nullptr;
  std::vector<std::size_t> supernode_of_; ///< by column
};

SupernodalFactor::SupernodalFactor(const Sparse& lower, std::span<const std::int32_t> group,
                                   bool blas_is_serial)
    : blas_is_serial_(blas_is_serial) {
  const auto limit = limit_threads();
  common_->print = 0;
  common_->error_handler = nullptr;
  common_->supernodal = CHOLMOD_SUPERNODAL;
  common_->quick_return_if_not_posdef = 1;
  common_->nmethods = 1;
  common_->method[0].ordering = CHOLMOD_GIVEN;
  common_->postorder = 1;
  const LongSparse matrix = lower;
  cholmod_sparse view = seen(matrix, CHOLMOD_PATTERN);
  std::vector<SuiteSparse_long> rows = order(matrix, group, common_);
  factor_ = cholmod_l_analyze_p(&view, rows.data(), nullptr, 0, common_.get());
  common_.check();
  n_numbers_ = static_cast<double>(factor_->xsize);
  n_operations_ = common_->fl;
  bytes_ = static_cast<std::int64_t>((factor_->xsize + factor_->ssize + factor_->maxcsize) * sizeof(double));
}

double SupernodalFactor::factor(const Sparse& lower) {
  const auto limit = limit_threads();
  const LongSparse matrix = lower;
  cholmod_sparse view = seen(matrix, CHOLMOD_REAL);
  cholmod_l_factorize(&view, factor_, common_.get());
  if (common_->status == CHOLMOD_NOT_POSDEF)
    return 0;
  common_.check();
  supernode_of_.clear();
  for (std::size_t number = 0; number < factor_->nsuper; ++number)
    supernode_of_.insert(supernode_of_.end(), static_cast<std::size_t>(supernode(number).numbers.cols()),
                         number);
  return cholmod_l_rcond(factor_, common_.get());
}

SupernodalFactor::Supernode SupernodalFactor::supernode(std::size_t number) const {
  const auto* const super = static_cast<const SuiteSparse_long*>(factor_->super);
  const auto* const rows = static_cast<const SuiteSparse_long*>(factor_->pi);
  const Eigen::Index n_rows = rows[number + 1] - rows[number];
  return {
      {static_cast<const double*>(factor_->x) + static_cast<const SuiteSparse_long*>(factor_->px)[number],
       n_rows, super[number + 1] - super[number], Eigen::OuterStride<>(n_rows)},
      {static_cast<const SuiteSparse_long*>(factor_->s) + rows[number], static_cast<std::size_t>(n_rows)}};
}

/// values = inverse(L) values. Visits only the columns of L that are ancestors of a non-zero row in the
/// elimination tree: for forces on few nodes a tenth of the factor.
/// Source  Gilbert and Peierls 1988 (SIAM J. Sci. Stat. Comput. 9); for a Cholesky factor the reach is
///         the path to the root
void SupernodalFactor::solve_lower(Eigen::MatrixXd& values) const {
  std::vector<char> is_reached(factor_->nsuper, 0);
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    if (!values.row(row).isZero(0))
      is_reached[supernode_of_[row]] = 1;
  Eigen::MatrixXd own, below;
  for (std::size_t number = 0; number < factor_->nsuper; ++number) {
    if (is_reached[number] == 0)
      continue;
    const Supernode one = supernode(number);
    const Eigen::Index n = one.numbers.cols(), n_below = one.numbers.rows() - n;
    own = values.middleRows(one.rows.front(), n);
    const auto triangle = one.numbers.topRows(n).triangularView<Eigen::Lower>();
    if (own.cols() == 1) // Eigen would pack the factor for one column as for many
      triangle.solveInPlace(own.col(0));
    else
      triangle.solveInPlace(own);
    values.middleRows(one.rows.front(), n) = own;
    if (n_below == 0)
      continue;
    below.noalias() = one.numbers.bottomRows(n_below) * own;
    const std::span<const SuiteSparse_long> rows = one.rows.subspan(n);
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      for (Eigen::Index i = 0; i < n_below; ++i)
        values(rows[i], column) -= below(i, column);
    is_reached[supernode_of_[rows.front()]] = 1;
  }
}

Eigen::MatrixXd SupernodalFactor::solve(const Eigen::MatrixXd& right) const {
  const auto limit = limit_threads();
  const Eigen::Map<const Eigen::VectorX<SuiteSparse_long>> order(
      static_cast<const SuiteSparse_long*>(factor_->Perm), right.rows());
  Eigen::MatrixXd values = right(order, Eigen::all);
  solve_lower(values);
  cholmod_dense view{};
  view.nrow = view.d = static_cast<std::size_t>(values.rows());
  view.ncol = static_cast<std::size_t>(values.cols());
  view.nzmax = view.nrow * view.ncol;
  view.x = values.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* found = cholmod_l_solve(CHOLMOD_Lt, factor_, &view, common_.get());
  common_.check();
  Eigen::MatrixXd answer(values.rows(), values.cols());
  answer(order, Eigen::all) =
      Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(found->x), values.rows(), values.cols());
  cholmod_l_free_dense(&found, common_.get());
  return answer;
}

constexpr SupernodalCholesky made = [](const Sparse& lower, std::span<const std::int32_t> group,
                                       bool blas_is_serial) -> std::unique_ptr<SparseCholesky> {
  return std::make_unique<SupernodalFactor>(lower, group, blas_is_serial);
};

} // namespace

} // namespace maille

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* /*host*/) {
  return layout == maille::cholmod_layout ? &maille::made : nullptr;
}
