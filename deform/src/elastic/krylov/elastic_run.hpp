#pragma once
/// One call of an elastic method: the question as limits permit it, when to stop, and how the answer ends.
///
/// `relaxed`, `coupled` and both on tied bodies are runs. A run is stopped once: by its caller, its budget of
/// time, or a search that does not converge. Ranks stop together, when the first one does.

#include "control/method.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/scene/link_limits.hpp"

#include <optional>
#include <string_view>

namespace maille::deform {

class ElasticRun {
public:
  /// Cuts prescribed values back to what limits permit, where they bind. All must outlive this.
  /// @param team null: one of its own
  ElasticRun(const Scene& scene, const Control& control, std::string_view method, bool limits_bind,
             ThreadTeam* team = nullptr);

protected:
  bool must_stop();
  CoupledTask task();
  /// The answer with its status, what was cut back, and its time. @param is_converged if false and nothing
  /// stopped the run, its budget of iterations is used up
  Answer ended(bool is_converged);

  const Scene& scene_;
  const Control& control_;
  Clock clock_;
  std::optional<ThreadTeam> own_team_;
  ThreadTeam& team_;
  std::optional<LinkLimits> limits_; ///< where they bind
  Clipping clipping_;
  Charge of_clipping_;
  Answer answer_;
  std::optional<Status> stopped_;
};

} // namespace maille::deform
