#pragma once
/// What the forces that a solution leaves at free nodes are measured by.

#include <algorithm>

namespace maille::fem_ref {

/// @param free  size of the forces at free nodes before they move
/// @param all   the same with those at nodes that are prescribed. Where holds carry all that pulls, what is left at free nodes is
///              rounding, and no measure
inline double residual_size(double free, double all) {
  constexpr double rounding =
      1e-9; // forces that are less than this part of all are what sums of larger ones leave
  return std::max(free, rounding * all);
}

} // namespace maille::fem_ref
