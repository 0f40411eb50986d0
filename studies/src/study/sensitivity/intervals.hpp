#pragma once
/// What all estimators of sensitivity end with.

#include "study/sensitivity/sensitivity.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace maille::studies {

/// Counts, mean and deviation of the values; undetermined where they do not vary.
Sensitivity blank_sensitivity(std::size_t n_axes, const std::vector<std::optional<double>>& values);

/// The indices, and as intervals the middle 95 % of those of bootstraps, widened by what is unexplained.
/// @param indices  first-order ones of every parameter, then total ones @param bootstraps  the same, often
void set_indices(Sensitivity& sensitivity, const std::vector<double>& indices,
                 const std::vector<std::vector<double>>& bootstraps);

} // namespace maille::studies
