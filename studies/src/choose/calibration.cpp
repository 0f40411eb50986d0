#include "maille/studies/choose.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

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

Calibration::Calibration(std::span<const StoredRow> rows) {
  for (const StoredRow& row : rows) {
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
