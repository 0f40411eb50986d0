#include "choose/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <tuple>

namespace maille::studies {

namespace {

/// raw times the median ratio, and times its quantiles.
Expected expected(double raw, std::span<const double> ratios, double level) {
  const double middle = ratios[(ratios.size() - 1) / 2];
  return {raw * middle, raw * lower_quantile(ratios, level), raw * upper_quantile(ratios, level)};
}

} // namespace

double upper_quantile(std::span<const double> sorted, double level) {
  // What rounding adds to (n + 1) level must not reach for the next value.
  const double rank = std::ceil(static_cast<double>(sorted.size() + 1) * level - 1e-9);
  const auto i = static_cast<std::size_t>(std::max(rank, 1.0));
  return i <= sorted.size() ? sorted[i - 1] : std::numeric_limits<double>::infinity();
}

double lower_quantile(std::span<const double> sorted, double level) {
  const double rank = std::ceil(static_cast<double>(sorted.size() + 1) * level - 1e-9);
  const auto i = static_cast<std::size_t>(std::max(rank, 1.0));
  return i <= sorted.size() ? sorted[sorted.size() - i] : 0;
}

std::size_t fewest_scenes(double level) {
  std::size_t n = 1;
  while (std::ceil(static_cast<double>(n + 1) * level - 1e-9) > static_cast<double>(n))
    ++n;
  return n;
}

Calibration::Calibration(std::span<const StoredRow> rows) {
  std::set<std::tuple<std::string, int, double, std::string, std::string>> seen;
  for (const StoredRow& row : rows) {
    if (!row.scene.empty() && !seen.emplace(row.way.method, row.way.halvings, row.way.tolerance.value_or(0),
                                            row.scene, fmt::format("{:.4g}", row.predicted_error))
                                   .second)
      continue;
    auto found = std::ranges::find(ratios_, row.way, &Ratios::way);
    if (found == ratios_.end())
      found = ratios_.insert(ratios_.end(), Ratios{row.way, {}, {}});
    found->error.push_back(row.error / row.predicted_error);
    found->seconds.push_back(row.seconds / row.predicted_seconds);
  }
  for (Ratios& ratios : ratios_) {
    std::ranges::sort(ratios.error);
    std::ranges::sort(ratios.seconds);
  }
}

std::vector<Way> Calibration::ways() const {
  std::vector<Way> ways;
  for (const Ratios& ratios : ratios_)
    ways.push_back(ratios.way);
  return ways;
}

bool Calibration::knows(const Way& way) const {
  return std::ranges::find(ratios_, way, &Ratios::way) != ratios_.end();
}

std::size_t Calibration::n_scenes() const {
  std::size_t most = 0;
  for (const Ratios& ratios : ratios_)
    most = std::max(most, ratios.error.size());
  return most;
}

const Calibration::Ratios& Calibration::of(const Way& way) const {
  const auto found = std::ranges::find(ratios_, way, &Ratios::way);
  if (found == ratios_.end())
    throw std::logic_error("no such way in the table: " + way.method);
  return *found;
}

Expected Calibration::error(const Way& way, double raw, double level) const {
  return expected(raw, of(way).error, level);
}

Expected Calibration::seconds(const Way& way, double raw, double level) const {
  return expected(raw, of(way).seconds, level);
}

} // namespace maille::studies
