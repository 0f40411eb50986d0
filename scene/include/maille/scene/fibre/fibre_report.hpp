#pragma once
/// Where a body's fibres come from, and what had to be done to them.

#include <cstdint>
#include <string>

namespace maille {

/// Counts are of cells of matter as read, pieces that are left out later included; all zero but for tensor
/// images.
struct FibreReport {
  std::string
      source; ///< bipennate, curve, tensor_image, array; empty: one direction, or one a part of a muscle
  std::int64_t cells = 0;           ///< with a direction of their own to begin with, or given one
  std::int64_t no_tensor = 0;       ///< zero, or not a number
  std::int64_t not_positive = 0;    ///< a diffusion that is not positive along every axis: noise
  std::int64_t isotropic = 0;       ///< no direction stands out
  std::int64_t from_neighbours = 0; ///< cells without a direction that took the mean of those around them
  std::int64_t from_label = 0;      ///< that took the mean of their label: no neighbour could say
  std::int64_t from_body = 0;       ///< that took the mean of all labels: nothing in their own could say
  double smoothing_radius = 0;      ///< [m]; 0: not smoothed
  double smoothing_turn = 0;        ///< mean angle by which smoothing turned directions [rad]

  std::int64_t without_direction() const { return no_tensor + not_positive + isotropic; }
};

/// In a line: `from a tensor image: 6417 cells, 12 without a direction (...)`; empty where the source is.
std::string in_words(const FibreReport& report);

} // namespace maille
