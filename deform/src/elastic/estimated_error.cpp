#include "maille/deform/estimated_error.hpp"

#include "control/method.hpp"
#include "elastic/elastic_methods.hpp"
#include "elastic/estimated_mechanics.hpp"
#include "elastic/finite/coupled_finite.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/model/fixed_mask.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/refined.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Smallest step, as a part of the correction so far, that changes the estimate. The length of the correction
/// is no criterion: steps are orthogonal in the energy norm, so the length changes little long before the
/// correction is complete.
constexpr double small_step = 0.05;
constexpr int fewest_cycles = 2;
/// 2 to the power of 1.5: the ratio of errors of two lattices at order 1.5.
constexpr double halving_gains = std::numbers::sqrt2 * 2;
/// Error over the part of it that half the spacing removes: 2 at order 1, 4/3 at order 2; measured at order
/// 1.3 (docs/developers/relaxation.md). Forces along lines or at points converge more slowly.
constexpr double left_over_gone = 1.7, left_over_gone_at_lines = 4;
constexpr double tolerance_of_finer = 1e-4;
constexpr const char* stopped_elsewhere = "stopped before a correction on another lattice had settled";
/// Largest lattice of half the spacing that is solved.
constexpr double most_finer_cells = 3e7;

double distance(const Displacement& a, const Displacement& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values().size(); ++i)
    sum += std::pow(a.values()[i] - b.values()[i], 2);
  return std::sqrt(sum);
}

/// to += factor (a - b)
void add_difference(double factor, const Displacement& a, const Displacement& b, Displacement& to) {
  for (std::size_t i = 0; i < to.values().size(); ++i)
    to.values()[i] += factor * (a.values()[i] - b.values()[i]);
}

/// Improves states by some cycles of the elastic solver and counts the cycles. At finite strain it solves
/// anew from rest.
class Corrector {
public:
  Corrector(const Control& control, EstimatedError& counts) : control_(control), counts_(counts) {}
  /// @param to_the_end true: until the tolerance of the scene is met; false: until the correction has settled
  /// @return nothing if it was stopped, or has not settled. Reactions are present after a complete solve
  std::optional<Answer> correct(const Scene& scene, const Displacement& start, bool to_the_end = false);

private:
  const Control& control_;
  EstimatedError& counts_;
  Clock clock_;
};

std::optional<Answer> Corrector::correct(const Scene& scene, const Displacement& start, bool to_the_end) {
  if (scene.strain == Strain::finite) {
    Scene elastic = scene;
    elastic.limits = {};
    Answer found = solve_coupled_finite(elastic, control_);
    counts_.cycles += found.iterations;
    return maille::is_converged(found.status) ? std::optional(std::move(found)) : std::nullopt;
  }
  ThreadTeam team(elastic_threads(scene, control_));
  Answer answer;
  Displacement last = start;
  int calls = 0;
  bool is_converged = false;
  const auto is_enough = [&] {
    if (reason_to_stop(control_, clock_))
      return true;
    if (to_the_end || answer.iterations < calls) // asked twice at the same state, in a new round
      return false;
    ++calls;
    is_converged = answer.iterations >= fewest_cycles &&
                   distance(answer.displacement, last) <= small_step * distance(answer.displacement, start);
    last = answer.displacement;
    return is_converged || answer.iterations >= iteration_cap;
  };
  const CoupledTask task{scene, control_, scene.prescribed, team, clock_, is_enough, nullptr, &start};
  const bool is_done = coupled_algorithm(scene)(task, answer);
  counts_.cycles += answer.iterations;
  if (!is_done && !is_converged)
    return std::nullopt;
  return answer;
}

/// The scene on twice the spacing, if the question is exactly the same there.
std::optional<Scene> same_on_coarser(const Scene& scene) {
  std::optional<Scene> coarse = coarser_scene(scene, scene.prescribed);
  if (coarse && !what_coarsening_loses(*coarse, scene, scene.prescribed).empty())
    coarse.reset();
  return coarse;
}

