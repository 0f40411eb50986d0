#pragma once
/// Numbers that elastic methods, worlds and probes share: what counts as rounding, as touching and as
/// standing still, how far anything moves between two looks, and when an iteration gives up.
///
/// Each small number has one task, and they are far apart, at least a hundredfold:
///
///     float64 epsilon  2e-16   one operation
///     rounding         1e-12   thousands of operations: sums, products and factorisations
///     tolerance        1e-9    what solves and bisections reach, and the gap before a face of a cell
///     negligible       1e-6    what a user cannot see; surfaces in contact keep 100 times as much
///
/// So nothing that rounds looks like a gap, and no gap looks like a motion. A larger `tolerance` lets an
/// object stop visibly early; a smaller one lets rounding put it into the next cell. The order is asserted
/// below; solid_worlds_test.cpp and random_worlds_test.cpp fail where rounding leads matter into matter.
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

/// Largest motion between two looks at what touches [cells]: of a hand, of a fold on its way to itself, of a
/// turn that is cut into pieces, and of a skin until its neighbours are searched again. Longer ones jump over
/// thin matter, which the tests of self-contact, of threads and of touches notice; shorter ones cost time.
inline constexpr double step_over_cell = 0.25;

/// Cells of a body that are within this many steps through faces are near one another, and do not touch. With
/// fewer, a bent body touches itself at a corner; with more, thin folds pass through one another.
inline constexpr int near_steps = 2;

/// An iteration that converges, or that ends because its states are finite, gives up after this many turns.
/// Those that were seen take 100 at most: on edges, where contacts alternate.
inline constexpr int iteration_cap = 200;

} // namespace maille::deform
