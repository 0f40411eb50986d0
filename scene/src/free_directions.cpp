#include "free_directions.hpp"

#include <Eigen/LU>
#include <vector>

namespace maille {

void release_free_directions(const Matrix6& C, const Vector6& active, int dimension, PlaneAssumption plane,
                             Vector6& strain) {
  std::vector<int> free;
  if (dimension == 1)
    free = {1, 2, 3, 4, 5};
  else if (dimension == 2 && plane == PlaneAssumption::stress)
    free = {2, 3, 4};
  if (free.empty())
    return;
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd block(n, n);
  Eigen::VectorXd load(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = free[static_cast<std::size_t>(i)];
    load(i) = -C.row(row).dot(strain) - active(row);
    for (Eigen::Index j = 0; j < n; ++j)
      block(i, j) = C(row, free[static_cast<std::size_t>(j)]);
  }
  const Eigen::VectorXd released = block.partialPivLu().solve(load);
  for (Eigen::Index i = 0; i < n; ++i)
    strain(free[static_cast<std::size_t>(i)]) += released(i);
}

} // namespace maille
