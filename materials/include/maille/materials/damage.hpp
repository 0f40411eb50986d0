#pragma once
/// How far a kind of matter was drawn out, squeezed and sheared when it failed, and the limits that keep it
/// from that.

#include "maille/materials/neighbour_limits.hpp"

#include <array>
#include <optional>
#include <string>

namespace maille {

/// Limits beyond are limits of torn matter.
struct Damage {
  std::array<double, 3> stretch{1, 1, 1}; ///< length / rest at failure along the material's axes, > 1
  /// Length / rest at failure, from 0 to 1; nothing where no source has it.
  std::optional<std::array<double, 3>> compress;
  /// Shear / rest at failure, [link axis][component]; nothing where no source has it.
  std::optional<std::array<std::array<double, 3>, 3>> shear;
  std::string of;        ///< what was pulled, and what failed; may be empty but in the library
  std::string source;    ///< as for LibraryEntry
  bool verified = false; ///< as for LibraryEntry
};

/// The limits at which matter begins to fail, along its own axes. What was measured is taken as it is. What
/// was not follows from the stretches, if no direction may be drawn out further than matter is known to bear:
///
///   shear between axes a and b:  lambda - 1 / lambda, which draws out some direction between them by lambda,
///   the smaller of the
///                                two stretches (simple shear by gamma has the principal stretch lambda,
///                                gamma = lambda - 1 / lambda)
///   compression along a:         1 / lambda^2, which draws out matter that keeps its volume by lambda
///   across, alike to all sides;
///                                lambda is the smallest stretch of the other two axes
///
/// Both are geometry, not data, and on the safe side only as far as matter does not fail otherwise.
/// Source  own derivation
NeighbourLimits limits_before_failure(const Damage& damage);

} // namespace maille
