/// Indices of samples that were laid out for them: whole grids, and pairs of points.

#include "study/sensitivity/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <random>
#include <stdexcept>

namespace maille::studies {

namespace {

/// Mean square of the means over everything but one axis, about `mean`.
/// @param is_but_one  means over that axis alone instead
double variance_of_means(const std::vector<int>& counts, std::size_t axis, const std::vector<double>& values,
                         double mean, bool is_but_one) {
  std::size_t stride = 1;
  for (std::size_t i = axis + 1; i < counts.size(); ++i)
    stride *= static_cast<std::size_t>(counts[i]);
  const auto n = static_cast<std::size_t>(counts[axis]);
  std::vector<double> sums(is_but_one ? values.size() / n : n);
  for (std::size_t i = 0; i < values.size(); ++i)
    sums[is_but_one ? i / (stride * n) * stride + i % stride : i / stride % n] += values[i] - mean;
  const double shared = static_cast<double>(values.size()) / static_cast<double>(sums.size());
  double squares = 0;
  for (const double sum : sums)
    squares += std::pow(sum / shared, 2);
  return squares / static_cast<double>(sums.size());
}

/// Values of A, B and every AB of one block.
struct Block {
  double a = 0, b = 0;
  std::vector<double> mixed;
};

/// First-order indices, then total ones. @param drawn  places of blocks, some of them several times
std::vector<double> indices_of(const std::vector<Block>& blocks, const std::vector<std::size_t>& drawn) {
  const std::size_t d = blocks.front().mixed.size();
  const auto n = static_cast<double>(drawn.size());
  double mean = 0, variance = 0;
  for (const std::size_t i : drawn)
    mean += (blocks[i].a + blocks[i].b) / (2 * n);
  for (const std::size_t i : drawn)
    variance += (std::pow(blocks[i].a - mean, 2) + std::pow(blocks[i].b - mean, 2)) / (2 * n);
  std::vector<double> indices(2 * d);
  if (!(variance > 0))
    return indices;
  for (const std::size_t i : drawn)
    for (std::size_t axis = 0; axis < d; ++axis) {
      const double change = blocks[i].mixed[axis] - blocks[i].a;
      indices[axis] += (blocks[i].b - mean) * change / (n * variance);
      indices[d + axis] += change * change / (2 * n * variance);
    }
  return indices;
}

} // namespace

Sensitivity sobol_by_grid(const std::vector<int>& counts, const std::vector<std::optional<double>>& values) {
  Sensitivity result = blank_sensitivity(counts.size(), values);
  result.estimator = "variances of the grid, values equally likely";
  if (result.undetermined.empty() && result.n_left_out > 0)
    result.undetermined =
        fmt::format("{} of {} values of the grid are missing", result.n_left_out, values.size());
  if (!result.undetermined.empty())
    return result;
  std::vector<double> all;
  for (const std::optional<double>& value : values)
    all.push_back(*value);
  const double variance = std::pow(result.deviation, 2);
  std::vector<double> indices;
  for (std::size_t axis = 0; axis < counts.size(); ++axis)
    indices.push_back(variance_of_means(counts, axis, all, result.mean, false) / variance);
  for (std::size_t axis = 0; axis < counts.size(); ++axis)
    indices.push_back(std::max(0.0, 1 - variance_of_means(counts, axis, all, result.mean, true) / variance));
  set_indices(result, indices, {});
  return result;
}

Sensitivity sobol_by_pairs(int n_parameters, const std::vector<std::optional<double>>& values) {
  const auto d = static_cast<std::size_t>(n_parameters);
  if (values.size() % (d + 2) != 0)
    throw std::invalid_argument(
        fmt::format("sobol_by_pairs: {} values are no blocks of {}", values.size(), d + 2));
  std::vector<Block> blocks;
  std::vector<std::optional<double>> used;
  for (std::size_t first = 0; first < values.size(); first += d + 2) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
    const bool is_whole =
        std::all_of(begin, begin + n_parameters + 2,
                    [](const std::optional<double>& value) { return value && std::isfinite(*value); });
    for (std::size_t i = 0; i < d + 2; ++i)
      used.push_back(is_whole ? values[first + i] : std::nullopt);
    if (!is_whole)
      continue;
    Block& block = blocks.emplace_back();
    block.a = **begin;
    block.b = **(begin + 1);
    for (std::size_t i = 0; i < d; ++i)
      block.mixed.push_back(*values[first + 2 + i]);
  }
  Sensitivity result = blank_sensitivity(d, used);
  result.estimator = fmt::format("{} pairs of points", blocks.size());
  constexpr std::size_t n_least = 10;
  if (result.undetermined.empty() && blocks.size() < n_least)
    result.undetermined =
        fmt::format("{} whole blocks of samples, at least {} are needed", blocks.size(), n_least);
  if (!result.undetermined.empty())
    return result;
  std::vector<std::size_t> drawn(blocks.size());
  std::iota(drawn.begin(), drawn.end(), std::size_t{0});
  const std::vector<double> indices = indices_of(blocks, drawn);
  constexpr int n_bootstraps = 1000;
  std::vector<std::vector<double>> bootstraps;
  std::mt19937_64 lot(1); // by hand: library distributions differ from one another
  for (int i = 0; i < n_bootstraps; ++i) {
    for (std::size_t& place : drawn)
      place = lot() % blocks.size();
    bootstraps.push_back(indices_of(blocks, drawn));
  }
  set_indices(result, indices, bootstraps);
  return result;
}

} // namespace maille::studies
