#pragma once
/// Exact propagation on any body: inhomogeneous, holed, from an image. Tiles of nodes, largest violation
/// first.

#include "maille/deform/plan.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace maille::deform {

/// A body and its state in tiles of 8 x 8 nodes by up to 8 layers, only those that hold matter.
///
/// Each displacement component is kept as 32-bit multiples of a quantum q, a power of two in metres, relative
/// to an offset: at most 2^-29 of the range of displacements that the scene asks for and of the slack across
/// the grid. Bounds are rounded outward: what is feasible in metres is so in quanta. Updates are exact: they
/// end, at one answer.
///
/// Error       no link is outside its limits by more than 3 q (< 0.1 ulp, in float32, of the range asked
///             for), and every node is within (k + 2) q of the exact answer, k the links of the path that
///             decides it
/// Cost        1 to 6 visits a tile that changes, no other is touched. Setup O(nodes); links once per tile
/// Memory      4 bytes a node and component, 27 more in visited tiles at the surface or where limits differ
/// Repeatable  same bits for any order of seeds, number of threads and vector instructions
/// Source      docs/theory.md, Theorems 1, 4, 5 and section 6
/// Checked by  tests/deform/feasible/wavefront_test.cpp and its neighbours
class TiledBody {
public:
  /// The body at rest. @param limits of `scene`; both must outlive the body
  TiledBody(const Scene& scene, const LinkLimits& limits);
  TiledBody(TiledBody&&) noexcept;
  TiledBody& operator=(TiledBody&&) noexcept;
  ~TiledBody();

  // The state.
  /// Displacement 0 everywhere.
  void rest();
  /// Takes the feasible state nearest to `state` in the largest difference: `state` itself, rounded down,
  /// where that is feasible, else the mean of the least feasible state above it and the greatest below
  /// (Theorem 5).
  /// @return the largest change beyond the rounding [m]: 0 for a feasible state
  double set_state(const Displacement& state);
  /// Writes all nodes of the body; what was prescribed in the last move() is written at its exact value.
  void copy_to(Displacement& state) const;
  /// Displacement of one grid point, in whole quanta also where prescribed; 0 outside the body [m].
  double displacement(int component, std::int64_t node) const;

  // Changes.
  /// x = max(x, p - d(i, seed)) for all seeds, in place. @pre the state is feasible: it is after any call
  /// here
  void raise(int component, std::span<const PathEnd> seeds);
  /// x = min(x, p + d(seed, i)) for all seeds, in place.
  void lower(int component, std::span<const PathEnd> seeds);
  /// One step of a drag: the least change that brings the prescribed nodes to their values, each component
  /// for itself. What the limits do not permit is cut back first, as clip() does it, but in quanta: requests
  /// beyond the limits by less than (k + 2) q, k the links between, count as met.
  /// @param requested finite values on nodes of the body, each (component, node) once
  /// @param threads   1 or more; one a component is used at most
  /// @return          the values clipped, in the order of `requested`
  std::vector<Prescribed> move(std::span<const Prescribed> requested, int threads = 1);
  /// As move(), with the clipped values written over the requested ones. Allocates only what is needed for
  /// the first time: links of tiles that no move has visited, longer lists, a field for clipping, threads.
  void move_in_place(std::span<Prescribed> values, int threads = 1);

  // What it takes.
  /// The unit in which a component is counted [m].
  double quantum(int component) const;
  /// Tiles of the body, and visits of tiles since construction.
  std::int64_t n_tiles() const;
  std::int64_t n_visits() const;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace maille::deform
