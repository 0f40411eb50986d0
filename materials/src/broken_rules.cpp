#include "maille/materials/broken_rules.hpp"

#include "valid_ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

using Three = std::array<double, 3>;

void check(double value, const Range& range, const std::string& key, std::vector<BrokenRule>& found) {
  if (!(std::isfinite(value) && value >= range.least && value <= range.most)) {
    found.push_back({key, std::string(range.text), fmt::format("{}", value)});
  }
}

void check(const Three& values, const Range& range, const std::string& key, std::vector<BrokenRule>& found) {
  for (const double value : values) {
    check(value, range, key, found);
  }
}

void check_shear(const std::array<Three, 3>& shear, const std::string& key, std::vector<BrokenRule>& found) {
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      if (a != b) { // the diagonal is no shear
        check(shear[a][b], shear_range, fmt::format("{}[{}][{}]", key, a, b), found);
      }
    }
  }
}

bool all_above(double least, const Three& values) {
  return std::ranges::all_of(values, [&](double value) { return std::isfinite(value) && value > least; });
}

std::string words(const Three& values) {
  return fmt::format("{}, {}, {}", values[0], values[1], values[2]);
}

void check_damage(const Damage& damage, std::vector<BrokenRule>& found) {
  if (!all_above(1, damage.stretch)) {
    found.push_back({"damage.stretch", std::string(wanted_damage_stretch), words(damage.stretch)});
  }
  if (damage.compress) {
    check(*damage.compress, compress_range, "damage.compress", found);
  }
  if (damage.shear) {
    check_shear(*damage.shear, "damage.shear", found);
  }
}

} // namespace

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
  check(limits.stretch, stretch_range, "stretch", found);
  check(limits.compress, compress_range, "compress", found);
  check_shear(limits.shear, "shear", found);
  return found;
}

std::vector<BrokenRule> broken_rules(const Material& material) {
  std::vector<BrokenRule> found = broken_rules(material.elasticity);
  if (material.limits) {
    std::ranges::move(broken_rules(*material.limits), std::back_inserter(found));
  }
  if (!(std::isfinite(material.density) && material.density > 0)) {
    found.push_back({"density", std::string(wanted_density), fmt::format("{}", material.density)});
  }
  if (!all_above(0, material.relaxed_weights)) {
    found.push_back(
        {"relaxed_weights", std::string(wanted_relaxed_weights), words(material.relaxed_weights)});
  }
  if (material.damage) {
    check_damage(*material.damage, found);
  }
  return found;
}

} // namespace maille
