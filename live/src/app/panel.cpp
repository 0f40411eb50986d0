/// The panel beside the picture.

#include "app/app.hpp"
#include "maille/scene/cell_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

const std::vector<std::string> methods{"limits", "relaxed", "coupled"};
const std::vector<std::string> colourings{"material", "strain", "error against elasticity",
                                          "error against finite elements"};
const std::vector<std::string> stereos{"one picture", "side by side", "red and cyan"};

Widget text(std::string label, bool emphasis = false) {
  return {
      .kind = Widget::Kind::text, .name = "", .label = std::move(label), .choices = {}, .emphasis = emphasis};
}
Widget heading(std::string label) {
  return {.kind = Widget::Kind::heading, .name = "", .label = std::move(label), .choices = {}};
}
Widget button(std::string name, std::string label) {
  return {.kind = Widget::Kind::button, .name = std::move(name), .label = std::move(label), .choices = {}};
}
Widget slider(std::string name, std::string label, double value, double low, double high,
              bool logarithmic = false) {
  return {.kind = Widget::Kind::slider,
          .name = std::move(name),
          .label = std::move(label),
          .value = value,
          .low = low,
          .high = high,
          .logarithmic = logarithmic,
          .choices = {}};
}
Widget choice(std::string name, std::string label, double value, std::vector<std::string> choices) {
  return {.kind = Widget::Kind::choice,
          .name = std::move(name),
          .label = std::move(label),
          .value = value,
          .choices = std::move(choices)};
}
Widget check(std::string name, std::string label, bool is_on) {
  return {.kind = Widget::Kind::check,
          .name = std::move(name),
          .label = std::move(label),
          .value = is_on ? 1.0 : 0.0,
          .choices = {}};
}

constexpr std::array keys{"drag a body to pull it; drag the ground to turn the view",
                          "right button: shift the view; wheel: zoom, or move the held object in depth",
                          "X Y Z during a drag: move along that axis",
                          "arrows , .   turn the held object",
                          "Shift or P at release: pin the patch there",
                          "R   release all pins",
                          "1 2 3   method: limits, relaxed, coupled",
                          "F   compare with finite elements",
                          "G   rings to turn an object",
                          "T, Shift+T   add a ball or a voxel as a tool",
                          "Ctrl+Z, Ctrl+Y   undo, redo",
                          "Home   show the whole scene",
                          "- =   text size",
                          "F11 full screen, F12 screenshot",
                          "Ctrl+Q   quit"};

constexpr std::array<float, 4> ink{0.1f, 0.1f, 0.12f, 1}, red{0.7f, 0.1f, 0.05f, 1};

std::string milliseconds(double seconds) {
  return fmt::format("{:.{}f} ms", 1000 * seconds, seconds < 0.01 ? 2 : 0);
}

std::string newtons(double force) {
  constexpr double rounding = 1e-9;
  return force < rounding ? "0 N"
         : force < 1e-3   ? fmt::format("{:.3g} mN", 1000 * force)
                          : fmt::format("{:.3g} N", force);
}

/// Remaining motion of the last frame, if known.
std::string still_to_go(const WorldState& state) {
  if (!(state.motion_left.value_or(0) > 0))
    return {};
  return fmt::format(", {:.2g} mm{} left", 1000 * *state.motion_left,
                     state.force_left ? " and " + newtons(*state.force_left) : "");
}

} // namespace

int App::soft_object() const {
  if (!scene_)
    return -1;
  const auto is_soft = [this](int i) {
    return i >= 0 && i < static_cast<int>(scene_->objects.size()) &&
           scene_->objects[i].kind == ObjectKind::deformable;
  };
  if (is_soft(selected_))
    return selected_;
  for (int i = 0; i < static_cast<int>(scene_->objects.size()); ++i)
    if (is_soft(i))
      return i;
  return -1;
}

