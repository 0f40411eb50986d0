#include "session/physics.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Larger bodies compute their violation only at rest [nodes].
constexpr std::int64_t small_body = 60'000;
/// Upper bound of frames without motion that had no time to settle.
constexpr int most_in_vain = 15;
/// Upper bound of successive frames for bodies that push each other back and forth.
constexpr int most_settling = 120;

} // namespace

bool has_soft_bodies(const WorldScene& scene) {
  return std::ranges::any_of(scene.objects,
                             [](const WorldObject& object) { return object.kind == ObjectKind::deformable; });
}

Physics::Physics(WorldScene scene, const SessionSettings& settings)
    : timeline_(std::move(scene), settings.settings, settings.record), budget_seconds_(settings.frame_budget),
      threads_(settings.threads) {
  renew_scene();
  publish(false);
  thread_ = std::thread([this] { run(); });
}

Physics::~Physics() {
  is_stopping_ = true;
  ++bell_;
  bell_.notify_all();
  thread_.join();
}

void Physics::on_state(std::function<void()> call) {
  post([this, call = std::move(call)] { on_state_ = call; });
}

void Physics::post(Command command) {
  ++commands_left_;
  {
    const std::lock_guard lock(commands_lock_);
    commands_.push_back(std::move(command));
  }
  ++bell_;
  bell_.notify_one();
}

void Physics::set_goal(const HandGoal& goal) {
  goal_.publish(goal);
  ++goals_set_;
  ++bell_;
  bell_.notify_one();
}

const HandSurroundings* Physics::new_surroundings() {
  return surroundings_.update() ? surroundings_.front().get() : nullptr;
}

bool Physics::is_idle(std::uint64_t goals) const {
  return commands_left_ == 0 && goals_done_ >= goals && is_resting_;
}

void Physics::run() {
  try {
    prepare();
  } catch (const std::exception& error) {
    message_ = error.what();
  }
  while (!is_stopping_) {
    const std::uint32_t bell = bell_;
    is_resting_ = false;
    const std::uint64_t goals = goals_set_;
    if (goal_.update()) {
      goal_now_ = goal_.front();
      has_goal_ = true;
    }
    const bool has_done = do_commands() | go_on();
    if (!has_done)
      goals_done_ = goals;
    if (has_done || bell != bell_)
      continue;
    if (state_.load()->is_busy)
      publish_again();
    is_resting_ = true;
    bell_.wait(bell);
  }
}

bool Physics::do_commands() {
  std::deque<Command> commands;
  {
    const std::lock_guard lock(commands_lock_);
    commands.swap(commands_);
  }
  for (const Command& command : commands) {
    try {
      command();
    } catch (const std::exception& error) {
      message_ = error.what();
    }
    publish(false);
    --commands_left_;
  }
  return !commands.empty();
}

bool Physics::go_on() {
  if (grip_.object >= 0 && has_goal_ && goal_now_.grip_number == grip_number_ && move_towards_goal())
    return true;
  if (!timeline_.world().is_settled() && n_settling_ < most_settling) {
    ++n_settling_;
    keep_result(timeline_.add_frame(spans_of_rest(), budget()));
    publish(false);
    return true;
  }
  if (violation_ < 0 && grip_.object < 0) { // a holding hand may move at any moment and must not wait
    violation_ = timeline_.world().largest_violation();
    publish(false);
  }
  return false;
}

/// Only the hand has moved: publishes a state with the new event time, otherwise unchanged.
void Physics::take_note() {
  if (goal_now_.event_time <= event_time_)
    return;
  event_time_ = goal_now_.event_time;
  publish_again();
}

void Physics::publish_again() {
  auto state = std::make_shared<WorldState>(*state_.load());
  state->number = ++state_number_;
  state->event_time = event_time_;
  state->is_busy = false;
  state_.store(std::move(state));
  if (on_state_)
    on_state_();
}

bool Physics::is_stuck() const {
  return vain_goal_ && vain_goal_->position == goal_now_.pose.position &&
         vain_goal_->rotation == goal_now_.pose.rotation;
}

bool Physics::move_towards_goal() {
  if (is_stuck()) {
    take_note();
    return false;
  }
  const std::vector<DriveSpan> spans = spans_to_goal();
  if (spans.empty()) {
    vain_goal_ = goal_now_.pose;
    take_note();
    return false;
  }
  n_settling_ = 0;
  event_time_ = goal_now_.event_time;
  const auto place = [&] {
    const deform::World& world = timeline_.world();
    return grip_.nodes.empty()
               ? timeline_.drives().frame_now(world, static_cast<std::size_t>(grip_.object))
               : deform::Pose{Eigen::Matrix3d::Identity(), world.position(grip_.object, grip_.nodes.front())};
  };
  const deform::Pose before = place();
  keep_result(timeline_.add_frame(spans, budget()));
  const deform::Pose after = place();
  const double cell = *std::ranges::min_element(timeline_.scene().spacing);
  const bool has_moved = (after.position - before.position).norm() > 1e-4 * cell ||
                         (after.rotation - before.rotation).norm() > 1e-4;
  n_in_vain_ = has_moved ? 0 : n_in_vain_ + 1;
  const bool is_at_rest = timeline_.world().is_settled() &&
                          (after.position - before.position).norm() < 1e-6 * cell &&
                          (after.rotation - before.rotation).norm() < 1e-6;
  const bool has_tried = goal_now_.axis < 0 || n_in_vain_ > 1; // along the axis and about it, in turn
  if ((is_at_rest && has_tried) || n_in_vain_ > most_in_vain)
    vain_goal_ = goal_now_.pose;
  publish(true);
  return true;
}

deform::FrameBudget Physics::budget() const {
  return budget_by({std::nullopt, "method", timeline_.scene().method});
}

