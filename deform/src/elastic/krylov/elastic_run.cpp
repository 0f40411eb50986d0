#include "elastic/krylov/elastic_run.hpp"

#include "elastic/links/interval_field.hpp"
#include "maille/base/communicator.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

namespace maille::deform {

int elastic_threads(const Scene& scene, const Control& control) {
  return scene.specimen.grid.n_nodes() < nodes_worth_threads ? 1 : std::max(1, control.threads);
}

ElasticRun::ElasticRun(const Scene& scene, const Control& control, std::string_view method, bool limits_bind,
                       ThreadTeam* team)
    : scene_(scene), control_(control),
      team_(team != nullptr ? *team : own_team_.emplace(elastic_threads(scene, control))),
      of_clipping_(charge_of_clipping(scene)) {
  answer_.method = method;
  clipping_.prescribed = scene.prescribed;
  if (!limits_bind)
    return;
  limits_.emplace(scene);
  if (!permit_all_that_is_prescribed(*limits_, scene))
    clipping_ = FeasibleSet(scene, *limits_, control.threads).clip();
}

bool ElasticRun::must_stop() {
  if (stopped_)
    return true;
  stopped_ = reason_to_stop(control_, clock_);
  if (control_.communicator != nullptr) {
    int why = stopped_ ? static_cast<int>(*stopped_) : -1;
    share_from_first(*control_.communicator, std::span(&why, 1));
    stopped_ = why < 0 ? std::nullopt : std::optional(static_cast<Status>(why));
  }
  return stopped_.has_value();
}

CoupledTask ElasticRun::task() {
  return {scene_,
          control_,
          clipping_.prescribed,
          team_,
          clock_,
          [this] { return must_stop(); },
          limits_ ? &*limits_ : nullptr};
}

Answer ElasticRun::ended(bool is_converged) {
  if (!is_converged && !stopped_)
    stopped_ = Status::budget_reached;
  if (stopped_)
    answer_.reaction.clear();
  if (const std::string cut = describe(scene_, clipping_); !cut.empty())
    answer_.message = answer_.message.empty() ? cut : cut + "; " + answer_.message;
  answer_.n_cut = clipping_.n_cut;
  answer_.status = stopped_ ? *stopped_ : clipping_.n_cut > 0 ? Status::clamped : Status::done;
  answer_.seconds.solve = clock_.seconds() - answer_.seconds.setup;
  return std::move(answer_);
}

} // namespace maille::deform
