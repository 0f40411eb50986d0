/// Pointer and key input.

#include "app/app.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

constexpr double key_turn = 5 * 0.017453292519943295; // [rad]
/// Largest rotation of a goal on an axis ahead of the held object [rad].
constexpr double farthest_ahead = 0.75;
/// Motion of the held object per notch of the wheel, relative to the world's size.
constexpr double wheel_step = 0.02;
/// Distance from the pointer within which objects are grabbed [pixels of the window].
constexpr double hand_reach = 7;

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

} // namespace

/// Position under the pointer in the plane through a point that faces the eye.
Eigen::Vector3d App::on_view_plane(double x, double y, const Eigen::Vector3d& through) const {
  const int width = looking_.view.width, height = looking_.view.height;
  if (scene_->dimension < 3)
    return vector(
        flat_point(looking_, static_cast<double>(width) / std::max(1, height), x / width, y / height));
  const render::Ray ray = looking_.view.camera.ray(width, height, x - 0.5, y - 0.5);
  const Eigen::Vector3d ahead = vector(looking_.view.camera.axes()[2]), along = vector(ray.direction),
                        eye = vector(ray.origin);
  const double speed = along.dot(ahead);
  return eye + (std::abs(speed) > 1e-12 ? (through - eye).dot(ahead) / speed : 0) * along;
}

/// Nodes within the patch's radius of a rest position, the nearest first.
std::vector<std::int64_t> App::patch_at(int object, const Vec3& rest) const {
  const Specimen& body = scene_->objects[object].scene.specimen;
  const Grid& grid = body.grid;
  const std::size_t d = grid.dimension();
  std::vector<std::pair<double, std::int64_t>> found;
  double nearest = 1e300;
  std::int64_t nearest_node = -1;
  const auto square = [](double x) { return x * x; };
  Index3 begin{}; // usually the nearest one; few others need a check
  for (std::size_t a = 0; a < d; ++a)
    begin[a] = static_cast<int>(
        std::clamp(std::round((rest[a] - body.origin[a]) / grid.spacing()[a]), 0.0, grid.nodes()[a] - 1.0));
  if (body.is_node(begin)) {
    nearest = 0;
    for (std::size_t a = 0; a < d; ++a)
      nearest += square(body.position(begin)[a] - rest[a]);
    nearest_node = grid.node(begin);
  }
  const double within = patch_radius_ * patch_radius_;
  Index3 at{};
  for (at[2] = 0; at[2] < grid.nodes()[2]; ++at[2])
    for (at[1] = 0; at[1] < grid.nodes()[1]; ++at[1]) {
      const Vec3 row = body.position({0, at[1], at[2]});
      double beside = 0; // lower bound of the distance of the row
      for (std::size_t a = 1; a < d; ++a)
        beside += square(row[a] - rest[a]);
      if (beside > nearest && beside > within)
        continue;
      for (at[0] = 0; at[0] < grid.nodes()[0]; ++at[0]) {
        const double squared = beside + square(row[0] + at[0] * grid.spacing()[0] - rest[0]);
        if ((squared > nearest && squared > within) || !body.is_node(at))
          continue;
        if (squared < nearest) {
          nearest = squared;
          nearest_node = grid.node(at);
        }
        if (squared <= within)
          found.emplace_back(squared, grid.node(at));
      }
    }
  if (nearest_node < 0)
    return {};
  std::vector<std::int64_t> nodes{nearest_node};
  std::ranges::sort(found, {}, [](const auto& each) { return each.second; });
  for (const auto& [squared, node] : found)
    if (node != nearest_node)
      nodes.push_back(node);
  return nodes;
}

/// Grab distance of the hand in pixels of the picture, which may be stretched to the window.
double App::reach_of(const Painted& painted) const {
  return hand_reach * text_scale_ * painted.width / std::max(1, looking_.view.width);
}