/// Adds the error of `elastic` that `coarse` reveals. @return false if it was stopped
bool add_from_coarser(const Scene& scene, const Scene& coarse, const Displacement& elastic,
                      Corrector& corrector, Displacement& error) {
  const Displacement there = at_coarse_nodes(coarse, scene, elastic);
  const std::optional<Answer> corrected = corrector.correct(coarse, there);
  if (!corrected)
    return false;
  Displacement difference(coarse.specimen.grid), between(scene.specimen.grid);
  add_difference(1 / (halving_gains - 1), corrected->displacement, there, difference);
  ThreadTeam alone(1);
  interpolate(coarse.specimen, difference.values(), scene.specimen, between.values(), alone);
  add_difference(1, between, Displacement(scene.specimen.grid), error);
  return true;
}

/// True if a component is fixed at all corners of the grid's face whose first corner is `at`. @param normal
/// of the face
bool has_face(const Grid& grid, const FixedMask& fixed, std::size_t component, const Index3& at,
              std::size_t normal) {
  const auto dimension = static_cast<std::size_t>(grid.dimension());
  for (unsigned corner = 0; corner < 1U << dimension; ++corner) {
    if ((corner >> normal & 1U) != 0)
      continue;
    Index3 there = at;
    for (std::size_t a = 0; a < dimension; ++a)
      there[a] += static_cast<int>(corner >> a & 1U);
    for (std::size_t a = 0; a < dimension; ++a)
      if (there[a] >= grid.nodes()[a])
        return false;
    if (!fixed(component, grid.node(there)))
      return false;
  }
  return true;
}

/// True if a component is prescribed along a line or at points only, where the elastic displacement grows
/// without bound under refinement.
bool acts_along_lines(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const auto dimension = static_cast<std::size_t>(scene.dimension());
  if (dimension == 1)
    return false;
  const FixedMask fixed(grid, scene.prescribed);
  for (std::size_t b = 0; b < dimension; ++b) {
    std::int64_t n = 0;
    bool has_any_face = false;
    for (std::int64_t node = 0; node < grid.n_nodes() && !has_any_face; ++node) {
      if (!fixed(b, node))
        continue;
      ++n;
      for (std::size_t normal = 0; normal < dimension && !has_any_face; ++normal)
        has_any_face = has_face(grid, fixed, b, grid.node_at(node), normal);
    }
    if (n > 1 && !has_any_face) // a single node only prevents drift and carries little
      return true;
  }
  return false;
}

/// The answer on half the spacing, at the nodes of `scene`. @return nothing if it was stopped
std::optional<Answer> on_finer(const Scene& scene, const Displacement& elastic, Corrector& corrector) {
  Scene fine = refined(scene);
  fine.relaxation.tolerance = tolerance_of_finer;
  Displacement start(fine.specimen.grid);
  ThreadTeam alone(1);
  interpolate(scene.specimen, elastic.values(), fine.specimen, start.values(), alone);
  std::optional<Answer> corrected = corrector.correct(fine, start, true);
  if (corrected) {
    // Means over the fine cells of a cell are more accurate than the strain at its corners.
    corrected->cell_strain = cell_fields(fine, corrected->displacement).strain;
    bring_to_coarse(scene, fine, *corrected);
  }
  return corrected;
}

bool has_memory_for_finer(const Scene& scene, const Control& control) {
  const std::int64_t parts = std::int64_t{1} << scene.dimension();
  return static_cast<double>(parts) * static_cast<double>(scene.specimen.grid.n_cells()) <=
             most_finer_cells &&
         reason_of_memory("", parts * bytes_for_coupled(scene), control).empty();
}

ErrorEstimation none(std::string reason) {
  return {std::nullopt, std::move(reason)};
}

