#include "world/open_body.hpp"

#include "elastic/elastic_methods.hpp"
#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

void SpareStates::prepare(const Grid& grid, const std::function<bool()>& is_stopped) {
  for (std::size_t i = 0; i < most && !(is_stopped && is_stopped()); ++i) {
    auto state = std::make_unique<Displacement>(grid);
    const std::lock_guard lock(lock_);
    if (spare_.size() < most)
      spare_.push_back(std::move(state));
  }
}

std::shared_ptr<Displacement> SpareStates::take(const std::shared_ptr<SpareStates>& from, const Grid& grid) {
  std::unique_ptr<Displacement> state;
  {
    const std::lock_guard lock(from->lock_);
    if (!from->spare_.empty()) {
      state = std::move(from->spare_.back());
      from->spare_.pop_back();
    }
  }
  if (!state)
    state = std::make_unique<Displacement>(grid);
  return {state.release(), [from](Displacement* back) {
            std::unique_ptr<Displacement> spare(back);
            const std::lock_guard lock(from->lock_);
            if (from->spare_.size() < most)
              from->spare_.push_back(std::move(spare));
          }};
}

OpenBody::OpenBody(std::unique_ptr<WorldObjects> of, std::shared_ptr<const Displacement> state)
    : Engine(std::move(of)), scene_(checked_scene(world().object(0), world().scene)),
      method_(world().scene.method),
      state_(state ? std::move(state) : std::make_shared<const Displacement>(scene_->specimen.grid)) {
  if (method_ == "limits" || scene_->limits_bind_coupled())
    limits_ = std::make_unique<LinkLimits>(*scene_);
  if (method_ == "limits")
    drag_.emplace(*scene_, *limits_);
}

std::unique_ptr<Engine> OpenBody::copy() const {
  if (drag_)
    return nullptr;
  auto copy = std::make_unique<OpenBody>(std::make_unique<WorldObjects>(world()), state_);
  copy->handles_ = handles_;
  copy->is_unsettled_ = is_unsettled_;
  return copy;
}

Eigen::Vector3d OpenBody::position(std::int64_t node) const {
  const Vec3 rest = scene_->specimen.position(scene_->specimen.grid.node_at(node)), by = state_->at(node);
  return {rest[0] + by[0], rest[1] + by[1], rest[2] + by[2]};
}

Vec3 OpenBody::wanted(const Drive& drive, std::int64_t node) const {
  const Eigen::Vector3d to = moved_point(drive.motion, position(node));
  const Vec3 rest = scene_->specimen.position(scene_->specimen.grid.node_at(node)), now = state_->at(node);
  Vec3 displacement = now;
  for (int a = 0; a < scene_->dimension(); ++a)
    if (drive.motion.angle != 0 || drive.motion.by[a] != 0) // unmoved components stay bit-identical
      displacement[a] = to[a] - rest[a];
  return displacement;
}

void OpenBody::release(int object) {
  world().member(object).is_driven = false;
  if (drag_)
    for (const auto& [node, at] : handles_)
      drag_->release(node);
  is_unsettled_ = !drag_ && !handles_.empty();
  handles_.clear();
}

Scene OpenBody::question() const {
  Scene question = *scene_;
  std::erase_if(question.prescribed,
                [this](const Prescribed& p) { return handles_.contains(p.node) && !p.held; });
  for (int b = 0; b < scene_->dimension(); ++b)
    for (const auto& [node, at] : handles_) {
      const bool is_held = std::ranges::any_of(
          scene_->prescribed, [&, n = node](const Prescribed& p) { return p.node == n && p.component == b; });
      if (!is_held)
        question.prescribed.push_back({node, b, at[b], false});
    }
  std::ranges::sort(question.prescribed, {},
                    [](const Prescribed& p) { return std::pair(p.component, p.node); });
  return question;
}

