#pragma once
/// Answers that are known without solving anything.

#include "stability/extremes.hpp"

namespace maille::studies {

/// u = strain x for coupled and finite elements; for methods whose components do not feel each other only the
/// component `axis`, the others at rest. Holds for `limits` where they are taut.
Truth uniform_strain(const Vec3& strain, int axis);
/// The component x of layers across x, as springs in series share a pull: stiffnesses of the cells along x.
/// The other components at rest.
Truth in_series(const std::vector<double>& stiffness, double by);
/// The whole body moves by that; where limits leave slack, only by methods that relax: others let it lag
/// behind.
Truth shift(const Vec3& by, bool has_slack);
/// The body turns as a whole, as its handles do.
Truth rigid_turn();

} // namespace maille::studies
