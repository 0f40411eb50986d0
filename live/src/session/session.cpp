#include "maille/live/session.hpp"

#include "session/hand_loop.hpp"
#include "session/physics.hpp"

#include <chrono>
#include <future>
#include <utility>

namespace maille::live {

namespace {

/// What the physics' thread answers between two frames. @throws what `answer` does
template<class Answer>
auto told_by(Physics& physics, const Answer& answer) {
  const auto task = std::make_shared<std::packaged_task<decltype(answer())()>>(answer);
  physics.post([task] { (*task)(); });
  return task->get_future().get();
}

} // namespace

Session::Session(WorldScene scene, const SessionSettings& settings)
    : physics_(std::make_unique<Physics>(std::move(scene), settings)),
      hand_(std::make_unique<HandLoop>(*physics_, settings)) {}

/// The hand loop passes goals to the physics, so it ends first.
Session::~Session() {
  hand_.reset();
}

std::shared_ptr<const WorldState> Session::state() const {
  return physics_->state();
}

std::shared_ptr<const WorldScene> Session::scene() const {
  return physics_->scene();
}

void Session::on_state(std::function<void()> call) {
  physics_->on_state(std::move(call));
}

void Session::grip(Grip grip, double event_time) {
  HandWish wish;
  wish.grip_number = ++grip_number_;
  wish.is_rigid = grip.nodes.empty();
  wish.event_time = event_time;
  const std::shared_ptr<const WorldState> now = state();
  const std::size_t object = grip.object;
  if (grip.object < 0 || object >= now->frames.size())
    return;
  if (grip.nodes.empty()) {
    wish.pose = now->frames[object];
  } else {
    const Specimen& body = scene()->objects[object].scene.specimen;
    const Vec3 rest = body.position(body.grid.node_at(grip.nodes.front()));
    const Vec3 by = now->displacements[object]->at(grip.nodes.front());
    wish.pose.position =
        now->frames[object].position +
        now->frames[object].rotation * Eigen::Vector3d(rest[0] + by[0], rest[1] + by[1], rest[2] + by[2]);
  }
  physics_->post([physics = physics_.get(), grip = std::move(grip), number = wish.grip_number, event_time] {
    physics->take_grip(grip, number, event_time);
  });
  wish_ = wish.pose;
  axis_ = -1;
  hand_->wish(wish);
}

void Session::reach(const deform::Pose& goal, double event_time, int axis) {
  if (!is_holding())
    return;
  wish_ = goal;
  axis_ = axis;
  hand_->wish({0, grip_number_, false, goal, event_time, axis});
}

void Session::let_go(bool keep_pinned, double event_time) {
  if (!is_holding())
    return;
  const HandLoop::Felt felt = hand_->felt();
  const bool is_of_device = felt.grip_number == grip_number_ && felt.is_moved_by_device;
  const HandGoal last{grip_number_, is_of_device ? felt.goal : wish_, event_time, axis_};
  physics_->post([physics = physics_.get(), keep_pinned, last, event_time] {
    physics->let_go(keep_pinned, last, event_time);
  });
  open_hand();
}

void Session::open_hand() {
  is_open_ = ++grip_number_;
  hand_->wish({});
}

void Session::release_all(double event_time) {
  physics_->post([physics = physics_.get(), event_time] { physics->release_all(event_time); });
  open_hand();
}

bool Session::is_holding() const {
  return grip_number_ != 0 && grip_number_ != is_open_;
}

deform::Pose Session::goal() const {
  const HandLoop::Felt felt = hand_->felt();
  return felt.grip_number == grip_number_ && felt.is_moved_by_device ? felt.goal : wish_;
}

std::optional<deform::Pose> Session::proxy() const {
  const HandLoop::Felt felt = hand_->felt();
  return felt.grip_number == grip_number_ ? felt.proxy : std::nullopt;
}

double Session::proxy_event_time() const {
  const HandLoop::Felt felt = hand_->felt();
  return felt.grip_number == grip_number_ ? felt.event_time : 0;
}

Eigen::Vector3d Session::felt() const {
  return hand_->felt().force;
}

std::uint32_t Session::device_buttons() const {
  const HandLoop::Felt felt = hand_->felt();
  return felt.device.is_there ? felt.device.buttons : 0;
}

bool Session::has_device() const {
  return hand_->felt().device.is_there;
}

void Session::use(std::shared_ptr<HandDevice> device) {
  hand_->use(std::move(device));
}

void Session::travel(std::function<void(Timeline&, const deform::FrameBudget&)> go) {
  open_hand();
  physics_->post([physics = physics_.get(), go = std::move(go)] {
    physics->say("");
    go(physics->timeline(), physics->budget());
    physics->renew_state();
  });
}

void Session::undo() {
  travel([](Timeline& timeline, const deform::FrameBudget& budget) { timeline.undo(budget); });
}

void Session::redo() {
  travel([](Timeline& timeline, const deform::FrameBudget& budget) { timeline.redo(budget); });
}

void Session::go_to(std::int64_t frame) {
  travel([frame](Timeline& timeline, const deform::FrameBudget& budget) { timeline.go_to(frame, budget); });
}

void Session::change(const WorldSetting& setting) {
  physics_->post([physics = physics_.get(), setting] {
    physics->say("");
    bool is_new = false;
    const auto show = [physics, &is_new] {
      if (!is_new)
        physics->renew_scene();
      is_new = true;
      physics->publish(true);
    };
    physics->timeline().change(setting, physics->budget_by(setting), show);
    physics->renew_scene();
    physics->publish(true);
    physics->prepare();
  });
  open_hand();
}

void Session::set_frame_budget(std::optional<double> seconds) {
  physics_->post([physics = physics_.get(), seconds] { physics->set_budget(seconds); });
}

bool Session::is_idle() const {
  return hand_->is_idle() && physics_->is_idle(physics_->n_goals());
}

bool Session::wait_idle(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!is_idle()) {
    if (std::chrono::steady_clock::now() > until)
      return false;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return true;
}

HandReport Session::hand_report() const {
  return hand_->report();
}

std::string Session::text() const {
  return told_by(*physics_, [this] { return physics_->timeline().text(); });
}

std::int64_t Session::n_penetrations() const {
  return told_by(*physics_, [this] {
    const deform::World& world = physics_->timeline().world();
    // With surface contact, two objects may share a cell.
    const bool has_own_cells = world.scene().contact != ContactLaw::surfaces;
    return world.n_penetrations() + (has_own_cells ? world.n_shared_cells() : std::int64_t{0});
  });
}

std::shared_ptr<const Scene> Session::question(int object) const {
  return told_by(*physics_, [&] {
    const deform::World& world = physics_->timeline().world();
    const bool is_there =
        object >= 0 && object < world.n_objects() && world.kind(object) == ObjectKind::deformable;
    return is_there ? std::make_shared<const Scene>(world.question(object)) : nullptr;
  });
}

} // namespace maille::live