void OpenBody::drag(FrameRun& frame) {
  std::vector<Drag::Move> moves;
  for (const Drive& drive : frame.drives)
    for (const std::int64_t node : drive.nodes)
      moves.push_back({node, wanted(drive, node)});
  if (moves.empty())
    return;
  std::vector<Vec3> reached(moves.size());
  const bool is_cut = drag_->move_to(moves, reached).is_cut;
  bool has_moved = drag_->frame().is_turned;
  for (std::size_t i = 0; i < moves.size(); ++i)
    has_moved = has_moved || reached[i] != state_->at(moves[i].node);
  if (has_moved) { // nodes follow only handles: if these stay, nothing changes
    const std::shared_ptr<Displacement> state = SpareStates::take(spare_, scene_->specimen.grid);
    drag_->copy_to(*state);
    state_ = state;
  }
  for (const Drag::Move& move : moves)
    handles_[move.node] = state_->at(move.node);
  if (is_cut) {
    frame.result.status = Status::clamped;
    frame.result.message = "limits or holds cut the movement back";
  }
  ++frame.result.rounds;
}

void OpenBody::relax(FrameRun& frame) {
  const std::span<const Drive> drives = frame.drives;
  FrameResult& result = frame.result;
  for (const Drive& drive : drives)
    for (const std::int64_t node : drive.nodes)
      handles_[node] = wanted(drive, node);
  if (drives.empty() && !is_unsettled_)
    return;
  Control control = frame.clock.control;
  control.seconds_budget = frame.seconds;
  const Scene asked = question();
  Answer answer = method_ == "coupled" ? this->answer(asked, control) : solve_relaxed(asked, control);
  if (method_ == "coupled" && answer.status == Status::refused) // no holds: see World
    answer = solve_relaxed(asked, control);
  ++result.rounds;
  if (!has_displacement(answer.status)) {
    result.status = answer.status;
    result.message = answer.message;
    for (auto& [node, at] : handles_)
      at = state_->at(node);
    return;
  }
  state_ = std::make_shared<const Displacement>(std::move(answer.displacement));
  for (auto& [node, at] : handles_)
    at = state_->at(node);
  is_unsettled_ = !is_converged(answer.status);
  result.status = answer.status;
  result.message = answer.message;
  answer.displacement = Displacement();
  for (std::size_t i = 0; i < answer.reaction.size() && i < asked.prescribed.size(); ++i) {
    const Prescribed& p = asked.prescribed[i];
    for (std::size_t d = 0; d < drives.size(); ++d)
      if (std::ranges::find(drives[d].nodes, p.node) != drives[d].nodes.end())
        result.drives[d].force[p.component] += answer.reaction[i];
  }
}

/// Without a budget of seconds an answer does not depend on earlier ones, so that a copy continues
/// bit-identically.
Answer OpenBody::answer(const Scene& question, const Control& control) {
  const Keeping keeping = control.seconds_budget ? Keeping::answers : Keeping::hierarchy;
  if (!kept_ || kept_->keeping() != keeping)
    kept_ = std::make_unique<KeptAnswers>(keeping);
  return kept_->answer(question, control);
}

void OpenBody::prepare(const FrameBudget& budget) {
  if (drag_)
    spare_->prepare(scene_->specimen.grid, budget.stop_requested);
  if (method_ != "coupled" || kept_)
    return;
  Control control;
  control.threads = budget.threads;
  control.stop_requested = budget.stop_requested;
  if (budget.seconds)
    control.seconds_budget = std::numeric_limits<double>::max();
  answer(question(), control);
}

FrameResult OpenBody::advance(std::span<const Drive> drives, const FrameBudget& budget) {
  FrameRun frame(*this, drives, budget);
  frame.result.drives.resize(drives.size());
  drag_ ? drag(frame) : relax(frame);
  frame.report_drives();
  if (frame.result.status == Status::done &&
      std::ranges::any_of(frame.result.drives,
                          [](const DriveResult& drive) { return drive.fraction < 1 - negligible; }))
    frame.result.status = Status::clamped;
  frame.result.seconds = frame.seconds_so_far();
  return std::move(frame.result);
}

double OpenBody::largest_violation() const {
  return limits_ ? maille::largest_violation(*scene_, *limits_, *state_, drag_ ? drag_->frame() : Frame{})
                 : 0;
}

std::int64_t OpenBody::bytes() const {
  return Engine::bytes() + static_cast<std::int64_t>(state_->values().size_bytes()) +
         (kept_ ? kept_->bytes() : 0) + (drag_ ? drag_->bytes() : 0) + (limits_ ? limits_->bytes() : 0);
}

} // namespace maille::deform
