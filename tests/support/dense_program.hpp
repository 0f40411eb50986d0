#pragma once
/// Minimum elastic energy of a small body within the limits of its links, by dense matrices.

#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/answer.hpp"
#include "support/fields.hpp"
#include "support/quadratic_program.hpp"

#include <vector>

namespace maille::test {

using deform::LatticeElasticity;
using deform::ThreadTeam;

/// 1/2 u . K u with prescribed components, subject to limits of links.
inline QuadraticProgram dense_program(const Scene& scene, const std::vector<Prescribed>& prescribed) {
  QuadraticProgram program = program_of(scene, prescribed);
  const Grid& grid = scene.specimen.grid;
  const auto n = Eigen::Index(program.unknowns.size());
  ThreadTeam team(1);
  const LatticeElasticity elasticity(scene);
  Displacement unit(grid), forces(grid);
  const auto column = [&](const Displacement& u) {
    elasticity.apply(u, forces, team);
    Eigen::VectorXd values(n);
    for (Eigen::Index i = 0; i < n; ++i)
      values[i] = forces(program.unknowns[std::size_t(i)].first, program.unknowns[std::size_t(i)].second);
    return values;
  };
  program.force = -column(program.values);
  for (Eigen::Index j = 0; j < n; ++j) {
    double& value = unit(program.unknowns[std::size_t(j)].first, program.unknowns[std::size_t(j)].second);
    value = 1;
    program.K.col(j) = column(unit);
    value = 0;
  }
  const LinkLimits limits(scene);
  for (std::size_t b = 0; b < unit.n_components(); ++b)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int axis = 0; axis < grid.dimension(); ++axis)
        if (const auto interval = limits.intervals(grid.node_at(node), axis))
          program.add_row({{1, b, node + grid.stride(axis)}, {-1, b, node}}, interval->low[b],
                          interval->high[b]);
  return program;
}

/// 1/2 u . K u [J].
inline double elastic_energy(const Scene& scene, const Displacement& u) {
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid);
  LatticeElasticity(scene).apply(u, forces, team);
  return 0.5 * test::product(u, forces);
}

} // namespace maille::test
