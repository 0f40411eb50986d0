#pragma once
/// Random numbers and directions for tests, from one generator whose seed the test names.

#include <Eigen/Core>

#include <random>

namespace maille::test {

struct Dice {
  std::mt19937& random;
  /// From 0 to n - 1. @pre n > 0
  int below(int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); }
  /// From 0 to 1, 1 excluded, in steps of 2^-32.
  double uniform() { return static_cast<double>(random()) / 4294967296.0; }
  /// From low to high, with random digits throughout.
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  /// Unit vector, uniformly distributed.
  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  }
};

} // namespace maille::test
