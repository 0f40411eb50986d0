#pragma once
/// CG around deal.II's geometric multigrid, for boxes of one matter.

#include "discretization/body.hpp"
#include "solvers/linear_solvers.hpp"

namespace maille::fem_ref {

/// V-cycles of deal.II's Multigrid in float32 inside its CG in float64: smoothing by Chebyshev polynomials
/// (one before, one after), transfer by MGTransferMatrixFree, a sparse Cholesky factor at the bottom.
/// Operators of the levels come from the element's matrix (CellOperator), or, for comparison, are assembled
/// matrices of float32 (LevelMatrix).
///
/// A coarse node is fixed where a fixed fine node hangs on it, so that what coarse levels bring never moves a
/// fixed node.
/// @pre why_no_hierarchy(scene) is empty, dim >= 2
template<int dim>
Preparation prepare_multigrid(const Scene& scene, const Body<dim>& body,
                              const std::vector<bool>& is_prescribed, const Options& options, Watch& watch);

} // namespace maille::fem_ref
