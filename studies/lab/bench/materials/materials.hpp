#pragma once
/// What tissues, turned fibres and limits taken from elasticity come to: `studies/lab/run materials`.

#include "bench/bench_report.hpp"
#include "maille/scene/answer.hpp"

#include <string_view>

namespace maille::lab {

/// Errors, no speeds. Every tissue of the library pulled off its axes: `coupled` against linear and quadratic
/// elements; elements against the closed form of the pull with free ends; a chain of all tissues against the
/// bar; limits fitted and taut; what `limits` and `relaxed` lose as fibres turn against the lattice, and gain
/// where the lattice turns along. Interrupted, it reports what it has, without checks.
BenchReport bench_materials(const BenchOptions& options, const Control& control);

/// What its parts share.
class MaterialsBench {
public:
  MaterialsBench(const BenchOptions& options, const Control& control, BenchReport& report)
      : options_(options), control_(control), report_(report) {}

  /// Thrown where the caller asked to stop.
  struct Interrupted {};

  bool is_quick() const { return options_.quick; }
  BenchReport& report() { return report_; }
  /// Tells where the run is. @param part of the whole run, 0 to 1. @throws Interrupted
  void at(double part, std::string_view what) const;
  /// For a method: its threads, and the way to stop it.
  Control control() const;
  /// @throws Interrupted; std::runtime_error where the method does not settle
  Answer answer(const Scene& scene, std::string_view method) const;
  Displacement displacement(const Scene& scene, std::string_view method) const {
    return answer(scene, method).displacement;
  }

private:
  const BenchOptions& options_;
  const Control& control_;
  BenchReport& report_;
};

/// Its parts, adding rows and checks; each goes from `start` to `end` of the whole run.
void bench_off_axis_pulls(MaterialsBench& bench, double start, double end);
void bench_free_ends(MaterialsBench& bench, double start, double end);
void bench_taut_bar(MaterialsBench& bench);
void bench_turned_fibres(MaterialsBench& bench, double start, double end);
void bench_fitted_limits(MaterialsBench& bench, double start, double end);

/// Young's modulus of a pull along x and shear gamma_xz per stretch, ends free, the fibre turned in the plane
/// of x and z by `angle` [rad] from x towards z. Lekhnitskii's closed form of an orthotropic solid, not by
/// way of turned matrices.
struct OffAxisPull {
  double youngs_modulus = 0, shear_coupling = 0;
};
OffAxisPull off_axis_pull(const ElasticConstants& constants, double angle);

} // namespace maille::lab
