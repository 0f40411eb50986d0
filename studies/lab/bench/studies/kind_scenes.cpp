#include "bench/studies/scene_maker.hpp"

#include <fmt/format.h>

#include <cstdlib>

namespace maille::lab {

namespace {

void add_boxes(SceneMaker& kinds) {
  for (const double nu : {0.3, 0.45, 0.49, 0.499, 0.4999})
    for (const char* word : {"poke", "shear", "pull", "bend"})
      kinds.box(fmt::format("box, nu {}", nu), {12, 8, 8}, isotropic(nu), word);
  kinds.box("flat cells, nu 0.3", {12, 12, 16}, isotropic(0.3), "bend", {1, 1, 0.25});
  for (const double nu : {0.3, 0.49})
    for (const char* word : {"bend", "twist"})
      kinds.box(fmt::format("slender, nu {}", nu), {24, 4, 4}, isotropic(nu), word);
  for (const double nu : {0.3, 0.45})
    kinds.box(fmt::format("held along an edge, nu {}", nu), {12, 8, 4}, isotropic(nu), "hinge");
  kinds.box("box, nu 0.3", {10, 8, 8}, isotropic(0.3), "gravity");
  kinds.box("box, nu 0.49", {10, 8, 8}, isotropic(0.49), "gravity");
  kinds.box("box, nu 0.45", {10, 8, 8}, isotropic(0.45), "traction");
}

void add_plates(SceneMaker& kinds) {
  for (const double nu : {0.3, 0.45, 0.49})
    kinds.box(fmt::format("plate one cell thick, nu {}", nu), {16, 12, 1}, isotropic(nu), "bend");
  for (const double nu : {0.3, 0.45}) {
    kinds.box(fmt::format("strip one cell thick, nu {}", nu), {16, 4, 1}, isotropic(nu), "plane bend");
    kinds.box(fmt::format("plate one cell thick, nu {}", nu), {16, 16, 1}, isotropic(nu, "1 MPa"), "gravity");
    kinds.box(fmt::format("plate two cells thick, nu {}", nu), {16, 16, 2}, isotropic(nu), "bend");
  }
}

void add_fibres(SceneMaker& kinds) {
  kinds.box("fibres 50:1 at 30 deg", {12, 8, 8}, fibres(50, 30), "pull");
  kinds.box("fibres 50:1 at 45 deg", {12, 8, 8}, fibres(50, 45), "bend");
  kinds.box("fibres 20:1 at 60 deg", {12, 8, 8}, fibres(20, 60), "shear");
  kinds.box("fibres 20:1, thin", {16, 8, 2}, fibres(20, 20), "pull");
  kinds.box("muscle/strongly_anisotropic", {12, 8, 8}, "\"muscle/strongly_anisotropic\"", "poke");
}

void add_layers(SceneMaker& kinds) {
  kinds.image(body_under_skin(), {"poke", "shear", "bend"});
  kinds.image(body_with_soft_seam(), {"pull"});
  kinds.image(checkerboard(), {"shear"});
  kinds.image(gel_with_stiff_sheet(), {"bend"});
  kinds.image(shell_around_gel(), {"shear"});
  kinds.image(body_like_an_l(), {"pull"});
}

void add_muscles(SceneMaker& kinds) {
  const int s = kinds.scale();
  kinds.add(
      "belly with tendons, pulled",
      fmt::format(
          "[specimen]\nshape = \"muscle\"\ncells = [{}, {}, {}]\nspacing = \"{} mm\"\nmaterial = "
          "\"muscle/soleus\"\ntendon = {{ material = \"tendon/tibialis_anterior\", fraction = 0.15 }}\n",
          16 * s, 8 * s, 8 * s, 1.0 / s) +
          action("pull", {16, 8, 8}));
  if (const char* data = std::getenv("MAILLE_DATA"); !data || !*data)
    return;
  const std::array<int, 3> blocks = s == 1 ? std::array{2, 2, 1} : std::array{1, 1, 1};
  const std::string moved_end = held("z-") + moved("z+", 0, 0, 7);
  // Constants of their own: the library's muscles have limits, which would bind.
  const std::string pulp =
      "{ E_fibre = \"200 kPa\", E_cross = \"10 kPa\", G_fibre = \"4 kPa\", nu_fibre = 0.3, nu_cross = 0.4 }";
  kinds.add("muscle 17 of a calf from MRI, pulled", calf_muscle(17, "\"muscle/soleus\"", blocks) + moved_end);
  kinds.add("muscle 24 of a calf from MRI, fibres 20:1, pulled", calf_muscle(24, pulp, blocks) + moved_end);
  kinds.add("muscle 19 of a calf from MRI, gravity", calf_muscle(19, isotropic(0.45, "50 kPa"), blocks) +
                                                         held("z-") + "[[load]]\ngravity = [1, 0, 0]\n");
  kinds.add("head from CT, pressed",
            head(300, isotropic(0.3, "1 MPa"), 8 / s) + held("z-") + moved("z+", 0, 0, -1));
}

} // namespace

SceneSet kind_scenes(int scale) {
  return SceneSet("maille_kinds", scale, [](SceneMaker& kinds) {
    add_boxes(kinds);
    add_plates(kinds);
    add_fibres(kinds);
    add_layers(kinds);
    add_muscles(kinds);
  });
}

} // namespace maille::lab
