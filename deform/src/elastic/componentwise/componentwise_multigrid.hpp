#pragma once
/// Multigrid for one component of the componentwise model.

#include "elastic/componentwise/componentwise_level.hpp"

namespace maille::deform {

/// Levels are rediscretised, not Galerkin products: at most seven weights a node on every level
/// (docs/theory.md, sections 2 and 7b: arithmetic means; semicoarsening under anisotropy), and anchors beside
/// fixed nodes. Figures: docs/developers/relaxation.md. See PlaneMultigrid.
class ComponentwiseMultigrid : public PlaneMultigrid<ComponentwiseLevel> {
public:
  using PlaneMultigrid::PlaneMultigrid;

  /// Full multigrid: finest().u solves A u = f with the fixed values, to about the discretisation error.
  /// Right-hand sides of coarser levels are made from the finest one if `has_forces`.
  void solve_from_coarsest(bool has_forces);
};

} // namespace maille::deform