void App::pointer_down(const Event& event) {
  last_x_ = event.x;
  last_y_ = event.y;
  if (!session_ || drag_ != Drag::none)
    return;
  const int width = looking_.view.width, height = looking_.view.height;
  if (event.button != 1) {
    drag_ = event.button == 3 || scene_->dimension < 3 ? Drag::pan : Drag::orbit;
    return;
  }
  ring_axis_ = has_rings_ ? sight().ring_at(selected_, event.x, event.y) : -1;
  const std::shared_ptr<const Painted> painted = painter_->newest();
  const auto under = painted && width > 0 && height > 0
                         ? painted->under(event.x / width, event.y / height, reach_of(*painted))
                         : std::nullopt;
  Grip grip;
  if (ring_axis_ >= 0) {
    grip.object = selected_;
    drag_ = Drag::ring;
  } else if (under && scene_->objects[under->object].kind != ObjectKind::fixed) {
    grip.object = under->object;
    if (scene_->objects[under->object].kind == ObjectKind::deformable) {
      grip.nodes = patch_at(under->object, under->rest);
      if (grip.nodes.empty())
        return;
    }
    selected_ = under->object;
    grabbed_at_ = vector(under->world);
    drag_ = Drag::object;
  } else {
    drag_ = scene_->dimension < 3 ? Drag::pan : Drag::orbit;
    return;
  }
  depth_ = 0;
  axis_ = -1;
  keeps_pinned_ = event.shift || pins_;
  session_->grip(std::move(grip), event.time);
  grabbed_pose_ = session_->goal();
}

/// Position on a world axis through the grabbed point that is nearest to the pointer in the window; the wheel
/// moves along the axis. If the axis points to the eye, the pointer has no effect.
Eigen::Vector3d App::on_axis(double x, double y, int axis) const {
  const Eigen::Vector3d along = Eigen::Vector3d::Unit(axis);
  double by = depth_;
  if (scene_->dimension < 3) {
    by += (on_view_plane(x, y, grabbed_at_) - grabbed_at_)[axis];
  } else {
    const render::Ray ray =
        looking_.view.camera.ray(looking_.view.width, looking_.view.height, x - 0.5, y - 0.5);
    const Eigen::Vector3d sight = vector(ray.direction), from = grabbed_at_ - vector(ray.origin);
    const double slant = along.dot(sight), across = 1 - slant * slant; // of the sine between the two
    if (across > 1e-3)
      by += (slant * sight - along).dot(from) / across;
  }
  return grabbed_at_ + by * along;
}

void App::drag_to(double x, double y, double time) {
  Eigen::Vector3d to = axis_ >= 0 ? on_axis(x, y, axis_) : on_view_plane(x, y, grabbed_at_);
  if (scene_->dimension == 3 && axis_ < 0)
    to += depth_ * vector(looking_.view.camera.axes()[2]);
  if (scene_->dimension < 3)
    to[2] = grabbed_at_[2];
  deform::Pose goal = session_->goal();
  // Keys may have rotated it about its centre meanwhile, which has moved the frame: translations add to that.
  goal.position = grabbed_pose_.position + (to - grabbed_at_);
  if (scene_->dimension < 2)
    goal.position[1] = grabbed_pose_.position[1];
  session_->reach(goal, time, axis_);
}

void App::pointer_move(const Event& event) {
  const double dx = event.x - last_x_, dy = event.y - last_y_;
  const std::array<double, 2> from{last_x_, last_y_};
  last_x_ = event.x;
  last_y_ = event.y;
  if (!session_)
    return;
  const int height = std::max(1, looking_.view.height);
  switch (drag_) {
  case Drag::object:
    drag_to(event.x, event.y, event.time);
    break;
  case Drag::ring: {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(ring_axis_);
    turn_held(axis, sight().turned(selected_, ring_axis_, from, {event.x, event.y}), event.time);
    break;
  }
  case Drag::orbit:
    looking_.view.camera = looking_.view.camera.turned(-180.0 * dx / height, 180.0 * dy / height);
    ask_for_picture();
    break;
  case Drag::pan:
    if (scene_->dimension < 3) {
      looking_.middle[0] -= dx * looking_.height / height;
      looking_.middle[1] += dy * looking_.height / height;
    } else {
      render::Camera& camera = looking_.view.camera;
      const Eigen::Vector3d focus = vector(camera.focal_point);
      const Eigen::Vector3d by =
          on_view_plane(from[0], from[1], focus) - on_view_plane(event.x, event.y, focus);
      for (std::size_t a = 0; a < 3; ++a) {
        camera.position[a] += by[static_cast<Eigen::Index>(a)];
        camera.focal_point[a] += by[static_cast<Eigen::Index>(a)];
      }
    }
    ask_for_picture();
    break;
  case Drag::none:
    break;
  }
}

