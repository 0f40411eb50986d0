#pragma once
/// One box on one lattice, answered by several methods, each a row of `studies/lab/run relax`.

#include "bench/bench_report.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

enum class BoxLoad { poke, stretch };

/// What is asked of a cube, whatever its number of cells.
struct BoxQuestion {
  BoxLoad load = BoxLoad::poke;
  /// "nu 0.3", or "fibre 10": ten times as stiff along fibres at 30 degrees to x as across them
  std::string material;
  ElasticConstants elasticity;
  std::string load_name() const { return load == BoxLoad::poke ? "poke" : "stretch"; }
};

BoxQuestion isotropic_box(BoxLoad load, double poisson_ratio);
BoxQuestion fibrous_box(BoxLoad load);

/// A cube of 64 mm and cells^3 cells, held below. Poke: the middle of the top, a quarter of the side wide,
/// goes down by 0.05 mm; moves are as small as that for the sake of rivals whose springs turn. Stretch: the
/// whole top goes up by 0.05 mm. Limits are taut, which do not bind `coupled`.
/// @param cells a multiple of 8, so that every lattice prescribes the same part of the top
Scene box_scene(const BoxQuestion& question, int cells);

/// The same with limits that are never active, for methods that ask for limits: to find taut ones is no part
/// of relaxing.
Scene with_wide_limits(Scene scene);

/// "65^3"
std::string nodes_in_words(const Scene& scene);

/// What one method needed and how far it is off.
struct Measured {
  Seconds seconds; ///< of the run that is the median by their sum
  std::int64_t iterations = 0, bytes = 0;
  int runs = 1;
  std::optional<double> algebra_error; ///< relative L2 difference from the same equations solved further
  std::optional<double> error;         ///< the same from the fine reference
};

/// Runs once; then, where that took below 1 s, five times more, of which the median counts, and below 5 s
/// twice more, and the median of all three counts. @param is_quick once is enough
/// Before every run, free memory is given back to the system: each method pays for its own pages.
/// @throws std::runtime_error where an answer has no displacement, BenchStopped where it was interrupted
std::pair<Answer, int> median_answer(bool is_quick, const std::function<Answer()>& run_warm);

/// deal.II by one solver and degree on one thread.
Answer fem_answer(const Scene& scene, fem_ref::LinearSolver solver, int degree, double tolerance,
                  const Control& control);

class RelaxCase {
public:
  /// @param reference on the box's own nodes; empty: none was affordable
  /// @param reference_words how the reference was made, for the table
  RelaxCase(const BoxQuestion& question, int cells, Displacement reference, std::string reference_words,
            bool is_quick, BenchReport& report);

  /// Full elasticity on the lattice. @param tolerance of scene.relaxation
  Measured coupled(double tolerance, int threads = 1);
  /// The same to 1e-3, extrapolated from nested lattices where they say how.
  Measured extrapolated();
  /// The model of single components. Tolerance 1e-3, as for `sweep`.
  Measured relaxed();
  /// Voxel by voxel until it has settled. @return sweeps
  std::int64_t sweep();
  /// The same for sizes too slow to run: twenty sweeps give the cost of one, and `sweeps_of_small` on
  /// `cells_of_small` their number, which grows with the square of the nodes along a side.
  void extrapolated_sweep(std::int64_t sweeps_of_small, int cells_of_small);

  /// deal.II Q1, as loosely as keeps its displacements within `goal` of its converged ones; direct solvers as
  /// they are.
  Measured fem_q1(fem_ref::LinearSolver solver, double goal = 1e-3);

  const Scene& scene() const { return scene_; }

private:
  Measured measure(const Answer& answer, int runs, const std::optional<Displacement>& converged) const;
  void add_row(const std::string& method, std::optional<double> tolerance, const Measured& measured,
               const std::string& note = "");
  /// The answer of an iterative solver with the largest tolerance that is within `goal` of the converged one,
  /// and last_tolerance_; nothing if no tolerance is.
  std::optional<Answer> loosest_within(double goal, fem_ref::LinearSolver solver);
  const Displacement& converged_coupled();
  const Displacement& converged_q1();

  BoxQuestion question_;
  Scene scene_;
  Displacement reference_;
  std::string reference_words_;
  bool is_quick_;
  BenchReport& report_;
  std::optional<Displacement> converged_coupled_, converged_q1_;
  double last_tolerance_ = 1e-3; ///< that deal.II needed, where the next solver begins to look
};

} // namespace maille::lab
