#include "bench/mechanics/mechanics.hpp"

#include "bench/mechanics/mechanics_scenes.hpp"
#include "bench/studies/mechanics_promises.hpp"
#include "compare/methods.hpp"
#include "maille/deform/solve.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/mechanics/recovery.hpp"
#include "maille/scene/refined.hpp"
#include "median.hpp"
#include "study/sensitivity/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace maille::lab {

namespace {

using Tensor = std::array<double, 6>;

Answer settled(Answer answer) {
  if (answer.status == Status::interrupted)
    throw BenchStopped();
  if (!has_displacement(answer.status))
    throw std::runtime_error(fmt::format("{} gave no answer: {}", answer.method, answer.message));
  return answer;
}

Answer answer_of(const Scene& scene, const char* method, const Control& control) {
  return settled(answer_by(scene, method, control));
}

double pressure_of(const Tensor& stress) {
  return -(stress[0] + stress[1] + stress[2]) / 3;
}

/// Relative L2 norms of differences from a reference.
struct StressError {
  double stress = 0, pressure = 0;
};

/// What stands on the lattice of half the spacing.
class StressReference {
public:
  explicit StressReference(const Scene& scene)
      : scene_(scene), fine_(refined(scene)), left_out_(cells_at_edges(scene)) {}

  /// Solves it. @return seconds
  double solve(const Control& control) {
    fem_ref::Options options;
    options.degree = 2;
    answer_ = settled(fem_ref::solve(fine_, options, control).answer);
    stress_ = cell_fields(fine_, answer_).stress;
    bring_to_coarse(scene_, fine_, answer_);
    return answer_.seconds.total();
  }
  /// At the nodes of the scene.
  const Answer& answer() const { return answer_; }
  std::int64_t cells_counted() const {
    std::int64_t counted = 0;
    for (std::int64_t cell = 0; cell < scene_.specimen.grid.n_cells(); ++cell)
      counted += counts(cell) ? 1 : 0;
    return counted;
  }
  /// The reference's own means over cells of the scene.
  std::vector<Tensor> means() const {
    const Grid& grid = scene_.specimen.grid;
    std::vector<Tensor> means(static_cast<std::size_t>(grid.n_cells()), Tensor{});
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
      for (int part = 0; part < grid.corners_per_cell(); ++part)
        for (std::size_t k = 0; k < 6; ++k)
          means[static_cast<std::size_t>(cell)][k] +=
              stress_[static_cast<std::size_t>(fine_cell(cell, part))][k] / grid.corners_per_cell();
    return means;
  }
  /// In the part of a cell that a place in it, from 0 to 1 along every axis, is in.
  const Tensor& at(std::int64_t cell, const Vec3& in_cell) const {
    int part = 0;
    for (int a = 0; a < scene_.dimension(); ++a)
      part |= in_cell[static_cast<std::size_t>(a)] > 0.5 ? 1 << a : 0;
    return stress_[static_cast<std::size_t>(fine_cell(cell, part))];
  }
  /// @param stress  of a cell at a place in it, from 0 to 1 along every axis
  StressError error(const std::function<Tensor(std::int64_t cell, const Vec3& in_cell)>& stress) const {
    const Grid& grid = scene_.specimen.grid;
    double difference = 0, size = 0, of_pressure = 0, size_of_pressure = 0;
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
      if (!counts(cell))
        continue;
      for (int part = 0; part < grid.corners_per_cell(); ++part) {
        Vec3 in_cell{};
        for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
          in_cell[a] = part >> a & 1 ? 0.75 : 0.25;
        const Tensor& wanted = stress_[static_cast<std::size_t>(fine_cell(cell, part))];
        const Tensor found = stress(cell, in_cell);
        for (std::size_t k = 0; k < 6; ++k) {
          const double weight = k < 3 ? 1 : 2; // a shear stands in the tensor twice
          difference += weight * (found[k] - wanted[k]) * (found[k] - wanted[k]);
          size += weight * wanted[k] * wanted[k];
        }
        const double pressure = pressure_of(wanted), off = pressure_of(found) - pressure;
        of_pressure += off * off;
        size_of_pressure += pressure * pressure;
      }
    }
    return {std::sqrt(difference / size), std::sqrt(of_pressure / size_of_pressure)};
  }

private:
  /// One of the cells that a cell of the scene is cut into.
  std::int64_t fine_cell(std::int64_t cell, int part) const {
    const Grid& grid = scene_.specimen.grid;
    const Index3 at = grid.cell_at(cell);
    Index3 fine{};
    for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
      fine[a] = 2 * at[a] + (part >> a & 1);
    return fine_.specimen.grid.cell(fine);
  }
  bool counts(std::int64_t cell) const {
    return scene_.specimen.is_matter(cell) && !left_out_[static_cast<std::size_t>(cell)];
  }