std::vector<Widget> App::panel() const {
  std::vector<Widget> panel;
  panel.push_back(heading("Maille live"));
  if (has_keys_) {
    panel.push_back(heading("Keys"));
    for (const char* line : keys)
      panel.push_back(text(line));
    panel.push_back(button("keys", "back (F1)"));
    return panel;
  }
  for (const std::string& fault : faults_)
    panel.push_back(text(fault, true));
  if (!session_) {
    const std::vector<Widget> menu = menu_panel();
    panel.insert(panel.end(), menu.begin(), menu.end());
    return panel;
  }
  panel.push_back(text(scene_->title.empty() ? scene_->name : scene_->title));
  panel.push_back(text(what_to_do_));
  panel.push_back(button("keys", "keys (F1)"));
  for (const std::string& note : notes_)
    panel.push_back(text("warning: " + note, true));
  const bool is_soft = soft_object() >= 0;
  if (is_soft) {
    const auto now = std::ranges::find(methods, scene_->method);
    panel.push_back(
        choice("method", "method (1, 2, 3)", static_cast<double>(now - methods.begin()), methods));
    panel.push_back(slider("patch", "radius of the grip [cells]", patch_radius_ / scene_->spacing[0], 0, 12));
    panel.push_back(check("pin", "pin at release (Shift, P)", pins_));
    panel.push_back(button("release", "release all pins (R)"));
    panel.push_back(slider("stiffness", "stiffness factor", stiffness_, 0.1, 10, true));
    panel.push_back(
        choice("limits", "limits", limits_choice_, {"of the scene", "of the material", "none", "these"}));
    if (limits_choice_ == 3) {
      panel.push_back(slider("stretch", "largest stretch", stretch_, 1.01, 2));
      panel.push_back(slider("compress", "smallest stretch", compress_, 0.2, 0.99));
      panel.push_back(slider("shear", "largest shear", shear_, 0.01, 1));
    }
  }
  if (scene_->dimension > 1)
    panel.push_back(check("rings", "rings to turn it (G)", has_rings_));
  panel.push_back(button("tool", "add a ball as a tool (T)"));
  panel.push_back(heading("Time"));
  if (state_->n_frames > 0)
    panel.push_back(slider("frame", fmt::format("frame {} of {}", state_->frame, state_->n_frames),
                           static_cast<double>(state_->frame), 0, static_cast<double>(state_->n_frames)));
  panel.push_back(button("undo", "undo (Ctrl+Z)"));
  panel.push_back(button("redo", "redo (Ctrl+Y)"));
  panel.push_back(heading("Display"));
  if (is_soft) {
    panel.push_back(choice("colour", "colour", static_cast<double>(colour_by_), colourings));
    if (looking_.field)
      panel.push_back(text(fmt::format("{}: 0 (dark) to {:.3g}{} (bright)", looking_.field->name,
                                       looking_.field->high, looking_.field->unit)));
    if (tools_.finite_elements)
      panel.push_back(button("fem", judge_->is_at_fem() ? "finite elements: solving ..."
                                                        : "compare with finite elements (F)"));
  }
  if (scene_->dimension == 3) {
    panel.push_back(slider("opacity", "opacity", looking_.opacity, 0.02, 1, true));
    panel.push_back(slider("threshold", "opacity threshold", looking_.opacity_shift, -0.5, 0.5));
    panel.push_back(choice("stereo", "stereo", static_cast<double>(looking_.stereo), stereos));
  }
  panel.push_back(slider("text", "text size (-, =)", text_scale_, 0.5, 4));
  panel.push_back(button("full", "full screen (F11)"));
  panel.push_back(button("shot", "screenshot (F12)"));
  panel.push_back(button("film", film_ ? "stop recording" : "record a film"));
  if (device_)
    panel.push_back(text(device_->status()));
  if (is_soft && !(scene_->is_open && scene_->method == "limits"))
    panel.push_back(slider("budget", "time per frame [ms], 0: until settled",
                           1000 * budget_.value_or(scene_->method == "limits" ? 0 : usual_budget), 0, 200));
  if (!settings_.menu.empty())
    panel.push_back(button("menu", "back to the menu"));
  return panel;
}

