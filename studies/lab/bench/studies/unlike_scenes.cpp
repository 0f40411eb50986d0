#include "bench/studies/scene_maker.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

namespace maille::lab {

namespace {

using Point = SceneMaker::Point;

void add_layers(SceneMaker& scenes) {
  scenes.image(body_under_skin(), {"poke", "shear", "bend", "pull", "gravity"});
  scenes.image({"muscle, fat, a skin of 2 mm",
                {12, 8, 9},
                soft_tissues(),
                [](const Point& at) { return at[2] > 7   ? 3
                                             : at[2] > 4 ? 2
                                                         : 1; }},
               {"poke", "squeeze", "twist"});
  scenes.image(body_with_soft_seam(), {"pull", "shear"});
  scenes.image(gel_with_stiff_sheet(), {"bend", "gravity"});
  scenes.image(checkerboard(), {"shear", "pull"});
  scenes.image(body_like_an_l(), {"pull"});
}

void add_plates(SceneMaker& scenes) {
  const std::string rubber = isotropic(0.45, "1 MPa");
  for (const char* word : {"bend", "gravity", "traction", "pull"}) {
    scenes.box("plate one cell thick", {16, 12, 1}, rubber, word, {1, 1, 0.5});
    scenes.box("plate two cells thick", {16, 12, 1}, rubber, word);
  }
  scenes.image({"plate of two materials, 1 mm each",
                {16, 10, 2},
                {rubber, isotropic(0.45, "50 kPa")},
                [](const Point& at) { return at[2] < 1 ? 1 : 2; }},
               {"bend", "gravity"});
}

double distance(const Point& at, const Point& middle) {
  return std::hypot(at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]);
}

void add_shells(SceneMaker& scenes) {
  const std::vector<std::string> bone{stiff_and_soft()[0]};
  scenes.image(shell_around_gel(), {"shear", "poke"});
  scenes.image({"hollow box with walls of 1 mm",
                {8, 8, 8},
                bone,
                [](const Point& at) { return is_inside_shell(at) ? 0 : 1; }},
               {"squeeze", "gravity", "twist"});
  scenes.image({"hollow ball with a wall of 2 mm",
                {12, 12, 12},
                bone,
                [](const Point& at) {
                  const double r = distance(at, {6, 6, 6});
                  return r < 6 && r > 4 ? 1 : 0;
                }},
               {"squeeze", "pull"});
  scenes.image({"tube with a wall of 2 mm",
                {20, 10, 10},
                bone,
                [](const Point& at) {
                  const double r = distance(at, {at[0], 5, 5});
                  return r < 5 && r > 3 ? 1 : 0;
                }},
               {"bend", "twist", "gravity"});
  scenes.image({"dome of 2 mm on gel",
                {12, 12, 7},
                stiff_and_soft(),
                [](const Point& at) {
                  const double r = distance(at, {6, 6, 0});
                  return r > 7 ? 0 : r > 5 ? 1 : 2;
                }},
               {"squeeze"});
}

void add_loaded_boxes(SceneMaker& scenes) {
  for (const double nu : {0.3, 0.49})
    for (const char* word : {"gravity", "traction"}) {
      scenes.box(fmt::format("stout, nu {}", nu), {10, 8, 8}, isotropic(nu), word);
      scenes.box(fmt::format("slender, nu {}", nu), {24, 4, 4}, isotropic(nu, "1 MPa"), word);
    }
  for (const char* word : {"pull", "bend", "gravity"})
    scenes.box("fibres 50:1 at 30 deg", {12, 8, 8}, fibres(50, 30), word);
}

void add_muscles(SceneMaker& scenes) {
  // Constants of their own: the library's muscles have limits, which would bind.
  const std::string pulp =
      "{ E_fibre = \"60 kPa\", E_cross = \"10 kPa\", G_fibre = \"4 kPa\", nu_fibre = 0.3, "
      "nu_cross = 0.4, density = \"1060 kg/m^3\" }";
  const std::array<std::string, 3> ends{held("z-") + moved("z+", 0, 0, 5), held("z-") + moved("z+", 4, 0, 0),
                                        held("z-") + held("z+") + "[[load]]\ngravity = [1, 0, 0]\n"};
  constexpr std::array words{"pulled", "moved aside", "gravity"};
  for (int label = 13; label <= 26; ++label) {
    const auto turn = static_cast<std::size_t>(label) % ends.size();
    scenes.add(fmt::format("muscle {} of a calf from MRI, {}", label, words[turn]),
               calf_muscle(label, pulp) + ends[turn]);
  }
}

void add_heads(SceneMaker& scenes) {
  const std::string press = held("z-") + moved("z+", 0, 0, -1), aside = held("x-") + moved("x+", 1, 0, 0),
                    weight = held("z-") + "[[load]]\ngravity = [0, 1, 0]\n";
  const std::string flesh = isotropic(0.4, "50 kPa"), bone = isotropic(0.3, "1 GPa");
  scenes.add("head from CT, flesh and bone, pressed", head(300, flesh, 4) + press);
  scenes.add("head from CT, flesh and bone, pulled", head(300, flesh, 4) + aside);
  scenes.add("head from CT, flesh and bone, gravity", head(300, flesh, 4) + weight);
  scenes.add("skull from CT, pressed", head(1150, bone, 2) + press);
  scenes.add("skull from CT, gravity", head(1150, bone, 2) + weight);
}

} // namespace

SceneSet unlike_scenes() {
  constexpr int scale = 2;
  return SceneSet("maille_unlike", scale, [](SceneMaker& scenes) {
    add_layers(scenes);
    add_plates(scenes);
    add_shells(scenes);
    add_loaded_boxes(scenes);
    if (const char* data = std::getenv("MAILLE_DATA"); data && *data) {
      add_muscles(scenes);
      add_heads(scenes);
    }
  });
}

} // namespace maille::lab