  const Scene& scene_;
  Scene fine_;
  std::vector<bool> left_out_;
  Answer answer_;
  std::vector<Tensor> stress_;
};

/// The worst over scenes.
struct Worst {
  double force_error = 0, stress_ratio = 0, gain = std::numeric_limits<double>::infinity();
  double log_of_gains = 0;
  int scenes = 0;
};

struct MethodErrors {
  double force = 0;
  StressError raw, recovered;
  /// With the reference's own stress in every cell, shifted by what the answer's mean is off.
  StressError of_means;
};

MethodErrors errors_of(const Scene& scene, const Answer& answer, const StressReference& reference) {
  const CellFields cells = cell_fields(scene, answer);
  const RecoveredFields recovered(scene, cells);
  const std::vector<Tensor> wanted = reference.means();
  const auto with_means = [&](std::int64_t cell, const Vec3& in_cell) {
    const auto c = static_cast<std::size_t>(cell);
    Tensor stress = reference.at(cell, in_cell);
    for (std::size_t k = 0; k < 6; ++k)
      stress[k] += cells.stress[c][k] - wanted[c][k];
    return stress;
  };
  return {compare_mechanics(scene, answer, reference.answer()).force.value_or(0),
          reference.error(
              [&](std::int64_t cell, const Vec3&) { return cells.stress[static_cast<std::size_t>(cell)]; }),
          reference.error(
              [&](std::int64_t cell, const Vec3& in_cell) { return recovered.at(cell, in_cell).stress; }),
          reference.error(with_means)};
}

/// A body as its scene has it, whose quadratic elements can be afforded on its own lattice alone: forces.
void measure_force(const MechanicsScene& asked, BenchReport& report, Worst& worst) {
  const Scene& scene = asked.scene;
  const Control control = report.one_thread();
  const Answer quadratic = answer_of(scene, "fem_q2", control);
  for (const char* method : {"coupled", "fem_q1"}) {
    const Answer answer = answer_of(scene, method, control);
    const MechanicsErrors errors = compare_mechanics(scene, answer, quadratic);
    report.add({{"scene", asked.name},
                {"method", method},
                {"cells", scene.specimen.n_matter_cells()},
                {"seconds", answer.seconds.total()},
                {"force_error_same_lattice", errors.force.value_or(0)},
                {"energy_error_same_lattice", errors.strain_energy.value_or(0)},
                {"stress_error_same_lattice", errors.stress.value_or(0)},
                {"reference_s", quadratic.seconds.total()}});
    if (std::string_view(method) == "coupled")
      worst.force_error = std::max(worst.force_error, errors.force.value_or(0));
  }
}

void measure(const MechanicsScene& asked, BenchReport& report, Worst& worst) {
  if (asked.lattices == ReferenceLattices::same)
    return measure_force(asked, report, worst);
  const Scene& scene = asked.scene;
  const Control control = report.one_thread();
  StressReference reference(scene);
  const double reference_seconds = reference.solve(control);
  const Answer quadratic = answer_of(scene, "fem_q2", control);
  double coupled_stress = 0, linear_stress = 0;
  for (const char* method : {"coupled", "fem_q1"}) {
    const Answer answer = answer_of(scene, method, control);
    const MethodErrors errors = errors_of(scene, answer, reference);
    const double here = compare_mechanics(scene, answer, quadratic).force.value_or(0);
    report.add({{"scene", asked.name},
                {"method", method},
                {"cells", scene.specimen.n_matter_cells()},
                {"cells_counted", reference.cells_counted()},
                {"seconds", answer.seconds.total()},
                {"force_error_same_lattice", here},
                {"force_error", errors.force},
                {"stress_error_raw", errors.raw.stress},
                {"stress_error_recovered", errors.recovered.stress},
                {"stress_error_of_means", errors.of_means.stress},
                {"pressure_error_raw", errors.raw.pressure},
                {"pressure_error_recovered", errors.recovered.pressure},
                {"reference_s", reference_seconds}});
    if (std::string_view(method) == "fem_q1")
      linear_stress = std::min(errors.raw.stress, errors.recovered.stress);
    if (std::string_view(method) == "coupled") {
      coupled_stress = errors.recovered.stress;
      const double gain = errors.raw.stress / errors.recovered.stress;
      worst.gain = std::min(worst.gain, gain);
      worst.log_of_gains += std::log(gain);
      if (asked.lattices == ReferenceLattices::both)
        worst.force_error = std::max({worst.force_error, here, errors.force});
    }
  }
  worst.stress_ratio = std::max(worst.stress_ratio, coupled_stress / linear_stress);
  ++worst.scenes;
}

