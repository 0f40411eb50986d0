#include "app/app.hpp"

#include "maille/deform/estimated_error.hpp"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace maille::live {

Judge::Judge(const Session& session, const LiveTools& tools, int threads, std::function<void()> has_judged)
    : session_(session), tools_(tools), threads_(threads), has_judged_(std::move(has_judged)),
      thread_([this] { run(); }) {}

Judge::~Judge() {
  {
    const std::lock_guard lock(lock_);
    is_stopping_ = true;
  }
  bell_.notify_all();
  thread_.join();
}

void Judge::ask(const Task& task) {
  {
    const std::lock_guard lock(lock_);
    (task.is_fem ? next_fem_ : next_estimate_) = task;
  }
  bell_.notify_all();
}

void Judge::estimate(int object) {
  ask({object, false});
}

void Judge::finite_elements(int object) {
  is_at_fem_ = true;
  ask({object, true});
}

void Judge::run() {
  while (true) {
    Task task;
    {
      std::unique_lock lock(lock_);
      bell_.wait(lock, [this] { return is_stopping_ || next_estimate_ || next_fem_; });
      if (is_stopping_)
        return;
      task = *std::exchange(next_fem_ ? next_fem_ : next_estimate_, std::nullopt);
    }
    Verdict verdict;
    std::shared_ptr<const WorldState> state = session_.state();
    try {
      std::shared_ptr<const Scene> question;
      do { // repeated until the state does not change meanwhile
        state = session_.state();
        question = session_.question(task.object);
      } while (!is_stopping_ && session_.state()->displacements != state->displacements);
      if (question && static_cast<std::size_t>(task.object) < state->displacements.size())
        verdict = judge(task, *state, *question);
      else
        verdict.why_not = "no deformable object";
    } catch (const std::exception& error) {
      verdict.why_not = error.what();
    }
    verdict.object = task.object;
    if (task.object >= 0 && static_cast<std::size_t>(task.object) < state->displacements.size())
      verdict.of = state->displacements[task.object];
    verdict.is_fem = task.is_fem;
    (task.is_fem ? fem_ : estimated_).store(std::make_shared<const Verdict>(std::move(verdict)));
    if (task.is_fem)
      is_at_fem_ = false;
    has_judged_();
  }
}

/// An estimate of an outdated state is dropped; a user has requested finite elements, so these are kept.
Judge::Verdict Judge::judge(const Task& task, const WorldState& state, const Scene& question) const {
  Verdict verdict;
  const auto& displacement = state.displacements[task.object];
  if (!displacement) {
    verdict.why_not = "no deformable object";
    return verdict;
  }
  Control control;
  control.threads = threads_;
  control.stop_requested = [&] {
    return is_stopping_ || (!task.is_fem && session_.state()->displacements != state.displacements);
  };
  if (question.largest_prescribed() == 0) {
    verdict.why_not = "at rest";
    return verdict;
  }
  if (task.is_fem) {
    const Answer truth = tools_.finite_elements(question, control);
    verdict.seconds = truth.seconds.total();
    if (!has_displacement(truth.status)) {
      verdict.why_not = truth.message;
      return verdict;
    }
    verdict.relative = compare(question, *displacement, truth.displacement).relative_l2;
    Displacement difference = *displacement;
    for (std::size_t i = 0; i < difference.values().size(); ++i)
      difference.values()[i] -= truth.displacement.values()[i];
    verdict.difference = std::make_shared<const Displacement>(std::move(difference));
    return verdict;
  }
  const deform::ErrorEstimation estimation = deform::estimate_error(question, *displacement, control);
  if (!estimation.estimate) {
    verdict.why_not = estimation.reason;
    return verdict;
  }
  verdict.seconds = estimation.estimate->seconds;
  verdict.relative = estimation.estimate->norms.relative_l2;
  verdict.difference = std::make_shared<const Displacement>(estimation.estimate->error);
  return verdict;
}

} // namespace maille::live
