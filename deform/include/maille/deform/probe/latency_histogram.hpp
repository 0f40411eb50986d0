#pragma once
/// How long things took, counted without memory being asked for.

#include <array>
#include <cstdint>
#include <vector>

namespace maille::deform {

/// Durations from 0 to 18 minutes in bins a thirty-second of an octave wide: 3 % at most, and one nanosecond below 32.
class LatencyHistogram {
public:
  void add(std::int64_t nanoseconds);
  void add(const LatencyHistogram& other);

  std::int64_t n() const { return n_; }
  std::int64_t largest() const { return largest_; }                           ///< exactly [ns]
  double mean() const { return n_ > 0 ? sum_ / static_cast<double>(n_) : 0; } ///< [ns]
  /// The smallest duration that at least this share of all is not above, to the upper end of its bin [ns]; 0 of none.
  /// @param share 0 to 1
  std::int64_t quantile(double share) const;

  struct Bin {
    std::int64_t from, to; ///< [ns], `to` is in it
    std::int64_t count;
  };
  /// Those that are not empty, in order.
  std::vector<Bin> bins() const;

private:
  static constexpr int bits = 5, octaves = 36;
  static std::size_t bin_of(std::int64_t nanoseconds);
  static std::int64_t begin_of(std::size_t bin);

  std::array<std::int64_t, static_cast<std::size_t>(octaves) << bits> counts_{};
  std::int64_t n_ = 0, largest_ = 0;
  double sum_ = 0;
};

} // namespace maille::deform