/// The largest relative difference between sums over parts and the whole.
double sums_off(const Scene& scene, const Answer& answer, const Mechanics& mechanics) {
  double off = 0;
  for (const auto* parts : {&mechanics.labels, &mechanics.materials}) {
    double at_rest = 0, volume = 0, energy = 0;
    for (const PartMechanics& part : *parts) {
      at_rest += part.volume_at_rest;
      volume += part.volume;
      energy += part.strain_energy.value_or(0);
    }
    off = std::max({off, std::abs(at_rest / mechanics.body.volume_at_rest - 1),
                    std::abs(volume / mechanics.body.volume - 1),
                    std::abs(energy / *answer.strain_energy - 1)});
  }
  Vec3 sum{};
  double size = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i) {
    sum[static_cast<std::size_t>(scene.prescribed[i].component)] += answer.reaction[i];
    size += std::abs(answer.reaction[i]);
  }
  const Vec3 whole = to_world(scene.specimen.placement, sum), holds = total_force(mechanics.holds),
             moves = total_force(mechanics.moves);
  for (std::size_t a = 0; a < 3; ++a)
    off = std::max(off, std::abs(holds[a] + moves[a] - whole[a]) / size);
  return off;
}

/// What `run` says of an answer, and nodal values for a file.
struct Outputs {
  Mechanics mechanics;
  double seconds = 0;
};

Outputs outputs_of(const Scene& scene, const Answer& answer) {
  const auto start = std::chrono::steady_clock::now();
  Outputs outputs;
  outputs.mechanics = mechanics_of(scene, answer, deform::cell_energies(scene, answer));
  const RecoveredFields recovered(scene, answer.displacement);
  outputs.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return outputs;
}

/// @return time of the outputs over time of the solve
double measure_outputs(const std::string& name, const Scene& scene, const BenchOptions& options,
                       BenchReport& report, double& worst_sum) {
  std::vector<double> solves, outputs;
  for (int run = 0; run < (options.quick ? 1 : 3); ++run) {
    const Answer answer = answer_of(scene, "coupled", report.one_thread());
    const Outputs found = outputs_of(scene, answer);
    solves.push_back(answer.seconds.total());
    outputs.push_back(found.seconds);
    worst_sum = std::max(worst_sum, sums_off(scene, answer, found.mechanics));
  }
  const double solve = upper_median(std::move(solves)), output = upper_median(std::move(outputs));
  report.add({{"outputs_of", name},
              {"cells", scene.specimen.n_matter_cells()},
              {"solve_s", solve},
              {"outputs_s", output},
              {"outputs_over_solve", output / solve}});
  return output / solve;
}

} // namespace

void bench_mechanics(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  Worst worst;
  double sum_off = 0;
  const std::optional<Scene> legs = options.quick ? std::nullopt : both_legs();
  std::optional<double> share;
  if (legs)
    share = measure_outputs("calf_both_legs", *legs, options, report, sum_off);
  const double of_block =
      measure_outputs("block of two tissues", two_tissue_block(8), options, report, sum_off);
  for (const MechanicsScene& scene : mechanics_scenes(options, report))
    measure(scene, report, worst);
  report.machine["copy_gb_per_s"] = copy_bandwidth(std::size_t{1} << 28, options.quick ? 1 : 5, 1);
  report.notes.emplace_back("force_error_worst is of bodies as their scenes have them, against quadratic "
                            "elements on the same lattice; "
                            "of strips and the block also on one of half the spacing.");
  report.notes.push_back(
      fmt::format("stress_error_ratio and recovery_gain are those of the worst scene; the geometric "
                  "mean of the gains is {:.3g}.",
                  std::exp(worst.log_of_gains / worst.scenes)));
  if (!share)
    report.notes.emplace_back("outputs_over_solve is of the block of two tissues.");
  report.checks.push_back({"force_error_worst", worst.force_error});
  report.checks.push_back({"stress_error_ratio", worst.stress_ratio});
  report.checks.push_back({"recovery_gain", worst.gain});
  report.checks.push_back({"per_label_sum", sum_off});
  report.checks.push_back({"outputs_over_solve", share.value_or(of_block)});
  report.checks.push_back({"sobol_error", sobol_error_of_ishigami()});
  const auto add = [&](std::vector<BenchCheck> checks) {
    report.checks.insert(report.checks.end(), checks.begin(), checks.end());
    if (report.control.should_stop())
      throw BenchStopped();
  };
  add(mechanics_estimate_checks(options, report.one_thread(), report));
  add(choose_force_checks(options, report.one_thread(), report));
}

} // namespace maille::lab
