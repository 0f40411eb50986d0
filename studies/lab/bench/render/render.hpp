#pragma once
/// What pictures of volumes cost, and how far they are from what is right: `studies/lab/run render`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// A head of 256^3 voxels made of shells (the figures do not depend on real data), eight of 128^3, deformed
/// lattices of 64^3 and 128^3, interlocked objects; VTK's casters on the same. Ratios are of the seconds of
/// the calling thread's processor, medians in one run; speedup and frames a second by the clock.
void bench_render(const BenchOptions& options, BenchReport& report);

/// The largest difference between composited pictures and the plain caster, in 255ths: interlocked rings, nut
/// on bolt, pressed bodies, a C around a rod, from several sides.
double composite_error(bool quick);
/// The same of a slab whose opacity a formula gives, in parts of 1.
double slab_error();

} // namespace maille::lab