/// Cost and error of the simulation, for the corner of the picture.
std::vector<OverlayText> App::corner() const {
  std::vector<OverlayText> texts;
  const double line = 24 * text_scale_;
  const auto add = [&](std::string label, const std::array<float, 4>& colour = ink) {
    texts.push_back({10, 8 + line * static_cast<double>(texts.size()), std::move(label), colour, false});
  };
  const bool is_soft = soft_object() >= 0;
  add(fmt::format("{}: {} a frame{}{}", is_soft ? scene_->method : "rigid",
                  milliseconds(state_->frame_seconds),
                  state_->is_busy      ? ""
                  : state_->is_settled ? ", settled"
                                       : ", settling",
                  still_to_go(*state_)));
  const auto painted = painter_->newest();
  if (painted)
    add(fmt::format("picture {}{}{}", milliseconds(painted->seconds),
                    report_.event_to_picture.empty()
                        ? ""
                        : ", " + milliseconds(report_.event_to_picture.back()) + " after the input",
                    painted->is_whole ? "" : ", coarse during motion"));
  if (is_soft) {
    const auto verdict = judge_->estimated();
    const bool is_now = Judge::is_of(verdict, *state_);
    if (is_now && verdict->relative)
      add(fmt::format("error against elasticity: about {:.3g} %", 100 * *verdict->relative));
    else
      add(is_now && !verdict->why_not.empty() ? "error against elasticity: " + verdict->why_not.substr(0, 60)
                                              : std::string("error against elasticity: ..."));
    const auto fem = judge_->of_fem();
    if (Judge::is_of(fem, *state_))
      add(fem->relative ? fmt::format("error against finite elements: {:.3g} % ({:.2g} s)",
                                      100 * *fem->relative, fem->seconds)
                        : "finite elements: " + fem->why_not.substr(0, 60));
    add(state_->violation < 0       ? std::string("limits: ...")
        : state_->violation <= 1e-9 ? std::string("limits: kept")
                                    : fmt::format("limits: violated by {:.2g} cells", state_->violation),
        state_->violation > 1e-6 ? red : ink);
    if (state_->knows_forces)
      add("force on the hand: " + newtons(state_->hand_force.norm()));
  }
  if (session_->is_holding() && session_->felt().norm() > 0)
    add("force at 1 kHz: " + newtons(session_->felt().norm()));
  // The message of a frame ended by its budget is obsolete once the world has settled.
  const bool is_over = state_->status == Status::budget_reached && state_->is_settled;
  if (!state_->message.empty() && !is_over)
    add(state_->message.substr(0, 110), state_->status == Status::clamped ? ink : red);
  return texts;
}