deform::FrameBudget Physics::budget_by(const WorldSetting& changed) const {
  const WorldScene& scene = timeline_.scene();
  const std::string& method = changed.name == "method" ? changed.value : scene.method;
  const bool has_forces = method != "limits" && has_soft_bodies(scene);
  std::optional<double> seconds = budget_seconds_;
  if (!seconds && has_forces)
    seconds = usual_budget;
  if (seconds && *seconds <= 0)
    seconds.reset();
  return {seconds, {}, [this] { return is_stopping_.load(); }, threads_};
}

void Physics::keep_result(const deform::FrameResult& result) {
  last_ = result;
  message_ = result.message;
  hand_force_.setZero();
  for (const deform::DriveResult& drive : result.drives)
    hand_force_ += drive.force;
  if (result.drives.empty() && grip_.nodes.empty()) // settling: force of objects that press on the held one
    for (const deform::WorldContact& contact : result.contacts)
      if (contact.other == grip_.object && grip_.object >= 0)
        hand_force_ += contact.force;
  std::int64_t nodes = 0;
  for (const WorldObject& object : timeline_.scene().objects)
    if (object.kind == ObjectKind::deformable)
      nodes += object.scene.specimen.grid.n_nodes();
  violation_ = nodes <= small_body ? timeline_.world().largest_violation() : -1;
  if (!timeline_.record_fault().empty())
    message_ = timeline_.record_fault();
  if (has_surroundings_)
    publish_surroundings();
}

void Physics::take_grip(Grip grip, std::uint64_t number, double event_time) {
  grip_ = std::move(grip);
  grip_number_ = number;
  vain_goal_.reset();
  event_time_ = event_time;
  grip_offsets_.clear();
  const deform::World& world = timeline_.world();
  if (grip_.object >= world.n_objects())
    grip_ = {};
  for (const std::int64_t node : grip_.nodes)
    grip_offsets_.push_back(world.position(grip_.object, node) -
                            world.position(grip_.object, grip_.nodes.front()));
  timeline_.begin_gesture();
  has_surroundings_ = grip_.object >= 0 && grip_.nodes.empty() && !timeline_.scene().is_open;
  if (has_surroundings_)
    publish_surroundings();
}

void Physics::let_go(bool keep_pinned, const HandGoal& last, double event_time) {
  if (grip_.object < 0)
    return;
  if (last.grip_number == grip_number_) { // the rest of the path, as far as one push allows
    goal_now_ = last;
    has_goal_ = true;
    for (int i = 0; i < 64 && !is_stopping_ && move_towards_goal(); ++i) {
    }
  }
  event_time_ = event_time;
  if (!keep_pinned) {
    DriveSpan release;
    release.object = static_cast<std::size_t>(grip_.object);
    release.release = true;
    keep_result(timeline_.add_frame({release}));
  }
  grip_ = {};
  has_goal_ = has_surroundings_ = false;
}

void Physics::release_all(double event_time) {
  event_time_ = event_time;
  timeline_.begin_gesture();
  std::vector<DriveSpan> spans;
  const WorldScene& scene = timeline_.scene();
  for (std::size_t object = 0; object < scene.objects.size(); ++object)
    if (scene.objects[object].kind != ObjectKind::fixed) {
      DriveSpan& release = spans.emplace_back();
      release.object = object;
      release.release = true;
    }
  grip_ = {};
  has_goal_ = has_surroundings_ = false;
  if (!spans.empty())
    keep_result(timeline_.add_frame(spans));
}

void Physics::renew_state() {
  grip_ = {};
  has_goal_ = has_surroundings_ = false;
  violation_ = -1;
  last_ = {};
  hand_force_.setZero();
  if (!timeline_.record_fault().empty())
    message_ = timeline_.record_fault();
}

void Physics::renew_scene() {
  renew_state();
  ++scene_number_;
  scene_.store(std::make_shared<const WorldScene>(timeline_.scene()));
}

void Physics::publish(bool is_busy) {
  const deform::World& world = timeline_.world();
  const std::shared_ptr<const WorldState> old = state_.load();
  auto state = std::make_shared<WorldState>();
  state->number = ++state_number_;
  state->scene_number = scene_number_;
  state->frame = timeline_.frame();
  state->n_frames = timeline_.n_frames();
  const bool is_same_scene = old && old->scene_number == scene_number_;
  for (int object = 0; object < world.n_objects(); ++object) {
    const std::size_t i = object;
    if (world.kind(object) != ObjectKind::deformable) {
      state->frames.push_back(timeline_.drives().frame_now(world, i));
      state->displacements.push_back(nullptr);
      continue;
    }
    state->frames.push_back(deform::frame_of(world.scene().objects[i]));
    if (timeline_.scene().is_open) {
      state->displacements.push_back(world.shared_displacement(object));
      continue;
    }
    const Displacement& now = world.displacement(object);
    const bool is_same = is_same_scene && old->displacements[i] && *old->displacements[i] == now;
    state->displacements.push_back(is_same ? old->displacements[i]
                                           : std::make_shared<const Displacement>(now));
  }
  state->status = last_.status;
  state->message = message_;
  state->frame_seconds = last_.seconds;
  state->violation = violation_;
  state->hand_force = hand_force_;
  state->knows_forces = world.scene().method != "limits";
  state->is_settled = world.is_settled();
  state->motion_left = last_.motion_left;
  state->force_left = last_.force_left;
  state->is_busy = is_busy;
  state->event_time = event_time_;
  state->held_object = grip_.object;
  if (!grip_.nodes.empty())
    state->held_nodes = std::make_shared<const std::vector<std::int64_t>>(grip_.nodes);
  state_.store(std::move(state));
  if (on_state_)
    on_state_();
}

} // namespace maille::live
