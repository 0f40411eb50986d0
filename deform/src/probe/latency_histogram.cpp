#include "maille/deform/probe/servo_loop.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace maille::deform {

std::size_t LatencyHistogram::bin_of(std::int64_t nanoseconds) {
  const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(nanoseconds, 0));
  const int octave = std::max(static_cast<int>(std::bit_width(value)) - bits - 1, 0);
  const std::size_t bin =
      (static_cast<std::size_t>(octave) << bits) + static_cast<std::size_t>(value >> octave);
  return std::min(bin, std::size_t{(static_cast<std::size_t>(octaves) << bits) - 1});
}

std::int64_t LatencyHistogram::begin_of(std::size_t bin) {
  const std::size_t lines = std::size_t{1} << bits;
  if (bin < 2 * lines)
    return static_cast<std::int64_t>(bin);
  const std::size_t octave = (bin >> bits) - 1;
  return static_cast<std::int64_t>((bin - (octave << bits)) << octave);
}

void LatencyHistogram::add(std::int64_t nanoseconds) {
  ++counts_[bin_of(nanoseconds)];
  ++n_;
  sum_ += static_cast<double>(std::max<std::int64_t>(nanoseconds, 0));
  largest_ = std::max(largest_, nanoseconds);
}

std::int64_t LatencyHistogram::quantile(double share) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(n_)));
  std::int64_t sum = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    sum += counts_[bin];
    if (sum >= wanted && sum > 0)
      return std::min(begin_of(bin + 1) - 1, largest_);
  }
  return 0;
}

std::vector<LatencyHistogram::Bin> LatencyHistogram::bins() const {
  std::vector<Bin> result;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin)
    if (counts_[bin] > 0)
      result.push_back({begin_of(bin), begin_of(bin + 1) - 1, counts_[bin]});
  return result;
}

} // namespace maille::deform
