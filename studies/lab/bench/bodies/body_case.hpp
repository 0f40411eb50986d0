#pragma once
/// One body, answered by several methods, each a row of `studies/lab/run bodies`.

#include "bench/bench_report.hpp"
#include "bench/bodies/body_scenes.hpp"
#include "bench/relax/relax_case.hpp"

#include <map>
#include <optional>
#include <string>

namespace maille::lab {

class BodyCase {
public:
  /// @param body outlives this
  BodyCase(const Body& body, bool is_quick, BenchReport& report)
      : body_(body), is_quick_(is_quick), report_(report) {}

  /// Full elasticity without limits, its algebra checked against a tight answer.
  Measured coupled(double tolerance, int threads = 1);
  /// deal.II Q1 by the solver that answers this body soonest with displacements within `goal` of its own
  /// converged ones. Nothing where none does.
  std::optional<Measured> quickest_fem(double goal = 1e-3);
  /// `coupled` within the limits of the materials to a tolerance. @return the answer's times, and whether
  /// limits bind anywhere
  struct Limited {
    Measured measured;
    bool bind = false;
  };
  Limited within_limits(double tolerance);
  /// The next frame of the same body, moved a little further, over the first. [1]
  double next_frame_over_first(double tolerance);

  const Body& body() const { return body_; }
  std::int64_t unknowns() const { return 3 * body_.scene.specimen.n_matter_nodes(); }
  bool is_box() const { return body_.scene.specimen.material_id.empty(); }
  /// At the peak. Of boxes without the answer in float64, which stands beside: of a grid point it has 24. Of
  /// other bodies all: the answer is made when the fields are gone. [1]
  double own_bytes_per_unknown(const Measured& measured) const;

private:
  void add_row(const std::string& method, double tolerance, const Measured& measured, int threads,
               const std::string& note = "");
  std::optional<Measured> fem(fem_ref::LinearSolver solver, double goal, const Displacement& converged);

  const Body& body_;
  bool is_quick_;
  BenchReport& report_;
  std::optional<Displacement> converged_;
};

} // namespace maille::lab
