#pragma once
/// How fast and how exact relaxation is: `studies/lab/run relax`.

#include "bench/bench_report.hpp"
#include "bench/relax/relax_case.hpp"

#include <optional>

namespace maille::lab {

/// Boxes poked and stretched, on three lattices: `sweep`, `relaxed` and `coupled` against deal.II's linear
/// elements with every solver at the accuracy of coupled's 1e-3, XPBD and Bullet, with errors against
/// quadratic elements; limits; threads; muscles from an image. One run, medians, one thread unless it says
/// otherwise. Memory is Answer::bytes.
void bench_relax(const BenchOptions& options, BenchReport& report);

/// Cells along a side of the lattices of 33, 65 and 129 nodes, and of the one that is pulled at 16.
struct RelaxSizes {
  int pull, small, middle, large;
  static RelaxSizes of(const BenchOptions& options) {
    return options.quick ? RelaxSizes{8, 8, 16, 24} : RelaxSizes{16, 32, 64, 128};
  }
};

/// A rival in the time that `coupled` takes; nothing where it was not built.
struct RivalFigures {
  double coupled_error = 0, xpbd_error = 0;
  std::optional<double> bullet_error;
};

/// What the checks are made of.
struct RelaxFigures {
  double copy_one = 0, copy_all = 0;                     ///< [GB/s]
  Measured coupled_small, coupled_middle, coupled_large; ///< poke, nu 0.3, to 1e-3
  Measured extrapolated_small;                           ///< the same, from nested lattices
  Measured coupled_large_two_threads, relaxed_large;     ///< the same
  std::vector<Measured> fem_middle;                      ///< the same, deal.II's solvers
  Measured coupled_nu49, q1_nu49;                        ///< middle lattice, poke
  Measured coupled_pull, stretch_middle;                 ///< stretch, nu 0.3
  double limits_active_over_elastic = 0;
  double default_over_wide = 0; ///< seconds of `coupled` on a box without [limits] over those with wide ones
  RivalFigures rivals;
  std::string muscle; ///< the scene's name
  std::int64_t muscle_iterations = 0;
  std::optional<std::int64_t> leg_iterations; ///< nothing without the image
};

/// Parts of it, adding rows and notes.
void bench_boxes(const BenchOptions& options, BenchReport& report, RelaxFigures& figures);
void bench_limits(const BenchOptions& options, BenchReport& report, RelaxFigures& figures);
/// @param box, reference poked, of the Poisson ratio that springs have; @param coupled to 1e-3
void bench_rivals(const Scene& box, const Displacement& reference, const Measured& coupled,
                  BenchReport& report, RelaxFigures& figures);
void bench_muscles(const BenchOptions& options, BenchReport& report, RelaxFigures& figures);
void add_relax_checks(const RelaxSizes& sizes, const RelaxFigures& figures, BenchReport& report);

} // namespace maille::lab
