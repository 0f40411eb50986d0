#include "maille/materials/material.hpp"

#include "maille/materials/toml_reader.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>

namespace maille {

namespace {

/// Mean of values with non-negative weights, clipped to their range: equal values stay equal to the last bit,
/// and valid limits stay valid.
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
        mean.add(squares(a, i) * squares(b, j), limits.shear[i][j]);
      }
    }
  }
  return mean.value();
}

using Three = std::array<double, 3>;

/// @param declared key of a material that declares the range
void check(double value, std::string_view declared, const std::string& key, std::vector<BrokenRule>& found) {
  if (const auto wanted = wanted_in_range("material", declared, value))
    found.push_back({key, *wanted, fmt::format("{}", value)});
}

void check(const Three& values, std::string_view declared, const std::string& key,
           std::vector<BrokenRule>& found) {
  for (const double value : values)
    check(value, declared, key, found);
}

void check_shear(const std::array<Three, 3>& shear, const std::string& key, std::vector<BrokenRule>& found) {
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      if (a != b) { // the diagonal is unused
        check(shear[a][b], "shear", fmt::format("{}[{}][{}]", key, a, b), found);
      }
    }
  }
}

std::string words(const Three& values) {
  return fmt::format("{}, {}, {}", values[0], values[1], values[2]);
}

/// Checks three values; one fault for all.
void check_all(const Three& values, std::string_view table, const std::string& key, std::string_view declared,
               std::vector<BrokenRule>& found) {
  for (const double value : values)
    if (const auto wanted = wanted_in_range(table, declared, value)) {
      found.push_back({key, *wanted, words(values)});
      return;
    }
}

void check_damage(const Damage& damage, std::vector<BrokenRule>& found) {
  check_all(damage.stretch, "damage", "damage.stretch", "stretch", found);
  if (damage.compress)
    check(*damage.compress, "compress", "damage.compress", found);
  if (damage.shear)
    check_shear(*damage.shear, "damage.shear", found);
}

} // namespace

NeighbourLimits turned(const NeighbourLimits& limits, const Eigen::Matrix3d& axes) {
  const Eigen::Matrix3d squares = axes.cwiseAbs2();
  NeighbourLimits result;
  for (int a = 0; a < 3; ++a) {
    WeightedMean stretch;
    WeightedMean compress;
    for (int i = 0; i < 3; ++i) {
      stretch.add(squares(a, i), limits.stretch[i]);
      compress.add(squares(a, i), limits.compress[i]);
    }
    result.stretch[a] = stretch.value();
    result.compress[a] = compress.value();
    for (int b = 0; b < 3; ++b) {
      if (a != b) {
        result.shear[a][b] = turned_shear(limits, squares, a, b);
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
  for (Eigen::Index a = 0; a < dimension; ++a)
    compliance.axial[a] = S(a, a);
  if (dimension == 2) {
    set_shear(0, 1, S(2, 2));
  } else if (dimension == 3) {
    set_shear(1, 2, S(3, 3));
    set_shear(0, 2, S(4, 4));
    set_shear(0, 1, S(5, 5));
  }
  return compliance;
}

NeighbourLimits limits_before_failure(const Damage& damage) {
  NeighbourLimits limits;
  limits.stretch = damage.stretch;
  for (std::size_t a = 0; a < 3; ++a) {
    const double across = std::min(damage.stretch[(a + 1) % 3], damage.stretch[(a + 2) % 3]);
    limits.compress[a] = damage.compress ? (*damage.compress)[a] : 1 / (across * across);
    for (std::size_t b = 0; b < 3; ++b) {
      const double most = std::min(damage.stretch[a], damage.stretch[b]);
      if (a != b)
        limits.shear[a][b] = damage.shear ? (*damage.shear)[a][b] : most - 1 / most;
    }
  }
  return limits;
}

std::vector<BrokenRule> broken_rules(const ElasticConstants& constants) {
  std::vector<BrokenRule> found;
  for (const std::string& inequality : violated_inequalities(constants)) {
    const std::string_view text = inequality;
    const std::size_t split = text.rfind("  (");
    const std::string_view numbers = text.substr(split + 3, text.size() - split - 4);
    const bool is_determinant = text.starts_with('1');
    found.push_back(
        {text.starts_with('E')   ? "E"
         : text.starts_with('G') ? "G"
                                 : "nu",
         std::string(text.substr(0, split)) +
             (is_determinant ? " (at 0 the stiffness is infinite: take slightly smaller Poisson ratios)"
                             : ""),
         fmt::format("{}, which is false", numbers)});
  }
  return found;
}

std::vector<BrokenRule> broken_rules(const NeighbourLimits& limits) {
  std::vector<BrokenRule> found;
  check(limits.stretch, "stretch", "stretch", found);
  check(limits.compress, "compress", "compress", found);
  check_shear(limits.shear, "shear", found);
  return found;
}

std::vector<BrokenRule> broken_rules(Law law) {
  std::vector<BrokenRule> found;
  for (const auto& [name, value] : parameters(law))
    if (const auto wanted = wanted_in_range("law", name, *value))
      found.push_back({std::string(name), *wanted, fmt::format("{}", *value)});
  const auto require = [&](bool is_met, const char* key, const char* rule, double value) {
    if (!is_met && found.empty())
      found.push_back({key, rule, fmt::format("{}", value)});
  };
  if (const auto* of = std::get_if<NeoHookean>(&law))
    require(of->lambda > -2 * of->mu / 3, "lambda", "lambda > -2/3 mu", of->lambda);
  if (const auto* of = std::get_if<Muscle>(&law))
    require(of->lam_max >= of->Lofl, "lam_max", "lam_max >= Lofl", of->lam_max);
  if (found.empty() && !violated_inequalities(rest_constants(law)).empty())
    for (const auto& [name, value] : parameters(law))
      if (name == "k" || name == "lambda")
        found.push_back({std::string(name),
                         fmt::format("{} from 1e-5 to 1e9 times the stiffness that the others give", name),
                         fmt::format("{:g}", *value)});
  return found;
}

bool is_isotropic(const Material& material) {
  return material.elasticity.is_isotropic() && (!material.law || is_isotropic(*material.law));
}

std::vector<BrokenRule> broken_rules(const Material& material) {
  std::vector<BrokenRule> found = broken_rules(material.elasticity);
  if (material.law)
    for (const BrokenRule& rule : broken_rules(*material.law))
      found.push_back({"law." + rule.key, rule.expected, rule.found});
  if (material.limits)
    std::ranges::move(broken_rules(*material.limits), std::back_inserter(found));
  check(material.density, "density", "density", found);
  check_all(material.relaxed_weights, "material", "relaxed_weights", "relaxed_weights", found);
  if (material.damage)
    check_damage(*material.damage, found);
  return found;
}

} // namespace maille
