#pragma once
/// What is wrong with a material that a program has put together. Readers use the same rules.

#include "maille/materials/material.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// A rule that a number breaks: which number, the rule, and what stands there instead.
struct BrokenRule {
  std::string key; ///< e.g. `E`, `stretch`, `damage.stretch`, `density`
  std::string expected, found;
};

inline constexpr std::string_view wanted_density = "a density > 0",
                                  wanted_relaxed_weights = "a factor > 0, or three";

/// Rules that are broken, of each number all; empty where everything is valid.
///
/// Constants must be finite and of positive strain energy (see violated_inequalities); keys E, nu, G. Limits
/// must be finite, with 0 <= compress <= 1 <= stretch and shear >= 0. A material must also have a finite
/// density > 0, finite weights > 0, and, if its damage is known, stretches > 1 at failure.
std::vector<BrokenRule> broken_rules(const ElasticConstants& constants);
std::vector<BrokenRule> broken_rules(const NeighbourLimits& limits);
std::vector<BrokenRule> broken_rules(const Material& material);

} // namespace maille
