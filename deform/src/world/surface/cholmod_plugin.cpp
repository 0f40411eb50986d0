#include "lattice/sort_uniquely.hpp"
#include "world/surface/supernodal_factor.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cstddef>
#include <dlfcn.h>
#include <new>
#include <vector>

namespace maille::deform {

namespace {

/// CHOLMOD's workspace and settings.
class Common {
public:
  Common() { cholmod_start(&common_); }
  ~Common() { cholmod_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* operator->() { return &common_; }
  cholmod_common* get() { return &common_; }
  /// @throws std::bad_alloc where the last call found no memory
  void check() const {
    if (common_.status == CHOLMOD_OUT_OF_MEMORY)
      throw std::bad_alloc();
  }

private:
  cholmod_common common_{};
};

/// Bits of OpenBLAS depend on its threads, whose number is the machine's: while this lives it has one.
/// Nothing where the BLAS is another.
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

/// The lower triangle of `matrix`, seen by CHOLMOD.
cholmod_sparse seen(const Eigen::SparseMatrix<double>& matrix, int xtype) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(matrix.rows());
  view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
  view.p = const_cast<int*>(matrix.outerIndexPtr()); // it is only read
  view.i = const_cast<int*>(matrix.innerIndexPtr());
  view.x = xtype == CHOLMOD_PATTERN ? nullptr : const_cast<double*>(matrix.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = xtype;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

/// Graph of the groups: edges join groups with common entries.
Eigen::SparseMatrix<double> graph(const Eigen::SparseMatrix<double>& lower,
                                  std::span<const std::int32_t> group) {
  const Eigen::Index n = group.empty() ? 0 : group.back() + 1;
  Eigen::SparseMatrix<double> of_groups(n, n);
  std::vector<std::int32_t> rows;
  for (Eigen::Index column = 0; column < lower.cols();) {
    const std::int32_t own = group[static_cast<std::size_t>(column)];
    of_groups.startVec(own);
    rows.clear();
    for (; column < lower.cols() && group[static_cast<std::size_t>(column)] == own; ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(lower, column); entry; ++entry)
        rows.push_back(group[static_cast<std::size_t>(entry.row())]);
    sort_uniquely(rows);
    for (const std::int32_t row : rows)
      of_groups.insertBack(row, own) = 1;
  }
  of_groups.finalize();
  return of_groups;
}

/// Rows in an order of little fill: nested dissection (METIS) of the groups, whose rows stay together.
std::vector<int> order(const Eigen::SparseMatrix<double>& lower, std::span<const std::int32_t> group,
                       Common& common) {
  const Eigen::SparseMatrix<double> of_groups = graph(lower, group);
  cholmod_sparse view = seen(of_groups, CHOLMOD_PATTERN);
  std::vector<int> groups(static_cast<std::size_t>(of_groups.rows()));
  cholmod_metis(&view, nullptr, 0, 1, groups.data(), common.get());
  common.check();
  std::vector<int> first(groups.size() + 1, 0), rows;
  for (const std::int32_t of : group)
    ++first[static_cast<std::size_t>(of) + 1];
  for (std::size_t i = 1; i < first.size(); ++i)
    first[i] += first[i - 1];
  rows.reserve(group.size());
  for (const int next : groups)
    for (int row = first[static_cast<std::size_t>(next)]; row < first[static_cast<std::size_t>(next) + 1];
         ++row)
      rows.push_back(row);
  return rows;
}

class CholmodFactor : public SupernodalFactor {
public:
  CholmodFactor() = default;
  ~CholmodFactor() override { cholmod_free_factor(&factor_, common_.get()); }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  bool make(const Eigen::SparseMatrix<double>& lower, std::span<const std::int32_t> group, double most);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& forces) const override;

private:
  /// A block of columns of the factor, with the rows in which they have numbers: first their own.
  struct Supernode {
    Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> numbers;
    std::span<const int> rows;
  };
  Supernode supernode(int number) const;
  void solve_lower(Eigen::MatrixXd& values) const;

  mutable Common common_;
  cholmod_factor* factor_ = nullptr;
  std::vector<int> supernode_of_; ///< by column
};

bool CholmodFactor::make(const Eigen::SparseMatrix<double>& lower, std::span<const std::int32_t> group,
                         double most) {
  const OneThread alone;
  common_->print = 0;
  common_->supernodal = CHOLMOD_SUPERNODAL;
  common_->nmethods = 1;
  common_->method[0].ordering = CHOLMOD_GIVEN;
  common_->postorder = 1;
  cholmod_sparse view = seen(lower, CHOLMOD_REAL);
  std::vector<int> rows = order(lower, group, common_);
  factor_ = cholmod_analyze_p(&view, rows.data(), nullptr, 0, common_.get());
  common_.check();
  if (factor_ == nullptr || static_cast<double>(factor_->xsize) > most)
    return false;
  cholmod_factorize(&view, factor_, common_.get());
  common_.check();
  if (common_->status != CHOLMOD_OK)
    return false;
  for (int number = 0; number < static_cast<int>(factor_->nsuper); ++number)
    supernode_of_.insert(supernode_of_.end(), static_cast<std::size_t>(supernode(number).numbers.cols()),
                         number);
  return true;
}

CholmodFactor::Supernode CholmodFactor::supernode(int number) const {
  const auto* const super = static_cast<const int*>(factor_->super);
  const auto* const rows = static_cast<const int*>(factor_->pi);
  const Eigen::Index n_rows = rows[number + 1] - rows[number];
  return {{static_cast<const double*>(factor_->x) + static_cast<const int*>(factor_->px)[number], n_rows,
           super[number + 1] - super[number], Eigen::OuterStride<>(n_rows)},
          {static_cast<const int*>(factor_->s) + rows[number], static_cast<std::size_t>(n_rows)}};
}

/// values = inverse(L) values, of the columns of L alone that are above one with a force in the tree of
/// elimination: of forces on few nodes a tenth of the factor.
/// Source  Gilbert and Peierls 1988 (SIAM J. Sci. Stat. Comput. 9); of a Cholesky factor what is reached is
///         the way to the root
void CholmodFactor::solve_lower(Eigen::MatrixXd& values) const {
  std::vector<char> is_reached(factor_->nsuper, 0);
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    if (!values.row(row).isZero(0))
      is_reached[static_cast<std::size_t>(supernode_of_[static_cast<std::size_t>(row)])] = 1;
  Eigen::MatrixXd own, below;
  for (int number = 0; number < static_cast<int>(factor_->nsuper); ++number) {
    if (is_reached[static_cast<std::size_t>(number)] == 0)
      continue;
    const Supernode one = supernode(number);
    const Eigen::Index n = one.numbers.cols(), n_below = one.numbers.rows() - n;
    own = values.middleRows(one.rows.front(), n);
    one.numbers.topRows(n).triangularView<Eigen::Lower>().solveInPlace(own);
    values.middleRows(one.rows.front(), n) = own;
    if (n_below == 0)
      continue;
    below.noalias() = one.numbers.bottomRows(n_below) * own;
    const std::span<const int> rows = one.rows.subspan(static_cast<std::size_t>(n));
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      for (Eigen::Index i = 0; i < n_below; ++i)
        values(rows[static_cast<std::size_t>(i)], column) -= below(i, column);
    is_reached[static_cast<std::size_t>(supernode_of_[static_cast<std::size_t>(rows.front())])] = 1;
  }
}

Eigen::MatrixXd CholmodFactor::solve(const Eigen::MatrixXd& forces) const {
  const OneThread alone;
  const Eigen::Map<const Eigen::VectorXi> order(static_cast<const int*>(factor_->Perm), forces.rows());
  Eigen::MatrixXd values = forces(order, Eigen::all);
  solve_lower(values);
  cholmod_dense right{};
  right.nrow = right.d = static_cast<std::size_t>(values.rows());
  right.ncol = static_cast<std::size_t>(values.cols());
  right.nzmax = right.nrow * right.ncol;
  right.x = values.data();
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* found = cholmod_solve(CHOLMOD_Lt, factor_, &right, common_.get());
  common_.check();
  Eigen::MatrixXd answer(values.rows(), values.cols());
  answer(order, Eigen::all) =
      Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(found->x), values.rows(), values.cols());
  cholmod_free_dense(&found, common_.get());
  return answer;
}

std::unique_ptr<SupernodalFactor> factor(const Eigen::SparseMatrix<double>& lower,
                                         std::span<const std::int32_t> group, double most) {
  auto made = std::make_unique<CholmodFactor>();
  if (!made->make(lower, group, most))
    return nullptr;
  return made;
}

constexpr CholmodFunctions functions{.factor = factor};

} // namespace

} // namespace maille::deform

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* /*host*/) {
  return layout == maille::deform::cholmod_layout ? &maille::deform::functions : nullptr;
}
