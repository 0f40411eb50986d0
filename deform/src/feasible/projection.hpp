#pragma once
/// One side of a projection onto the feasible set, by scans.

#include "lattice/field_memory.hpp"

namespace maille::deform {

/// One side of a projection: the least feasible field above the given one, or the greatest below it.
struct Closure {
  Field<double> field;
  int nodes[3] = {};
  bool is_least_above = true;
  double ahead[3] = {}, behind[3] = {}; ///< Slopes of Side::least where it is least above, else of greatest
};

/// Scans one slab along x and y, forward and backward. Slabs are independent of each other.
void close_slab(const Closure& closure, int z);

/// Scans the rows y of all slabs along z, forward and backward. Rows are independent of each other.
void close_along_z(const Closure& closure, int y);

/// The rows y of all slabs: below = mean of above and below. @return the largest difference of the two
double take_mean(const Field<double>& below, const Field<double>& above, const int* nodes, int y);

} // namespace maille::deform
