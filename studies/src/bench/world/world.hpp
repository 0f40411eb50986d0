#pragma once
/// How fast bodies find one another in an occupancy map: `maille bench world`.

#include "bench/propagate/propagate.hpp"
#include "maille/scene/grid.hpp"

#include <memory>
#include <vector>

namespace maille::studies {

/// Rigid voxel bodies: poses tested against a half-full world, the map updated, random paths through obstacles, a probe on a soft body, and
/// Bullet's collision detection on the same bodies. One run, medians, one thread.
BenchReport bench_world(const BenchOptions& options);

/// A probe that slides over an elastic cube of 100^3 nodes for ten seconds while `coupled` answers how stiff it is there: a row and
/// the check probe_p999_ms. @return ticks after which the proxy was in matter
std::int64_t report_probe(bool quick, BenchReport& report);

/// Bodies of unit voxels as boxes of Bullet: a still one, and a tool that is tested at poses.
struct BulletVoxels {
  virtual ~BulletVoxels() = default;
  /// Whether the tool, shifted by that many voxels, touches the still body.
  virtual bool touches(double x, double y, double z) = 0;
};
/// @param still, tool centres of voxels @return null where Bullet was not built
std::unique_ptr<BulletVoxels> bullet_voxels(const std::vector<Vec3>& still, const std::vector<Vec3>& tool);

} // namespace maille::studies
