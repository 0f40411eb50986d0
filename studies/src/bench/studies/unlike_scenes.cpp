#include "bench/studies/unlike_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

namespace maille::studies {

namespace {

constexpr int scale = 2;
using Point = SceneMaker::Point;

void add_layers(SceneMaker& scenes) {
  const std::vector<std::string> tissues{isotropic(0.45, "20 kPa"), isotropic(0.48, "3 kPa"),
                                         isotropic(0.45, "100 kPa")};
  for (const char* word : {"poke", "shear", "bend", "pull", "gravity"})
    scenes.image(
        "muscle, fat, a skin of 1 mm", {10, 8, 8}, tissues,
        [](const Point& at) { return at[2] > 7   ? 3
                                     : at[2] > 5 ? 2
                                                 : 1; }, word);
  for (const char* word : {"poke", "squeeze", "twist"})
    scenes.image(
        "muscle, fat, a skin of 2 mm", {12, 8, 9}, tissues,
        [](const Point& at) { return at[2] > 7   ? 3
                                     : at[2] > 4 ? 2
                                                 : 1; }, word);
  const std::vector<std::string> contrast{isotropic(0.3, "1 MPa"), isotropic(0.49, "10 kPa")};
  for (const char* word : {"pull", "shear"})
    scenes.image(
        "soft seam of 1 mm", {10, 6, 6}, contrast,
        [](const Point& at) { return at[0] > 5 && at[0] < 6 ? 2 : 1; }, word);
  for (const char* word : {"bend", "gravity"})
    scenes.image(
        "stiff sheet of 1 mm in gel", {10, 6, 6}, contrast,
        [](const Point& at) { return at[1] > 3 && at[1] < 4 ? 1 : 2; }, word);
  for (const char* word : {"shear", "pull"})
    scenes.image(
        "checkerboard, 1:100", {8, 8, 6}, contrast,
        [](const Point& at) {
          int steps = 0;
          for (const double x : at)
            steps += static_cast<int>(x / 2);
          return 1 + steps % 2;
        },
        word);
  scenes.image(
      "an L", {10, 6, 8}, {isotropic(0.4)}, [](const Point& at) { return at[0] < 4 || at[2] < 3 ? 1 : 0; },
      "pull");
}

void add_plates(SceneMaker& scenes) {
  const std::string rubber = isotropic(0.45, "1 MPa");
  for (const char* word : {"bend", "gravity", "traction", "pull"}) {
    scenes.box("plate one cell thick", {16, 12, 1}, rubber, word, {1, 1, 0.5});
    scenes.box("plate two cells thick", {16, 12, 1}, rubber, word);
  }
  for (const char* word : {"bend", "gravity"})
    scenes.image(
        "plate of two matters, 1 mm each", {16, 10, 2}, {rubber, isotropic(0.45, "50 kPa")},
        [](const Point& at) { return at[2] < 1 ? 1 : 2; }, word);
}

void add_shells(SceneMaker& scenes) {
  const std::vector<std::string> bone{isotropic(0.3, "1 MPa"), isotropic(0.49, "10 kPa")};
  const auto from_middle = [](const Point& at, const Point& middle, bool along_x) {
    return std::hypot(along_x ? at[0] - middle[0] : 0.0, at[1] - middle[1], at[2] - middle[2]);
  };
  const auto is_inside = [](const Point& at) {
    return std::ranges::all_of(at, [](double x) { return x > 1 && x < 7; });
  };
  for (const char* word : {"shear", "poke"})
    scenes.image(
        "shell of 1 mm around gel", {8, 8, 8}, bone, [=](const Point& at) { return is_inside(at) ? 2 : 1; },
        word);
  for (const char* word : {"squeeze", "gravity", "twist"})
    scenes.image(
        "hollow box with walls of 1 mm", {8, 8, 8}, {bone[0]},
        [=](const Point& at) { return is_inside(at) ? 0 : 1; }, word);
  for (const char* word : {"squeeze", "pull"})
    scenes.image(
        "hollow ball with a wall of 2 mm", {12, 12, 12}, {bone[0]},
        [=](const Point& at) {
          const double r = from_middle(at, {6, 6, 6}, true);
          return r < 6 && r > 4 ? 1 : 0;
        },
        word);
  for (const char* word : {"bend", "twist", "gravity"})
    scenes.image(
        "tube with a wall of 2 mm", {20, 10, 10}, {bone[0]},
        [=](const Point& at) {
          const double r = from_middle(at, {0, 5, 5}, false);
          return r < 5 && r > 3 ? 1 : 0;
        },
        word);
  scenes.image(
      "dome of 2 mm on gel", {12, 12, 7}, bone,
      [=](const Point& at) {
        const double r = from_middle(at, {6, 6, 0}, true);
        return r > 7 ? 0 : r > 5 ? 1 : 2;
      },
      "squeeze");
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

UnlikeScenes::UnlikeScenes() : folder_("maille_unlike") {
  SceneMaker scenes(scale, folder_.path());
  add_layers(scenes);
  add_plates(scenes);
  add_shells(scenes);
  add_loaded_boxes(scenes);
  if (const char* data = std::getenv("MAILLE_DATA"); data && *data) {
    add_muscles(scenes);
    add_heads(scenes);
  }
  scenes_ = scenes.take();
}

} // namespace maille::studies
