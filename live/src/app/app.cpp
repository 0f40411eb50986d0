#include "app/app.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Idle time before the error estimate starts [s].
constexpr double thoughtful = 0.4;
/// Largest age of numbers in the corner that change without a picture [s].
constexpr double readable = 0.1;

/// True if both states draw alike and acknowledge the same events.
bool are_seen_alike(const WorldState& one, const WorldState& other) {
  const auto is_same_pose = [](const deform::Pose& a, const deform::Pose& b) {
    return a.position == b.position && a.rotation == b.rotation;
  };
  const bool hold_same = one.held_nodes && other.held_nodes ? *one.held_nodes == *other.held_nodes
                                                            : one.held_nodes == other.held_nodes;
  return one.scene_number == other.scene_number && one.event_time == other.event_time &&
         one.displacements == other.displacements && one.held_object == other.held_object && hold_same &&
         std::ranges::equal(one.frames, other.frames, is_same_pose);
}

/// True if the file contains the whole trajectory; it is read back, because the disk may have been full for a
/// while.
bool is_recorded(const std::filesystem::path& file, const std::string& trajectory) {
  try {
    return read_own_text_file(file, "a recording", std::numeric_limits<std::int64_t>::max()) == trajectory;
  } catch (const InputError&) {
    return false;
  }
}

} // namespace

Looking first_looking(const WorldScene& scene, int width, int height) {
  const double aspect = static_cast<double>(std::max(1, width)) / std::max(1, height);
  Looking looking;
  if (scene.dimension < 3) {
    looking = flat_looking(scene, aspect);
  } else {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const WorldObject& object : scene.objects) {
      const Specimen& body = object.scene.specimen;
      const deform::Pose frame = deform::frame_of(object);
      for (int corner = 0; corner < 8; ++corner) {
        Eigen::Vector3d x;
        for (int a = 0; a < 3; ++a) {
          const std::size_t i = a;
          x[a] = body.origin[i] + ((corner >> a) & 1) * body.grid.cells()[i] * body.grid.spacing()[i];
        }
        const Eigen::Vector3d at = frame.position + frame.rotation * x;
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
      }
    }
    looking.view.camera = render::seeing({low[0], low[1], low[2]}, {high[0], high[1], high[2]},
                                         {0.45, 0.82, -0.35}, {0, 0, 1}, aspect);
  }
  looking.view.width = std::max(1, width);
  looking.view.height = std::max(1, height);
  return looking;
}

App::App(Window& window, const LiveSettings& settings, const LiveTools& tools)
    : window_(window), settings_(settings), tools_(tools), device_(settings.device),
      game_pad_(dynamic_cast<GamePad*>(settings.device.get())), budget_(settings.frame_budget),
      text_scale_(settings.text_scale > 0 ? settings.text_scale : window.text_scale()) {
  began_ = seconds_now();
}

App::~App() {
  unload();
}

void App::say(const std::string& message) {
  faults_ = {message};
  report_.messages.push_back(message);
}

void App::unload() {
  if (session_) { // the trajectory last, so that it is complete
    report_.penetrations += session_->n_penetrations();
    session_->wait_idle(10);
    report_.trajectory = session_->text();
    if (settings_.record && !is_recorded(*settings_.record, report_.trajectory)) {
      report_.has_lost = true;
      say(settings_.record->string() + ": the recording is not whole");
    }
    report_.last_state = session_->state();
  }
  painter_.reset();
  in_window_ = nullptr;
  judge_.reset();
  waiting_events_.clear();
  if (session_)
    report_.hand = session_->hand_report();
  session_.reset();
  state_ = nullptr;
  scene_ = nullptr;
  drag_ = Drag::none;
  axis_ = -1;
  selected_ = -1;
  file_.reset();
}

void App::load(const std::filesystem::path& file) {
  unload();
  faults_.clear();
  notes_.clear();
  pending_.clear();
  colour_by_ = ColourBy::look;
  stiffness_ = 1;
  limits_choice_ = 0;
  try {
    Loaded loaded = tools_.load(file);
    notes_ = std::move(loaded.notes);
    SessionSettings settings;
    settings.threads = settings_.threads;
    settings.record = settings_.record;
    if (!settings_.method.empty())
      settings.settings = {{std::nullopt, "method", settings_.method}};
    settings.frame_budget = budget_;
    const int dimension = loaded.scene.dimension;
    // Two cells across: a single node of an elastic body yields without bound under refinement.
    patch_radius_ = 1.25 * loaded.scene.spacing[0];
    session_ = std::make_unique<Session>(std::move(loaded.scene), settings);
    session_->use(device_);
    painter_ = std::make_unique<PainterLoop>(
        dimension < 3 ? flat_painter()
                      : volume_painter(std::move(loaded.looks), settings_.threads, std::move(loaded.paints)),
        [this] { window_.wake(); });
    if (settings_.in_step)
      painter_->set_whole_only(true);
    judge_ = std::make_unique<Judge>(*session_, tools_, settings_.threads, [this] { window_.wake(); });
    session_->on_state([this] { window_.wake(); });
    file_ = file;
    state_ = session_->state();
    scene_ = session_->scene();
    what_to_do_ = what_to_do_with(file);
    scene_number_ = state_->scene_number;
    has_rings_ = scene_->dimension == 3;
    shown_state_ = 0;
    judged_ = nullptr;
    looking_ = {};
    looking_.stereo = settings_.stereo;
    resize();
  } catch (const InputError& error) {
    session_.reset();
    for (const Fault& fault : error.faults()) {
      faults_.push_back(to_string(fault));
      report_.messages.push_back(faults_.back());
    }
  } catch (const std::exception& error) {
    session_.reset();
    report_.has_lost = report_.has_lost || settings_.record;
    say(error.what());
  }
}

