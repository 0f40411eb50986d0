#pragma once
/// Random constants and directions for property tests (a test prints its seed), and faults of a piece of TOML
/// as the lines that people see.

#include "maille/materials/elasticity.hpp"
#include "maille/materials/toml_reader.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <random>
#include <string>
#include <string_view>
#include <vector>

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
    while (!violated_inequalities(drawn).empty())
      drawn = constants();
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

/// The faults that `read(TableReader&)` finds in `text`, unknown keys among them, one message each.
template<typename Read>
std::vector<std::string> faults_of(std::string_view text, Read read, std::string_view declared = {}) {
  std::vector<std::string> messages;
  try {
    const toml::table document = parse_toml(text, "scene.toml");
    FaultList faults("scene.toml");
    TableReader table(document, "", faults, declared);
    read(table);
    table.finish();
    faults.throw_if_any();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      messages.push_back(to_string(fault));
  }
  return messages;
}

} // namespace maille::test
