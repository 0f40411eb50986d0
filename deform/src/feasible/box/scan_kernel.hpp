#pragma once
/// Inner loops of the closed form and of the separable scans, compiled for every vector instruction set.

#include "feasible/bounds/bound_source.hpp"
#include "lattice/field_memory.hpp"

#include <cstdint>

namespace maille::deform {

/// A node of given displacement, in the numbers of the field.
struct GridSeed {
  int x = 0, y = 0, z = 0;
  double value = 0;
};

/// One bound on a strip of the body, x_begin <= x < x_end: least = max over seeds of (p - d(., seed)) or
/// greatest = min over seeds of (p + d(seed, .)).
template<class T>
struct Bound {
  bool is_least = true;
  const GridSeed* seeds = nullptr; ///< by z, then y, then x
  int n_seeds = 0;
  double ahead[3] = {}, behind[3] = {}; ///< Slopes
  /// What a path adds along x, T(offset * slope), for the offsets -(nodes - 1) ... nodes - 1 of a row.
  const T* row = nullptr;
  T* slab = nullptr;        ///< workspace: one number for every node of a slab of the strip
  T* one_row = nullptr;     ///< workspace: as long as a row of the field
  double* sample = nullptr; ///< per query; sampling only
};

/// Both bounds, swept forward and backward through the slabs of a strip.
template<class T>
struct Sweep {
  Field<T> field; ///< clamped between the bounds, one after the other
  int nodes[3] = {};
  Bound<T> bounds[2];
  int n_bounds = 0;
  int x_begin = 0, x_end = 0; ///< multiples of nodes_per_block, but for the row's end
  std::int64_t slab_row = 0;  ///< distance of rows in Bound::slab
  double margin = 0;          ///< as in Cone
};

/// Clamps the strip; returns the nodes visited, those visited twice counting twice.
std::int64_t clamp_strip(const Sweep<float>& sweep);
std::int64_t clamp_strip(const Sweep<double>& sweep);

/// Nodes whose bounds are queried, by z, then y, then x.
struct Queries {
  const GridSeed* at = nullptr; ///< `value` is not used
  int n = 0;
};

/// Improves Bound::sample, the best known so far per query, by the single bound of `sweep`. The strip is the
/// whole width; the field is not touched.
void sample_bound(const Sweep<double>& sweep, const Queries& queries);

/// Seeds as one array per number, for brute force; each `n` rounded up to a multiple of nodes_per_block, with
/// seeds of no effect.
struct GridSeedArrays {
  const double* x = nullptr;
  const double* y = nullptr;
  const double* z = nullptr;
  const double* value = nullptr;
  int n = 0;
};

/// The same over all pairs of seeds and queries. @pre ahead <= behind for a least bound, >= for a greatest
/// one
void sample_by_pairs(const Bound<double>& bound, const GridSeedArrays& seeds, const Queries& queries);

/// Rows with more seeds than this are scanned; with fewer, each seed is laid out by itself.
inline constexpr int seeds_laid_out = 16;

/// Nodes of a row are processed in groups that start at multiples of this, for any vector length.
inline constexpr int nodes_per_block = 16;

/// One component of a drag by one handle: x = max(x, bound) if it raises, min(x, bound) else, with
/// bound(x, y, z) = T(value + y_part + z_part) + row[x].
template<class T>
struct Cone {
  Field<T> field;
  const T* row = nullptr; ///< what a path adds along x, per x; at least up to the field's row_stride
  double value = 0;       ///< of the handle, in the field's own numbers
  double margin = 0;      ///< a node further inside its bound than this has nothing to follow behind it
  double ahead[3] = {}, behind[3] = {}; ///< Slopes
  bool raises = true;
  bool stops = true; ///< false: visit every node of [begin, end)
  int handle[3] = {}, begin[3] = {}, end[3] = {};
};

/// Narrows [begin, end) to a box outside which nothing changes. @pre cone.stops
void enclose(Cone<float>& cone);
void enclose(Cone<double>& cone);

/// Applies the slabs [z_begin, z_end) of the cone's box; returns how many nodes it visited. Slabs are
/// independent of each other.
std::int64_t apply(const Cone<float>& cone, int z_begin, int z_end);
std::int64_t apply(const Cone<double>& cone, int z_begin, int z_end);

} // namespace maille::deform
