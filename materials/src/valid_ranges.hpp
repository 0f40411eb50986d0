#pragma once
/// What numbers of a material must keep to, and the words for it: of those that are read and those that a
/// program sets.

#include <limits>
#include <string_view>

namespace maille {

struct Range {
  double least;
  double most;
  std::string_view text;
};

inline constexpr double unbounded = std::numeric_limits<double>::infinity();
inline constexpr Range stretch_range{1, unbounded, "a ratio >= 1 (largest distance / rest)"};
inline constexpr Range compress_range{0, 1, "a ratio from 0 to 1 (smallest distance / rest)"};
inline constexpr Range shear_range{0, unbounded, "a ratio >= 0 (largest shear / rest)"};
inline constexpr std::string_view wanted_damage_stretch = "a ratio > 1, or three";

} // namespace maille
