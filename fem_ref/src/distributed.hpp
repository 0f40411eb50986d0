#pragma once
/// One scene by all ranks together: deal.II's distributed triangulation (p4est), Trilinos' matrices, CG with
/// AMG.

#include "maille/fem_ref/solve.hpp"

#include "process/watch.hpp"

namespace maille::fem_ref {

/// As Solver::solve, in two or three dimensions; every rank must call it with the same scene and gets the
/// whole answer, without recovered stress. Cells, unknowns and the matrix are spread over the ranks; the
/// scene, the coarse mesh that p4est starts from and the answer are whole on each. The mesh of a box starts
/// from its coarsest lattice, any other from all its cells.
Result solve_distributed(const Scene& scene, const Options& options, Watch& watch);

} // namespace maille::fem_ref