void App::take_widget(const Event& event) {
  const std::string& name = event.name;
  if (name.starts_with("open ")) {
    const auto chosen = std::ranges::find(settings_.menu, name.substr(5), &Prototype::name);
    if (chosen != settings_.menu.end())
      load(chosen->scene);
    return;
  }
  if (name == "full" || name == "shot" || name == "film" || name == "text" || name == "keys") {
    if (name == "keys")
      has_keys_ = !has_keys_;
    else if (name == "full")
      key({.kind = EventKind::key_down, .name = "F11", .text = {}});
    else if (name == "shot")
      save_shot(event.text);
    else if (name == "text")
      text_scale_ = std::clamp(event.value, 0.5, 4.0);
    else if (film_)
      end_film();
    else
      do
        film_ = settings_.shots / fmt::format("maille_film_{}", ++shots_);
      while (std::filesystem::exists(film_->string() + "_0000.png"));
    return;
  }
  if (!session_)
    return;
  const auto of_body = [this](const char* what, std::string value) {
    if (const int object = soft_object(); object >= 0)
      pending_[what] = {static_cast<std::size_t>(object), what, std::move(value)};
  };
  if (name == "method") {
    const std::string method = event.text.empty() && event.value >= 0 && event.value < 3
                                   ? methods[static_cast<std::size_t>(event.value)]
                                   : event.text;
    pending_["method"] = {std::nullopt, "method", method};
  } else if (name == "patch") {
    patch_radius_ = std::max(0.0, event.value) * scene_->spacing[0];
  } else if (name == "pin") {
    pins_ = event.value != 0;
  } else if (name == "rings") {
    has_rings_ = event.value != 0;
  } else if (name == "release") {
    session_->release_all(event.time);
  } else if (name == "stiffness") {
    stiffness_ = std::clamp(event.value, 1e-3, 1e3);
    of_body("stiffness", fmt::format("{:.4g}", stiffness_));
  } else if (name == "limits" || name == "stretch" || name == "compress" || name == "shear") {
    if (name == "limits")
      limits_choice_ = static_cast<int>(std::clamp(event.value, 0.0, 3.0));
    else
      (name == "stretch" ? stretch_ : name == "compress" ? compress_ : shear_) = event.value;
    if (limits_choice_ > 0)
      of_body("limits", limits_choice_ == 1 ? "material"
                        : limits_choice_ == 2
                            ? "none"
                            : fmt::format("{:.4g} {:.4g} {:.4g}", std::max(1.0, stretch_),
                                          std::clamp(compress_, 0.0, 1.0), std::max(0.0, shear_)));
  } else if (name == "tool") {
    add_tool(3);
  } else if (name == "frame") {
    session_->go_to(std::llround(std::clamp(event.value, 0.0, 1e9)));
  } else if (name == "undo") {
    session_->undo();
  } else if (name == "redo") {
    session_->redo();
  } else if (name == "colour") {
    colour_by(static_cast<ColourBy>(std::clamp(static_cast<int>(event.value), 0, 3)));
  } else if (name == "fem" && tools_.finite_elements) {
    if (const int object = soft_object(); object >= 0 && !judge_->is_at_fem()) {
      judge_->finite_elements(object);
      colour_by(ColourBy::fem); // shows the difference as soon as it is known
    }
  } else if (name == "opacity") {
    looking_.opacity = std::clamp(event.value, 0.0, 1.0);
  } else if (name == "threshold") {
    looking_.opacity_shift = std::clamp(event.value, -1.0, 1.0);
  } else if (name == "stereo") {
    looking_.stereo = static_cast<Stereo>(std::clamp(static_cast<int>(event.value), 0, 2));
  } else if (name == "budget") {
    budget_ = event.value >= 1 ? event.value / 1000 : 0;
    session_->set_frame_budget(budget_);
  } else if (name == "menu") {
    unload();
    return;
  }
  ask_for_picture();
}

void App::colour_by(ColourBy what) {
  colour_by_ = what;
  refresh_field();
}

void App::refresh_field() {
  looking_.field = nullptr;
  const int object = soft_object();
  if (colour_by_ == ColourBy::look || object < 0)
    return;
  const std::size_t i = object;
  auto field = std::make_shared<Field>();
  field->object = object;
  const Scene& scene = scene_->objects[i].scene;
  if (colour_by_ == ColourBy::strain) {
    for (const auto& strain : cell_fields(scene, *state_->displacements[i]).strain)
      field->of_cells.push_back(static_cast<float>(largest_principal(strain)));
    field->name = "strain";
  } else {
    const auto verdict = colour_by_ == ColourBy::error ? judge_->estimated() : judge_->of_fem();
    if (!Judge::is_of(verdict, *state_) || verdict->object != object || !verdict->difference)
      return; // unknown, or of another state
    field->of_cells = lengths_of_cells(scene.specimen, *verdict->difference);
    for (float& value : field->of_cells)
      value *= 1000;
    field->name = "distance";
    field->unit = " mm";
  }
  field->low = 0;
  field->high = std::max(1e-12f, field->of_cells.empty() ? 0 : *std::ranges::max_element(field->of_cells));
  looking_.field = std::move(field);
}

} // namespace maille::live
