#include "study/sensitivity/intervals.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// @param share from 0 to 1
double percentile(std::vector<double> values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::ranges::nth_element(values, values.begin() + place);
  return values[place];
}

} // namespace

Sensitivity blank_sensitivity(std::size_t n_axes, const std::vector<std::optional<double>>& values) {
  Sensitivity result;
  result.first.resize(n_axes);
  result.total.resize(n_axes);
  double largest = 0;
  for (const std::optional<double>& value : values) {
    if (!value || !std::isfinite(*value)) {
      ++result.n_left_out;
      continue;
    }
    ++result.n_used;
    result.mean += (*value - result.mean) / result.n_used;
    largest = std::max(largest, std::abs(*value));
  }
  for (const std::optional<double>& value : values)
    if (value && std::isfinite(*value))
      result.deviation += std::pow(*value - result.mean, 2);
  result.deviation = std::sqrt(result.deviation / std::max(1, result.n_used));
  constexpr double rounding = 1e-12;
  if (result.n_used == 0)
    result.undetermined = "no sample has a value";
  else if (!(result.deviation > rounding * largest))
    result.undetermined = "the value is the same in all samples";
  return result;
}

void set_indices(Sensitivity& sensitivity, const std::vector<double>& indices,
                 const std::vector<std::vector<double>>& bootstraps) {
  const double unknown = sensitivity.unexplained;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::vector<double> spread{indices[i]};
    for (const std::vector<double>& of_one : bootstraps)
      spread.push_back(of_one[i]);
    const std::size_t n = sensitivity.first.size();
    SobolIndex& index = i < n ? sensitivity.first[i] : sensitivity.total[i - n];
    index.value = indices[i];
    const double low = std::min(indices[i], percentile(spread, 0.025)),
                 high = std::max(indices[i], percentile(spread, 0.975));
    index.low = unknown > 0 ? std::min(low, std::max(0.0, low - unknown)) : low;
    index.high = unknown > 0 ? std::max(high, std::min(1.0, high + unknown)) : high;
  }
}

} // namespace maille::studies
