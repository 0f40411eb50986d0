#pragma once
/// Soft bodies in a world, pushed at random.

#include "maille/studies/bench_report.hpp"

#include <cstdint>

namespace maille::studies {

/// Rows: random pushes of soft bodies, tools and walls by `limits` and by `coupled`, and a frame of a plane
/// that presses a block.
/// @return voxels that were in cells of other objects or outside, over all frames: looked for without the map
std::int64_t push_bodies(bool quick, BenchReport& report);

} // namespace maille::studies