/// Fits the whole world into a picture of the window's size; a view chosen by the user keeps its direction.
void App::resize() {
  const int width = window_.width() - window_.panel_width(), height = window_.height();
  if (!session_ || width < 1 || height < 1)
    return;
  Looking looking = first_looking(*scene_, width, height);
  looking.stereo = looking_.stereo;
  looking.opacity = looking_.opacity;
  looking.opacity_shift = looking_.opacity_shift;
  looking.field = looking_.field;
  looking_ = looking;
  ask_for_picture();
}

void App::ask_for_picture() {
  if (!session_ || window_.width() < 1 || window_.height() < 1)
    return;
  std::shared_ptr<const WorldState> state = state_;
  const double proxy_time = session_->proxy_event_time();
  shown_proxy_ = session_->proxy();
  if (shown_proxy_ && state->held_object >= 0 && soft_object() >= 0) {
    auto with_proxy = std::make_shared<WorldState>(*state); // the hand is ahead of the physics
    with_proxy->frames[state->held_object] = *shown_proxy_;
    with_proxy->event_time = std::max(with_proxy->event_time, proxy_time);
    state = std::move(with_proxy);
  }
  ++looking_.number;
  painter_->look(scene_, std::move(state), looking_);
}

void App::follow_state() {
  if (!session_)
    return;
  const std::shared_ptr<const WorldState> state = session_->state();
  if (state->number != shown_state_) {
    if (state->scene_number != scene_number_) {
      scene_ = session_->scene();
      if (scene_->objects.size() != state->frames.size())
        return; // the next state belongs to the new scene
      scene_number_ = state->scene_number;
      if (scene_->dimension == 3 || scene_->is_open != was_open_)
        looking_.field = nullptr;
      if (scene_->objects.size() != n_objects_)
        state_ = state, resize();
    }
    was_open_ = scene_->is_open;
    n_objects_ = scene_->objects.size();
    const bool is_alike = shown_state_ != 0 && are_seen_alike(*state_, *state);
    state_ = state;
    shown_state_ = state->number;
    if (is_alike) {
      has_new_numbers_ = true;
    } else {
      still_since_ = seconds_now();
      if (colour_by_ != ColourBy::look)
        refresh_field();
      ask_for_picture();
    }
  } else if (is_felt()) {
    const std::optional<deform::Pose> proxy = session_->proxy(); // moves between physics frames
    if (proxy && (!shown_proxy_ || proxy->position != shown_proxy_->position ||
                  proxy->rotation != shown_proxy_->rotation))
      ask_for_picture();
  }
  if (!pending_.empty() && session_->is_idle()) {
    for (const auto& [name, setting] : std::exchange(pending_, {}))
      session_->change(setting);
  }
  const bool is_still = state_->is_settled && !state_->is_busy && !session_->is_holding() &&
                        seconds_now() - still_since_ > thoughtful;
  if (is_still && soft_object() >= 0 && session_->is_idle()) {
    const auto& now = state_->displacements[soft_object()];
    if (now != judged_)
      judge_->estimate(soft_object());
    judged_ = now;
  }
  const auto verdict = colour_by_ == ColourBy::error ? judge_->estimated() : judge_->of_fem();
  if ((colour_by_ == ColourBy::error || colour_by_ == ColourBy::fem) && verdict && verdict != coloured_) {
    coloured_ = verdict;
    refresh_field();
    ask_for_picture();
  }
}

