#include "maille/materials/neighbour_limits.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cassert>
#include <limits>

namespace maille {
namespace {

/// Mean of values weighted by non-negative weights, kept within their range: equal values stay equal to the
/// last bit and a valid limit stays valid.
class WeightedMean {
public:
  void add(double weight, double value) {
    weights_ += weight;
    sum_ += weight * value;
    least_ = std::min(least_, value);
    most_ = std::max(most_, value);
  }
  double value() const { return std::clamp(sum_ / weights_, least_, most_); }

private:
  double weights_ = 0;
  double sum_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
};

double turned_shear(const NeighbourLimits& limits, const Eigen::Matrix3d& squares, int a, int b) {
  WeightedMean mean;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (i != j) {
        mean.add(squares(a, i) * squares(b, j),
                 limits.shear[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
      }
    }
  }
  return mean.value();
}

} // namespace

NeighbourLimits turned(const NeighbourLimits& limits, const Eigen::Matrix3d& axes) {
  const Eigen::Matrix3d squares = axes.cwiseAbs2();
  NeighbourLimits result;
  for (int a = 0; a < 3; ++a) {
    WeightedMean stretch;
    WeightedMean compress;
    for (int i = 0; i < 3; ++i) {
      stretch.add(squares(a, i), limits.stretch[static_cast<std::size_t>(i)]);
      compress.add(squares(a, i), limits.compress[static_cast<std::size_t>(i)]);
    }
    result.stretch[static_cast<std::size_t>(a)] = stretch.value();
    result.compress[static_cast<std::size_t>(a)] = compress.value();
    for (int b = 0; b < 3; ++b) {
      if (a != b) {
        result.shear[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] =
            turned_shear(limits, squares, a, b);
      }
    }
  }
  return result;
}

LinkCompliance link_compliance(const Eigen::MatrixXd& reduced_stiffness) {
  const Eigen::Index size = reduced_stiffness.rows();
  assert(size == reduced_stiffness.cols() && (size == 1 || size == 3 || size == 6));
  const Eigen::MatrixXd S = reduced_stiffness.llt().solve(Eigen::MatrixXd::Identity(size, size));
  LinkCompliance compliance;
  const auto set_shear = [&compliance](std::size_t a, std::size_t b, double value) {
    compliance.shear[a][b] = compliance.shear[b][a] = value;
  };
  const Eigen::Index dimension = size == 6 ? 3 : (size == 3 ? 2 : 1);
  for (Eigen::Index a = 0; a < dimension; ++a) {
    compliance.axial[static_cast<std::size_t>(a)] = S(a, a);
  }
  if (dimension == 2) {
    set_shear(0, 1, S(2, 2));
  } else if (dimension == 3) {
    set_shear(1, 2, S(3, 3));
    set_shear(0, 2, S(4, 4));
    set_shear(0, 1, S(5, 5));
  }
  return compliance;
}

} // namespace maille
