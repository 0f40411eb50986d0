#pragma once
/// Subjects of maille-lab: what has no scene. studies/lab/scenes/ has the others.
///
/// One run each, medians, one thread unless a row says otherwise; every subject adds rows, notes and checks.

#include "bench/bench_report.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace maille::lab {

/// Drags of boxes of one material against Gibson's chain mail, with the copy bandwidth measured between the
/// runs; of four inhomogeneous or non-convex bodies against Dijkstra and enhanced chain mail.
void bench_propagate(const BenchOptions& options, BenchReport& report);
/// Its part on the four bodies. @return the worst violation of a link, in ulps of float32 of the largest
/// displacement
double bench_inhomogeneous(const BenchOptions& options, BenchReport& report);

/// A part of `relax`: a cube of 64 mm poked by 0.05 mm, Poisson's ratio 1/4, which springs have: the error of
/// Bullet's soft body against quadratic elements in the time that `coupled` takes, and coupled's own.
void bench_springs(const BenchOptions& options, BenchReport& report);

/// A part of `ecosystem`: an image warped along a smoothly deformed body, beside plastimatch where that is
/// installed.
void bench_warp(const BenchOptions& options, BenchReport& report);

/// Scripted hands in a window (on a display, else headless: a note says which), in real time, two threads of
/// methods and pictures: from event to picture, the loop at 1 kHz, processor time when nothing moves.
void bench_live(const BenchOptions& options, BenchReport& report);

/// A head of 256^3 voxels made of shells (the figures do not depend on real data), eight of 128^3, deformed
/// lattices of 64^3 and 128^3; VTK's casters on the same. Ratios are of the seconds of the calling thread's
/// processor; speedup and frames a second by the clock.
void bench_render(const BenchOptions& options, BenchReport& report);

/// Rigid voxel bodies: poses tested against a half-full world, the map updated, random paths through
/// obstacles, a probe on a soft body, a nut on a bolt, Hertz, and Bullet's collision detection.
void bench_world(const BenchOptions& options, BenchReport& report);
/// Its parts, one of which BenchOptions::only names.
std::vector<std::string> world_bench_parts();
/// A row of n things that took so long together [s]; the columns are named for voxels, whatever they are.
void add_row_per(BenchReport& report, const std::string& what, std::int64_t n, double seconds,
                 const std::string& note);
/// A probe that slides over an elastic cube of 100^3 nodes for ten seconds while `coupled` answers how stiff
/// it is there: a row and the check probe_p999_ms. @return ticks after which the proxy was in matter
std::int64_t report_probe(bool quick, BenchReport& report);
/// What a tick of a nut on its thread costs: the check nut_tick_ms.
void report_nut(bool quick, BenchReport& report);
/// A ball pressed into a block, against Hertz on a layer: the check hertz_error.
void report_reference(bool quick, BenchReport& report);

/// Every promise of one answer, or of one play, for `stability`: answers the scene of a file by a method
/// within ten seconds, or plays a trajectory in a world's.
/// @param trajectory  of a world; empty: of a scene
/// @return `method`, `outcome` (settled, clamped, budget reached, refused, failed), `broken` (the first
/// promise
///         that is broken; empty: none), `violation`, `iterations`, `energy`, `seconds`, `note`
nlohmann::ordered_json promises_of(const std::filesystem::path& scene, const std::string& method,
                                   const std::filesystem::path& trajectory, const Control& control);

} // namespace maille::lab
