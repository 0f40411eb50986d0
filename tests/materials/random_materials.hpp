#pragma once
/// Random constants and directions for property tests; a test prints its seed.

#include "maille/materials/elasticity.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <random>

namespace maille::test {

class RandomMaterials {
public:
  explicit RandomMaterials(std::uint64_t seed) : engine_(seed) {}

  double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(engine_);
  }
  /// Moduli over two decades.
  double modulus() { return 1e3 * std::pow(10.0, between(0, 2)); }

  /// Constants of every kind, about half of them invalid.
  ElasticConstants constants() {
    return {{modulus(), modulus(), modulus()},
            between(-1, 1),
            between(-1, 1),
            between(-1, 1),
            modulus(),
            modulus(),
            modulus()};
  }
  ElasticConstants valid_constants() {
    ElasticConstants drawn = constants();
    while (!violated_inequalities(drawn).empty()) {
      drawn = constants();
    }
    return drawn;
  }
  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(engine_), normal(engine_), normal(engine_)).normalized();
  }
  Eigen::Matrix3d rotation() { return Eigen::AngleAxisd(between(0, 3.1), direction()).toRotationMatrix(); }

private:
  std::mt19937_64 engine_;
};

} // namespace maille::test
