#pragma once
/// The loops over links of the method of multipliers, for every kind of vector that the machine may have.

namespace maille::deform {

/// The links along one axis that start in one row. A link of weight 0 does not exist.
struct RowOfLinks {
  int n = 0;                     ///< links
  const float* weight = nullptr; ///< per link, times
  double factor = 1;             ///< this
  const double* low = nullptr;   ///< per link: its range
  const double* high = nullptr;
  float* v = nullptr; ///< per link: z + y, z within the range
};

/// Sums over links of weight times a square: of D u - z, of the change of z, of D u.
struct LinkResiduals {
  double primal = 0, dual = 0, norm = 0;
};

/// target += scale weight (z - y), per link.
void add_pulls(const RowOfLinks& row, double scale, double* target);
/// z and y of the next step, from the displacements at the near and the far end of each link.
void update_multipliers(const RowOfLinks& row, double over_relaxation, const double* near, const double* far,
                        LinkResiduals& residuals);
/// y divided by `factor`.
void scale_multipliers(const RowOfLinks& row, double factor);

} // namespace maille::deform
