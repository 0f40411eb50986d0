#pragma once
/// Tolerances that elastic methods, worlds and probes share: rounding, contact, rest, largest motion between
/// checks, and caps of iterations.
///
/// Each small number has one task, and they are far apart, at least a hundredfold:
///
///     float64 epsilon  2e-16   one operation
///     rounding         1e-12   thousands of operations: sums, products and factorisations
///     tolerance        1e-9    what solves and bisections reach, and the gap before a face of a cell
///     negligible       1e-6    what a user cannot see; surfaces in contact keep 100 times as much
///
/// So rounding never looks like a gap, and a gap never looks like a motion. A larger `tolerance` lets an
/// object stop visibly early; with a smaller one rounding can put it into the next cell. The order is
/// asserted below; solid_worlds_test.cpp and random_worlds_test.cpp fail if rounding leads matter into
/// matter.
///
/// Lengths are in cells of the world: the least spacing, unless a comment says otherwise. Shares are of the
/// largest force, gap, speed or motion of the same kind.

#include <limits>

namespace maille::deform {

/// A smaller share of the largest value, and a shorter way [cells], is rounding.
inline constexpr double rounding = 1e-12;

/// Gap that objects and nodes keep from faces of cells [cells]. Also the relative accuracy of solves, the
/// relative difference of a scene's data that counts as none, and how far beside an edge or a face a point
/// may lie and be on it.
inline constexpr double tolerance = 1e-9;

/// A shorter motion [cells] counts as rest; a drive that misses a smaller share of its way counts as done.
inline constexpr double negligible = 1e-6;

// A factor of a hundred between any two, and a thousand operations between the first two.
static_assert(std::numeric_limits<double>::epsilon() < rounding / 1000 && rounding < tolerance / 100 &&
              tolerance < negligible / 100);

/// Largest motion between two contact checks [cells]: of a hand, of a fold towards its own body, of a piece
/// of a rotation, and of a skin between neighbour searches. Longer steps jump over thin matter, as the tests
/// of self-contact, threads and touches show; shorter ones cost time.
inline constexpr double step_over_cell = 0.25;

/// Cells of a body that are within this many steps through faces are near one another, and do not touch. With
/// fewer, a bent body touches itself at a corner; with more, thin folds pass through one another.
inline constexpr int near_steps = 2;

/// Cap of iterations that converge or end because their states are finite. Observed: at most 100, on edges
/// where contacts alternate.
inline constexpr int iteration_cap = 200;

} // namespace maille::deform
