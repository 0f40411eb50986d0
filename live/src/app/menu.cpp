/// The prototypes by hand.

#include "app/app.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

namespace maille::live {

std::vector<Widget> App::menu_panel() const {
  std::vector<Widget> panel;
  panel.push_back(
      {.kind = Widget::Kind::text, .name = "", .label = "Choose what to take into the hand.", .choices = {}});
  for (const Prototype& each : settings_.menu) {
    panel.push_back(
        {.kind = Widget::Kind::button, .name = "open " + each.name, .label = each.title, .choices = {}});
    panel.push_back({.kind = Widget::Kind::text, .name = "", .label = each.what_to_do, .choices = {}});
  }
  return panel;
}

std::vector<Prototype> standard_menu(const std::filesystem::path& scenes) {
  const std::filesystem::path worlds = scenes / "world";
  return {
      {"maze", "A maze", "Drag the red piece through the maze. It slides along walls and never enters one.",
       worlds / "maze.toml"},
      {"puzzle", "A puzzle", "Push the pieces together into a picture: the lowest row first.",
       worlds / "puzzle.toml"},
      {"bolt", "A nut, a washer and a bolt",
       "Drag the washer, press Z, and go down the bolt; the nut, likewise; comma and full stop turn it on.",
       worlds / "bolt.toml"},
      {"head", "A head, felt", "Drag the fingertip along the skull. The wheel moves it away from you.",
       worlds / "head.toml"},
      {"muscle", "A muscle, poked", "Push the probe into the muscle's belly and let it come back.",
       worlds / "muscle.toml"},
      {"calf", "A calf, pulled",
       "Pull at the muscle's lower end. Keys 1, 2, 3: limits, relaxed, coupled. F: finite elements.",
       scenes / "calf_soleus.toml"},
  };
}

} // namespace maille::live