/// Within the body's frame.
/// @param u a state @param answer the answer that it belongs to, with forces; null: mechanics are not
/// estimated @param nearest receives the difference from the best state found, without the safety margin
ErrorEstimation estimate_in_object(const Scene& scene, const Displacement& u, const Answer* answer,
                                   const Control& control, Displacement& nearest) {
  EstimatedError found;
  Corrector corrector(control, found);
  const auto elastic = corrector.correct(scene, u);
  if (!elastic)
    return none("stopped before a correction had settled");
  found.error = Displacement(scene.specimen.grid);
  add_difference(1, u, elastic->displacement, found.error);
  nearest = found.error;
  const bool is_small = compare(scene, u, elastic->displacement).relative_l2 < small_model_error;
  const bool is_along_lines = acts_along_lines(scene);
  std::optional<Answer> finer;
  if (is_small && has_memory_for_finer(scene, control)) {
    finer = on_finer(scene, elastic->displacement, corrector);
    if (!finer)
      return none(stopped_elsewhere);
    add_difference(1, elastic->displacement, finer->displacement, nearest);
    add_difference(is_along_lines ? left_over_gone_at_lines : left_over_gone, elastic->displacement,
                   finer->displacement, found.error);
    found.lattice = OtherLattice::finer;
  } else if (const std::optional<Scene> coarse = same_on_coarser(scene)) {
    if (!add_from_coarser(scene, *coarse, elastic->displacement, corrector, found.error))
      return none(stopped_elsewhere);
    nearest = found.error;
    found.lattice = OtherLattice::coarser;
  } else if (is_small) {
    return none("the body has no lattice of twice the spacing, and there is no memory for one of half");
  }
  if (answer != nullptr)
    found.mechanics = finer ? mechanics_by_finer(scene, *answer, *elastic, *finer, is_along_lines)
                            : mechanics_of_model(scene, *answer, *elastic, found.error);
  return {std::move(found), ""};
}

/// Norms of an error relative to the best state, which `nearest` is the distance from: the margin is not part
/// of the answer.
ErrorNorms over(ErrorNorms error, const ErrorNorms& nearest) {
  if (!(nearest.relative_l2 > 0) || !(nearest.rms > 0) || !(error.relative_l2 > 0))
    return error;
  const double relative = error.rms / nearest.rms * nearest.relative_l2;
  error.relative_max *= relative / error.relative_l2;
  error.relative_l2 = relative;
  return error;
}

/// Estimates the error of a displacement, and of the answer that it belongs to, if any.
ErrorEstimation estimate(const Scene& scene, const Displacement& displacement, const Answer* answer,
                         const Control& control) {
  const Clock clock;
  const Arena arena;
  const Arena::Open open(arena);
  if (std::string reason = reason_to_refuse_coupled(scene); !reason.empty())
    return none(std::move(reason));
  if (!scene.sliding.empty() || !scene.springs.empty() || scene.specimen.has_weights())
    return none("no estimate yet for borders that slide, springs to the ground and cells with weights");
  if (std::string reason = reason_of_memory("an estimate of the error", bytes_for_coupled(scene), control);
      !reason.empty())
    return none(std::move(reason));
  const Frame frame = object_frame(scene);
  Displacement u = displacement;
  to_object(scene, frame, u);
  std::optional<Answer> within;
  if (answer != nullptr)
    within = mechanics_in_object(scene, frame, *answer, u);
  const Answer* const of = within ? &*within : nullptr;
  Displacement nearest;
  ErrorEstimation result = frame.is_turned
                               ? estimate_in_object(in_object(scene, frame), u, of, control, nearest)
                               : estimate_in_object(scene, u, of, control, nearest);
  if (!result.estimate)
    return result;
  const Displacement zero(scene.specimen.grid);
  Displacement truth = u, best = std::move(u);
  add_difference(-1, result.estimate->error, zero, truth);
  add_difference(-1, nearest, zero, best);
  if (frame.is_turned) {
    to_world(scene, frame, truth);
    to_world(scene, frame, best);
    result.estimate->error = Displacement(scene.specimen.grid);
    add_difference(1, displacement, truth, result.estimate->error);
  }
  result.estimate->norms = over(compare(scene, displacement, truth), compare(scene, displacement, best));
  result.estimate->seconds = clock.seconds();
  result.estimate->bytes = arena.peak();
  return result;
}

} // namespace

std::string_view to_string(OtherLattice lattice) {
  return lattice == OtherLattice::none ? "none" : lattice == OtherLattice::coarser ? "coarser" : "finer";
}

ErrorEstimation estimate_error(const Scene& scene, const Displacement& displacement, const Control& control) {
  return estimate(scene, displacement, nullptr, control);
}

ErrorEstimation estimate_error(const Scene& scene, const Answer& answer, const Control& control) {
  return estimate(scene, answer.displacement, &answer, control);
}

} // namespace maille::deform
