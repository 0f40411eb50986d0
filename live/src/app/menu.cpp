/// The menu of interactive prototypes.

#include "app/app.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace maille::live {

std::vector<Widget> App::menu_panel() const {
  std::vector<Widget> panel;
  panel.push_back({.kind = Widget::Kind::text, .name = "", .label = "Choose a scene.", .choices = {}});
  for (const Prototype& each : settings_.menu) {
    panel.push_back(
        {.kind = Widget::Kind::button, .name = "open " + each.name, .label = each.title, .choices = {}});
    panel.push_back({.kind = Widget::Kind::text, .name = "", .label = each.what_to_do, .choices = {}});
  }
  return panel;
}

/// Instructions for a scene: from the menu, or from its objects.
std::string App::what_to_do_with(const std::filesystem::path& file) const {
  std::error_code none;
  for (const Prototype& each : settings_.menu)
    if (std::filesystem::equivalent(each.scene, file, none))
      return each.what_to_do;
  const auto has = [this](ObjectKind kind) {
    return std::ranges::any_of(scene_->objects,
                               [kind](const WorldObject& each) { return each.kind == kind; });
  };
  std::string text;
  if (has(ObjectKind::rigid))
    text = "Drag a rigid object: it moves, and stops at obstacles. ";
  if (has(ObjectKind::deformable))
    text += "Drag a body: the hand pulls it there. Shift at release pins it. ";
  return text + "Drag the ground to turn the view.";
}

std::vector<Prototype> standard_menu(const std::filesystem::path& scenes) {
  const std::filesystem::path worlds = scenes / "world";
  return {
      {"maze", "A maze", "Drag the red piece through the maze. It slides along walls and never enters one.",
       worlds / "maze.toml"},
      {"puzzle", "A puzzle", "Push the pieces together into a picture, the lowest row first.",
       worlds / "puzzle.toml"},
      {"bolt", "A nut, a washer and a bolt",
       "Drag the washer, press Z, and move it down the bolt; then the nut; comma and full stop turn it.",
       worlds / "bolt.toml"},
      {"photograph", "A photograph, cut up",
       "Drag the pieces from above until the picture is whole; G shows rings to turn them.",
       scenes / "render" / "puzzle.toml"},
      {"chain", "A chain of voxels: figure 7 of 1995",
       "Drag its left end: pushed voxels keep their smallest distance; pulled voxels follow one by one.",
       worlds / "chain.toml"},
      {"eight", "Soft discs, pressed", "Drag the plunger into the discs, the softest first.",
       worlds / "eight.toml"},
      {"head", "A head to feel", "Drag the fingertip along the skull. The wheel moves it away from you.",
       worlds / "head.toml"},
      {"muscle", "A muscle, poked", "Push the probe into the muscle's belly and let it come back.",
       worlds / "muscle.toml"},
      {"calf", "A calf, pulled",
       "Pull at the muscle's lower end. Keys 1, 2, 3: limits, relaxed, coupled. F: finite elements.",
       scenes / "calf_soleus.toml"},
  };
}

} // namespace maille::live