void App::take(const Event& event) {
  ++report_.events;
  if (event.kind == EventKind::pointer_move && (drag_ == Drag::object || drag_ == Drag::ring))
    waiting_events_.push_back(event.time);
  switch (event.kind) {
  case EventKind::pointer_move:
    pointer_move(event);
    break;
  case EventKind::pointer_down:
    pointer_down(event);
    break;
  case EventKind::pointer_up:
    pointer_up(event);
    break;
  case EventKind::wheel:
    wheel(event);
    break;
  case EventKind::key_down:
    key(event);
    break;
  case EventKind::widget:
    take_widget(event);
    break;
  case EventKind::resize:
    resize();
    break;
  case EventKind::stick:
    if (game_pad_ != nullptr)
      game_pad_->set(event.name, event.value);
    break;
  case EventKind::stick_lost:
    if (game_pad_ != nullptr)
      game_pad_->lose();
    break;
  case EventKind::shot:
    save_shot(event.text);
    break;
  case EventKind::close:
    wants_stop_ = true;
    break;
  case EventKind::key_up:
    break;
  }
}

/// Processes events. Of successive moves only the last one is used.
void App::take_events(std::vector<Event> events) {
  for (std::size_t i = 0; i < events.size() && !wants_stop_; ++i) {
    const bool is_overtaken = i + 1 < events.size() && events[i].kind == EventKind::pointer_move &&
                              events[i + 1].kind == EventKind::pointer_move;
    if (!is_overtaken)
      take(events[i]);
    else if (drag_ == Drag::object || drag_ == Drag::ring)
      waiting_events_.push_back(events[i].time);
  }
}

/// True if events change nothing in the window before the next picture: only the held object moves, or there
/// are no events.
bool App::is_seen_in_pictures(const std::vector<Event>& events) const {
  return std::ranges::all_of(events, [this](const Event& event) {
    return event.kind == EventKind::pointer_move && (drag_ == Drag::object || drag_ == Drag::ring);
  });
}

bool App::is_idle() const {
  return !session_ ||
         (session_->is_idle() && pending_.empty() && !judge_->is_at_fem() && judge_->of_fem() == shown_fem_ &&
          session_->state()->number == shown_state_ && painter_->is_idle() &&
          (!painter_->newest() || painter_->newest()->number == shown_picture_));
}

/// Due events of the script; in step, the next one only, after the previous one is done and displayed.
std::vector<Event> App::scripted(double now) {
  std::vector<Event> events;
  if (!settings_.in_step && session_ && report_.pictures == 0) { // times count from the first picture
    script_began_ = now;
    return events;
  }
  while (next_scripted_ < settings_.script.size()) {
    const ScriptedEvent& next = settings_.script[next_scripted_];
    if (settings_.in_step ? !events.empty() || !is_idle() : now - script_began_ < next.at)
      break;
    events.push_back(next.event);
    events.back().time = now;
    ++next_scripted_;
  }
  return events;
}

LiveReport App::run() {
  if (settings_.scene)
    load(*settings_.scene);
  show();
  script_began_ = seconds_now();
  while (!wants_stop_) {
    const bool has_script = next_scripted_ < settings_.script.size();
    double wait = 0.25;
    if (is_felt())
      wait = 0.004;
    else if (session_ && (film_ || (device_ && session_->is_holding())))
      wait = 0.016;
    else if (device_)
      wait = 0.01;
    else if ((has_script && settings_.in_step) || !pending_.empty())
      wait = 0.002;
    if (has_new_numbers_)
      wait = std::min(wait, readable);
    if (has_script && !settings_.in_step) // the next event of the script is due then
      wait = std::clamp(settings_.script[next_scripted_].at - (seconds_now() - script_began_), 0.001, wait);
    std::vector<Event> events = window_.poll(wait);
    for (Event& event : scripted(seconds_now()))
      events.push_back(std::move(event));
    const bool has_events = !is_seen_in_pictures(events);
    take_events(std::move(events));
    follow_device();
    follow_state();
    const auto newest = painter_ ? painter_->newest() : nullptr;
    const bool is_new = newest && newest->number != shown_picture_;
    const bool has_old_numbers = has_new_numbers_ && seconds_now() - last_shown_ > readable;
    if (has_events || is_new || film_ || window_.wants_drawing() || is_newly_judged() || has_old_numbers)
      show();
    write_film_picture();
    if (!has_script && !settings_.script.empty() && settings_.ends_with_script && is_idle())
      wants_stop_ = true;
  }
  end_film();
  unload();
  report_.text_scale = text_scale_;
  return std::move(report_);
}

/// True if a proxy at 1 kHz leads the held object.
bool App::is_felt() const {
  return session_ && session_->is_holding() && soft_object() >= 0 && session_->proxy().has_value();
}

bool App::is_newly_judged() {
  if (!judge_)
    return false;
  const auto estimated = judge_->estimated(), fem = judge_->of_fem();
  const bool is_new = estimated != shown_estimate_ || fem != shown_fem_;
  shown_estimate_ = estimated;
  shown_fem_ = fem;
  return is_new;
}

LiveReport run_live(Window& window, const LiveSettings& settings, const LiveTools& tools) {
  return App(window, settings, tools).run();
}

} // namespace maille::live
