#pragma once
/// The innermost loops over the limits of links, for every kind of vector that the machine may have.

namespace maille::deform {

/// The links from n nodes of a row to the next along an axis, `here` and `next` their displacements.
struct LinkRow {
  int n = 0;
  bool is_same = true; ///< one range for all
  const double *here = nullptr, *next = nullptr, *low = nullptr, *high = nullptr;
};

/// Whether a link is further outside its range than `tolerance`.
bool is_any_outside(const LinkRow& links, double tolerance);
/// The most by which a link is outside its range; 0 if none is.
double largest_excess(const LinkRow& links);

} // namespace maille::deform