void App::pointer_up(const Event& event) {
  pointer_move(event);
  if ((drag_ == Drag::object || drag_ == Drag::ring) && event.button == 1 && session_)
    session_->let_go(keeps_pinned_ || event.shift || drag_ == Drag::ring, event.time);
  drag_ = Drag::none;
  axis_ = -1;
}

void App::wheel(const Event& event) {
  if (!session_)
    return;
  if (drag_ == Drag::object && scene_->dimension == 3) {
    double size = 0;
    for (std::size_t object = 0; object < scene_->objects.size(); ++object)
      size = std::max(size, ball_about(*scene_, *state_, static_cast<int>(object)).second);
    depth_ += wheel_step * size * event.value;
    drag_to(last_x_, last_y_, event.time);
    return;
  }
  const double factor = std::pow(1.15, std::clamp(event.value, -10.0, 10.0));
  if (scene_->dimension < 3)
    looking_.height = std::clamp(looking_.height / factor, 1e-7, 1e5);
  else
    looking_.view.camera = looking_.view.camera.zoomed(factor);
  ask_for_picture();
}

/// Rotates the held object about its centre, or the selected one in a single step.
void App::turn_held(const Eigen::Vector3d& axis, double angle, double time) {
  if (!session_ || selected_ < 0 || selected_ >= static_cast<int>(scene_->objects.size()) || angle == 0)
    return;
  const bool is_rigid = scene_->objects[selected_].kind == ObjectKind::rigid;
  const bool was_holding = session_->is_holding();
  if (!was_holding && !is_rigid)
    return;
  if (!was_holding)
    session_->grip({selected_, {}}, time);
  deform::Pose goal = session_->goal();
  if (axis_ >= 0) { // a blocked rotation must not accumulate
    const Eigen::AngleAxisd ahead(goal.rotation * state_->frames[selected_].rotation.transpose());
    if (std::abs(ahead.angle()) > farthest_ahead)
      return;
  }
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle, scene_->dimension < 3 ? Eigen::Vector3d::UnitZ() : axis).toRotationMatrix();
  if (is_rigid) {
    const Specimen& body = scene_->objects[selected_].scene.specimen;
    const Eigen::Vector3d middle = goal.position + goal.rotation * deform::middle_of(body);
    const Eigen::Vector3d position = middle + turn * (goal.position - middle);
    grabbed_pose_.position += position - goal.position; // the drag continues from there
    goal.position = position;
  }
  goal.rotation = turn * goal.rotation;
  session_->reach(goal, time, axis_);
  if (!was_holding)
    session_->let_go(true, time);
}

void App::move_key(const Event& event) {
  const bool is_flat = scene_->dimension < 3;
  const auto axes = looking_.view.camera.axes();
  const Eigen::Vector3d right = is_flat ? Eigen::Vector3d::UnitX() : vector(axes[0]),
                        up = is_flat ? Eigen::Vector3d::UnitZ() : vector(axes[1]),
                        back = is_flat      ? Eigen::Vector3d::UnitZ()
                               : axis_ >= 0 ? Eigen::Vector3d::Unit(axis_)
                                            : Eigen::Vector3d(-vector(axes[2]));
  if (event.name == "Left" || event.name == "Right")
    turn_held(up, event.name == "Left" ? key_turn : -key_turn, event.time);
  else if (event.name == "Up" || event.name == "Down")
    turn_held(right, event.name == "Down" ? key_turn : -key_turn, event.time);
  else if (event.name == "," || event.name == ".")
    turn_held(back, event.name == "," ? key_turn : -key_turn, event.time);
}

/// Constrains the drag to a world axis through the grabbed point; a second call removes the constraint.
void App::keep_to_axis(int axis, double time) {
  if (axis >= scene_->dimension)
    return;
  axis_ = axis_ == axis ? -1 : axis;
  depth_ = 0;
  drag_to(last_x_, last_y_, time);
}

