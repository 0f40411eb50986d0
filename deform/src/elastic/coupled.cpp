#include "elastic/elastic_methods.hpp"

#include "control/method.hpp"
#include "elastic/corotated/coupled_blocks.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/ladder/ladder.hpp"
#include "elastic/limits/constrained_minimum.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/masked/slabs.hpp"
#include "elastic/nested/nested_lattices.hpp"
#include "elastic/tied/tied_solver.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/mechanics/friction.hpp"
#include "maille/scene/plausibility.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace maille::deform {

namespace {

constexpr std::int64_t nodes_worth_threads = 30000, nodes_worth_threads_in_3d = 8000;

class CoupledSolve {
public:
  /// @param kept  null: nothing
  CoupledSolve(const Scene& scene, const Control& control, KeptBody* kept);
  Answer run();

private:
  bool must_stop();
  bool keeps_answers() const {
    return kept_ != nullptr && !kept_->begins_anew && scene_.relaxation.extrapolation == Extrapolation::none;
  }

  const Scene& scene_;
  const Control& control_;
  Clock clock_;
  KeptBody* kept_;
  std::optional<ThreadTeam> own_team_; ///< where nothing is kept
  ThreadTeam& team_;
  std::optional<LinkLimits> limits_; ///< where they bind
  Clipping clipping_;
  Charge of_clipping_;
  Answer answer_;
  std::optional<Status> stopped_;
};

CoupledSolve::CoupledSolve(const Scene& scene, const Control& control, KeptBody* kept)
    : scene_(scene), control_(control), kept_(kept),
      team_(kept != nullptr ? kept->team() : own_team_.emplace(coupled_threads(scene, control))),
      of_clipping_(charge_of_clipping(scene)) {
  answer_.method = "coupled";
  clipping_.prescribed = scene.prescribed;
  if (scene.limits_bind_coupled()) {
    limits_.emplace(scene);
    if (!permit_all_that_is_prescribed(*limits_, scene))
      clipping_ = FeasibleSet(scene, *limits_, control.threads).clip();
  }
}

bool CoupledSolve::must_stop() {
  if (stopped_)
    return true;
  stopped_ = reason_to_stop(control_, clock_);
  if (control_.communicator != nullptr) { // the first says it for all
    int why = stopped_ ? static_cast<int>(*stopped_) : -1;
    share_from_first(*control_.communicator, std::span(&why, 1));
    stopped_ = why < 0 ? std::nullopt : std::optional(static_cast<Status>(why));
  }
  return stopped_.has_value();
}

Answer CoupledSolve::run() {
  Displacement start;
  if (keeps_answers())
    kept_->answers.find_start(scene_, clipping_.prescribed, start);
  const CoupledTask task{scene_,
                         control_,
                         clipping_.prescribed,
                         team_,
                         clock_,
                         [this] { return must_stop(); },
                         limits_ ? &*limits_ : nullptr,
                         start.empty() ? nullptr : &start,
                         limits_ ? obey_limits : nullptr,
                         kept_};
  const bool is_converged = solve_on_nested_lattices(task, coupled_algorithm(scene_), answer_);
  if (answer_.status == Status::failed)
    return std::move(answer_);
  if (!is_converged && !stopped_)
    stopped_ = Status::budget_reached;
  // The next run continues from an answer that a budget cut short.
  if (keeps_answers() && (is_converged || control_.seconds_budget))
    kept_->answers.add(scene_, answer_.displacement);
  if (const std::string cut = describe(scene_, clipping_); !cut.empty())
    answer_.message = answer_.message.empty() ? cut : cut + "; " + answer_.message;
  answer_.n_cut = clipping_.n_cut;
  answer_.status = stopped_ ? *stopped_ : clipping_.n_cut > 0 ? Status::clamped : Status::done;
  answer_.seconds.solve = clock_.seconds() - answer_.seconds.setup;
  return std::move(answer_);
}

} // namespace

CoupledAlgorithm& coupled_algorithm(const Scene& scene) {
  return scene.tied.ties.empty() ? solve_on_ladder : solve_coupled_tied;
}

int coupled_threads(const Scene& scene, const Control& control) {
  const auto worth = scene.dimension() == 3 ? nodes_worth_threads_in_3d : nodes_worth_threads;
  return scene.specimen.grid.n_nodes() < worth ? 1 : std::max(1, control.threads);
}

std::string reason_to_refuse_coupled(const Scene& scene) {
  if (std::string reason = reason_of_moves(scene); !reason.empty())
    return reason;
  if (scene.prescribed.empty() && scene.springs.empty())
    return "nothing is held or moved, so the body can move anywhere";
  if (const std::string motion = remaining_rigid_motion(scene); !motion.empty())
    return motion + ": hold or move more of it";
  if (in_blocks(scene) && scene.contracts() && scene.limits_bind_coupled())
    return "fibres that contract in frame = \"blocks\" know no limits: leave [limits] out";
  if (!scene.tied.ties.empty() && in_blocks(scene))
    return "borders slide along normals that do not turn; frame = \"blocks\" would have to turn them";
  if (has_friction(scene.tied) && scene.limits_bind_coupled())
    return "rounds of friction know no limits: leave [limits] or the friction out";
  return {};
}

bool is_shared_by_ranks(const Scene& scene, int n_ranks) {
  constexpr std::int64_t fewest_cells = 1000; // so the first of the coarser grids is never solved directly
  return n_ranks > 1 && scene.dimension() == 3 && !is_uniform_box(scene) && scene.tied.ties.empty() &&
         scene.sliding.empty() && scene.springs.empty() && !in_blocks(scene) &&
         !scene.limits_bind_coupled() && scene.relaxation.extrapolation == Extrapolation::none &&
         scene.specimen.grid.cells()[2] / Slabs::planes_per_unit >= n_ranks &&
         scene.specimen.n_matter_cells() >= fewest_cells;
}

Answer solve_coupled(const Scene& scene, const Control& control, KeptBody* kept) {
  if (std::string reason = reason_to_refuse_coupled(scene); !reason.empty())
    return refusal("coupled", std::move(reason));
  return in_arena("coupled", control, [&] {
    return in_blocks(scene) ? solve_coupled_in_blocks(scene, control)
                            : CoupledSolve(scene, control, kept).run();
  });
}

Answer solve_carried(const Scene& scene, const Control& control, KeptBody& kept) {
  return in_arena("coupled", control, [&] { return CoupledSolve(scene, control, &kept).run(); });
}

} // namespace maille::deform
