#include "elastic/elastic_methods.hpp"

#include "elastic/finite/coupled_finite.hpp"
#include "elastic/krylov/elastic_run.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/limits/constrained_minimum.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/masked/slabs.hpp"
#include "elastic/nested/nested_lattices.hpp"
#include "elastic/tied/tied_methods.hpp"
#include "maille/mechanics/friction.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/plausibility.hpp"

#include <cstdint>
#include <string>
#include <utility>

namespace maille::deform {

namespace {

class CoupledRun : private ElasticRun {
public:
  /// @param kept  null: nothing
  CoupledRun(const Scene& scene, const Control& control, KeptBody* kept)
      : ElasticRun(scene, control, "coupled", scene.limits_bind_coupled(),
                   kept != nullptr ? &kept->team() : nullptr),
        kept_(kept) {}
  Answer run();

private:
  bool keeps_answers() const {
    return kept_ != nullptr && !kept_->begins_anew && scene_.relaxation.extrapolation == Extrapolation::none;
  }

  KeptBody* kept_;
};

Answer CoupledRun::run() {
  Displacement start;
  if (keeps_answers())
    kept_->answers.find_start(scene_, clipping_.prescribed, start);
  CoupledTask task = this->task();
  task.start = start.empty() ? nullptr : &start;
  task.kept = kept_;
  const bool is_converged = solve_on_nested_lattices(task, coupled_algorithm(scene_), answer_);
  if (answer_.status == Status::failed)
    return std::move(answer_);
  // The next run continues from an answer that a budget cut short.
  if (keeps_answers() && (is_converged || control_.seconds_budget))
    kept_->answers.add(scene_, answer_.displacement);
  return ended(is_converged);
}

} // namespace

CoupledAlgorithm& coupled_algorithm(const Scene& scene) {
  return scene.tied.ties.empty() ? solve_within_limits : solve_coupled_tied;
}

std::string reason_to_refuse_coupled(const Scene& scene) {
  if (std::string reason = reason_of_moves(scene); !reason.empty())
    return reason;
  if (scene.prescribed.empty() && scene.springs.empty())
    return "nothing is held or moved, so the body can move anywhere";
  if (const std::string motion = remaining_rigid_motion(scene); !motion.empty())
    return motion + ": hold or move more of it";
  if (scene.strain == Strain::finite && scene.contracts() && scene.limits_bind_coupled())
    return "fibres that contract at finite strain know no limits: leave [limits] out";
  if (!scene.tied.ties.empty() && in_blocks(scene))
    return "borders slide along normals that do not turn; finite strain would have to turn them";
  if (has_friction(scene.tied) && scene.limits_bind_coupled())
    return "rounds of friction know no limits: leave [limits] or the friction out";
  return {};
}

bool is_shared_by_ranks(const Scene& scene, int n_ranks) {
  constexpr std::int64_t fewest_cells = 1000; // so that the first coarser grid is never the last
  return n_ranks > 1 && scene.dimension() == 3 && !is_uniform_box(scene) && scene.tied.ties.empty() &&
         scene.sliding.empty() && scene.springs.empty() && !in_blocks(scene) &&
         !scene.limits_bind_coupled() && scene.relaxation.extrapolation == Extrapolation::none &&
         scene.specimen.grid.cells()[2] / Slabs::planes_per_unit >= n_ranks &&
         scene.specimen.n_matter_cells() >= fewest_cells;
}

Answer solve_coupled(const Scene& scene, const Control& control, KeptBody* kept) {
  if (std::string reason = reason_to_refuse_coupled(scene); !reason.empty())
    return refusal("coupled", std::move(reason));
  return solve_carried(scene, control, kept);
}

Answer solve_carried(const Scene& scene, const Control& control, KeptBody* kept) {
  return in_arena("coupled", control, [&] {
    return scene.strain == Strain::finite ? solve_coupled_finite(scene, control, kept)
                                          : CoupledRun(scene, control, kept).run();
  });
}

} // namespace maille::deform