void App::key(const Event& event) {
  const std::string& name = event.name;
  if (name == "F11") {
    is_full_screen_ = !is_full_screen_;
    window_.set_full_screen(is_full_screen_);
  } else if (name == "F1") {
    has_keys_ = !has_keys_;
  } else if (event.control && name == "Q") {
    wants_stop_ = true;
  } else if (name == "F12") {
    save_shot("");
  } else if (name == "=" || name == "-") {
    text_scale_ = std::clamp(text_scale_ * (name == "=" ? 1.1 : 1 / 1.1), 0.5, 4.0);
  }
  if (!session_)
    return;
  const bool is_undo = event.control && name == "Z" && !event.shift;
  if (is_undo)
    session_->undo();
  else if (event.control && (name == "Y" || name == "Z"))
    session_->redo();
  else if (event.control)
    return;
  else if (drag_ == Drag::object && (name == "X" || name == "Y" || name == "Z"))
    keep_to_axis(name[0] - 'X', event.time);
  else if (name == "P")
    keeps_pinned_ = true;
  else if (name == "R")
    session_->release_all(event.time);
  else if (name == "1" || name == "2" || name == "3")
    session_->change({std::nullopt, "method", name == "1" ? "limits" : name == "2" ? "relaxed" : "coupled"});
  else if (name == "F")
    take_widget({.kind = EventKind::widget, .name = "fem", .text = {}});
  else if (name == "G")
    has_rings_ = !has_rings_;
  else if (name == "T")
    add_tool(event.shift ? 0 : 3);
  else if (name == "Home")
    resize();
  else
    move_key(event);
}

/// Adds a ball or a single voxel away from all objects: above them, or in the upper left corner of a plane.
void App::add_tool(double radius_in_cells) {
  if (std::ranges::any_of(scene_->objects, [](const WorldObject& o) { return o.name == tool_name; })) {
    say("the tool is there already");
    return;
  }
  const Vec3& cell = scene_->spacing;
  const double radius = radius_in_cells * *std::min_element(cell.begin(), cell.begin() + scene_->dimension);
  Vec3 place{};
  if (scene_->is_open) {
    const Specimen& body = scene_->objects.front().scene.specimen;
    for (int a = 0; a < scene_->dimension; ++a)
      place[a] = body.origin[a] + 0.5 * body.grid.cells()[a] * cell[a];
    const std::size_t last = scene_->dimension - 1;
    place[last] = body.origin[last] + (body.grid.cells()[last] + radius_in_cells + 2) * cell[last];
  } else {
    for (int a = 0; a < scene_->dimension; ++a)
      place[a] = a + 1 == scene_->dimension ? (scene_->cells[a] - radius_in_cells - 1.5) * cell[a]
                                            : (radius_in_cells + 1.5) * cell[a];
  }
  session_->change({std::nullopt, "tool",
                    fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}", radius, place[0], place[1], place[2])});
  selected_ = static_cast<int>(scene_->objects.size());
}

/// A device's button grabs and releases; a disconnected device leaves the held object in place.
void App::follow_device() {
  if (!device_ || !session_)
    return;
  const std::uint32_t buttons = session_->device_buttons();
  const bool is_pressed = (buttons & 1) != 0, was_pressed = (buttons_ & 1) != 0;
  buttons_ = buttons;
  if (is_pressed == was_pressed || drag_ != Drag::none)
    return;
  if (!is_pressed) {
    session_->let_go(!session_->has_device(), seconds_now());
    return;
  }
  int object = selected_;
  for (int i = 0; i < static_cast<int>(scene_->objects.size()); ++i) {
    const WorldObject& each = scene_->objects[i];
    const bool is_better = each.name == tool_name || object < 0;
    if (each.kind == ObjectKind::rigid && is_better)
      object = i;
  }
  if (object >= 0 && scene_->objects[object].kind == ObjectKind::rigid) {
    selected_ = object;
    session_->grip({object, {}}, seconds_now());
  }
}

} // namespace maille::live
