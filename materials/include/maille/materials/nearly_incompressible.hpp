#pragma once
/// Poisson ratios of tissue, which changes its shape long before its volume.

#include <array>

namespace maille {

/// Poisson ratios nu12, nu13, nu23 at which pressure changes a material of these moduli in size and not in
/// shape, with that bulk modulus K: every row of the compliance's 3 x 3 block has the sum 1 / (3 K).
/// Isotropic: 1/2 - E / (6 K). Transversely isotropic: nu_fibre = 1/2 - E_fibre / (6 K), nu_cross = 1 -
/// E_cross (nu_fibre / E_fibre + 1 / (3 K)). Not every K gives a valid material: see violated_inequalities.
/// @param youngs_modulus E_1, E_2, E_3 [Pa], > 0; @param bulk_modulus [Pa], > 0
std::array<double, 3> poisson_ratios_at(const std::array<double, 3>& youngs_modulus, double bulk_modulus);

} // namespace maille
