#pragma once
/// Which bodies have a hierarchy of meshes, each with half the cells of the next along every axis.

#include "maille/scene/scene.hpp"

#include <cstdint>
#include <string>

namespace maille::fem_ref {

/// How often all axes can be halved.
int halvings(const Index3& cells, int dimension);
/// Why the body has no hierarchy of meshes, in words; empty where it has: a box whose every cell is of one
/// matter, with an even number of cells along every axis.
std::string why_no_hierarchy(const Scene& scene);
/// Unknowns of the coarsest mesh: every axis halved while all of them stay whole numbers.
std::int64_t coarsest_unknowns(const Scene& scene, int degree);

} // namespace maille::fem_ref
