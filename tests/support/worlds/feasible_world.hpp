#pragma once
/// Invariants of a world of objects after every frame.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"

namespace maille::test {

/// The map entry of every voxel's cell belongs to its object, has no other occupant, and names the smallest
/// number in each cell.
inline void expect_map_in_step(const deform::World& world) {
  std::map<Index3, deform::World::Occupant> first;
  for (int object = 0; object < world.n_objects(); ++object) {
    if (world.kind(object) != ObjectKind::deformable)
      continue;
    const Specimen& body = world.scene().objects[std::size_t(object)].scene.specimen;
    for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
      if (!body.is_node(body.grid.node_at(node)))
        continue;
      const Eigen::Vector3d x = world.position(object, node);
      Index3 cell{};
      for (int a = 0; a < world.scene().dimension; ++a)
        cell[std::size_t(a)] = int(std::floor(x[a] / world.cell_size()[std::size_t(a)]));
      first.insert({cell, {object, node}});
    }
  }
  for (const auto& [cell, occupant] : first) {
    const auto named = world.occupant(world.map().occupant(cell));
    ASSERT_EQ(named.object, occupant.object);
    ASSERT_EQ(named.voxel, occupant.voxel);
  }
}

/// Invariants of every frame, however it ended.
inline void expect_feasible(const deform::World& world) {
  ASSERT_EQ(world.n_penetrations(), 0);
  ASSERT_EQ(world.n_shared_cells(), 0);
  ASSERT_LT(world.largest_violation(), 1e-12);
  for (int object = 0; object < world.n_objects(); ++object) {
    if (world.kind(object) != ObjectKind::deformable)
      continue;
    const auto values = world.displacement(object).values();
    ASSERT_TRUE(std::ranges::all_of(values, [](double value) { return std::isfinite(value); }));
  }
}

} // namespace maille::test
