#include "maille/plugins/sparse_cholesky.hpp"

#include <Eigen/SparseCholesky>

#include <stdexcept>

namespace maille {
namespace {

class SimplicialFactor : public SparseCholesky, private Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> {
public:
  explicit SimplicialFactor(const Eigen::SparseMatrix<double>& lower) {
    analyzePattern(lower);
    for (const int below : m_nonZerosPerCol) { // the diagonal
      n_numbers_ += 1.0 + below;
      n_operations_ += (1.0 + below) * (1.0 + below);
    }
    bytes_ = static_cast<std::int64_t>(n_numbers_ * (sizeof(double) + sizeof(int)));
  }
  const char* name() const override { return "Eigen simplicial"; }
  double factor(const Eigen::SparseMatrix<double>& lower) override {
    factorize(lower);
    if (info() != Eigen::Success)
      return 0;
    const Eigen::VectorXd pivots = m_matrix.diagonal();
    const double ratio = pivots.size() == 0 ? 1 : pivots.minCoeff() / pivots.maxCoeff();
    return ratio * ratio;
  }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const override { return SimplicialLLT::solve(right); }
};

} // namespace

std::unique_ptr<SparseCholesky> simplicial_cholesky(const Eigen::SparseMatrix<double>& lower) {
  return std::make_unique<SimplicialFactor>(lower);
}

std::unique_ptr<SparseCholesky> supernodal_cholesky(const Eigen::SparseMatrix<double>& lower,
                                                    std::span<const std::int32_t> group,
                                                    bool blas_is_serial) {
  static const auto* const made = static_cast<const SupernodalCholesky*>(
      open_plugin("maille-cholmod.so", "factors of large bodies (CHOLMOD)", cholmod_layout));
  return (*made)(lower, group, blas_is_serial);
}

std::unique_ptr<SparseCholesky> sparse_cholesky(const Eigen::SparseMatrix<double>& lower,
                                                std::span<const std::int32_t> group, bool blas_is_serial) {
  try {
    return supernodal_cholesky(lower, group, blas_is_serial);
  } catch (const std::runtime_error&) { // CHOLMOD is not installed
    return simplicial_cholesky(lower);
  }
}

} // namespace maille
