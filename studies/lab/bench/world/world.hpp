#pragma once
/// How fast bodies find one another in an occupancy map, rigid and soft: `studies/lab/run world`.

#include "bench/bench_report.hpp"
#include "maille/scene/grid.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maille::lab {

/// Rigid voxel bodies: poses tested against a half-full world, the map updated, random paths through
/// obstacles, a probe on a soft body, and Bullet's collision detection on the same bodies. One run, medians,
/// one thread.
void bench_world(const BenchOptions& options, BenchReport& report);

/// Its parts, one of which BenchOptions::only names.
std::vector<std::string> world_bench_parts();

/// A row of n things that took so long together [s]; the columns are named for voxels, whatever they are.
void add_row_per(BenchReport& report, const std::string& what, std::int64_t n, double seconds,
                 const std::string& note);

/// A probe that slides over an elastic cube of 100^3 nodes for ten seconds while `coupled` answers how stiff
/// it is there: a row and the check probe_p999_ms. @return ticks after which the proxy was in matter
std::int64_t report_probe(bool quick, BenchReport& report);

/// Rows: random pushes of soft bodies, tools and walls by `limits` and by `coupled`, and a frame of a plane
/// that presses a block.
/// @return voxels that were in cells of other objects or outside, over all frames: looked for without the map
std::int64_t push_bodies(bool quick, BenchReport& report);

/// Random paths at turned plates, and drags of the arms of a C: the checks matter_penetrations and
/// self_crossings, each by geometry that shares nothing with the map.
void report_matter(bool quick, BenchReport& report);

/// Contact of surfaces: five free discs, and a stamp that is shifted: the checks action_reaction_worst,
/// equilibrium_worst, mirror_symmetry and shift_error.
void report_balance(bool quick, BenchReport& report);

/// Rigid objects with masses: Newton's cradle and crowds: the checks momentum_error and energy_gain.
void report_dynamics(bool quick, BenchReport& report);

/// What a hand feels: a stroke over a skull (of $MAILLE_DATA), a muscle touched for the first time, one stamp
/// played and probed: the checks force_step_worst, first_touch_overshoot and play_probe_force_ratio.
void report_touch(BenchReport& report);

/// A nut in an unsteady hand, and what a tick of it costs: the checks nut_threaded_of_100 and nut_tick_ms.
void report_nut(bool quick, BenchReport& report);

/// Against Hertz, and against finite elements with the same nodes in contact: the checks hertz_error,
/// fem_same_contact_plane_error and fem_same_contact_punch_error.
void report_reference(bool quick, BenchReport& report);

} // namespace maille::lab
