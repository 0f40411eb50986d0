#include "maille/materials/nearly_incompressible.hpp"

namespace maille {

std::array<double, 3> poisson_ratios_at(const std::array<double, 3>& youngs_modulus, double bulk_modulus) {
  const auto& E = youngs_modulus;
  // With s_ij = nu_ij / E_i: s_12 + s_13 = r_1, s_12 + s_23 = r_2, s_13 + s_23 = r_3.
  const double give = 1 / (3 * bulk_modulus);
  const double r1 = 1 / E[0] - give, r2 = 1 / E[1] - give, r3 = 1 / E[2] - give;
  return {E[0] * (r1 + r2 - r3) / 2, E[0] * (r1 + r3 - r2) / 2, E[1] * (r2 + r3 - r1) / 2};
}

} // namespace maille
