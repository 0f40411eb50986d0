#pragma once
/// The innermost loops of the closed form, for every kind of vector that the machine may have.

#include "feasible/bounds/step_bounds.hpp"
#include "lattice/field_memory.hpp"

#include <cstdint>

namespace maille::deform {

/// Nodes of a row are dealt with in groups that begin at multiples of this, whatever the vectors' width.
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
