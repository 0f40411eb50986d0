#include "bench/studies/scene_maker.hpp"

#include <fmt/format.h>

#include <cmath>

namespace maille::lab {

double UnseenScenes::on_logarithm(double low, double high) {
  return std::exp(between(std::log(low), std::log(high)));
}

std::string UnseenScenes::draw_material(std::string& words) {
  if (whole(0, 1) == 0) {
    const double nu = between(0, 0.49), E = on_logarithm(1, 100);
    words = fmt::format("isotropic, nu {:.2f}", nu);
    return fmt::format("{{ youngs_modulus = \"{:.4g} kPa\", poisson_ratio = {:.3f} }}", E, nu);
  }
  const double ratio = between(1, 20), E = on_logarithm(1, 50), angle = between(0, 90);
  words = fmt::format("fibres {:.1f} times as stiff, {:.0f} deg", ratio, angle);
  return fmt::format(
      "{{ E_fibre = \"{:.4g} kPa\", E_cross = \"{:.4g} kPa\", G_fibre = \"{:.4g} kPa\", nu_fibre = "
      "{:.3f}, nu_cross = {:.3f} }}\nfibre = {{ angle = \"{:.1f} deg\", plane = \"xz\" }}",
      ratio * E, E, E * between(0.25, 0.5), between(0.2, 0.4), between(0.2, 0.45), angle);
}

std::string UnseenScenes::draw_load(const std::string& shape, const int (&cells)[3], std::string& words) {
  const double length = cells[0];
  const int kind = whole(0, shape == "box" ? 2 : 1);
  if (kind == 0) {
    words = "pull";
    return fmt::format("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"{:.4g} mm\", 0, 0]\n",
                       length * between(0.02, 0.1));
  }
  if (kind == 1) {
    words = "bend";
    return fmt::format("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [0, 0, \"{:.4g} mm\"]\n",
                       length * between(0.02, 0.1));
  }
  words = "poke";
  double low[2], high[2];
  for (int a = 0; a < 2; ++a) { // a patch of a fifth to a half of the side, away from the rim
    const double side = cells[a] * between(0.2, 0.5), room = cells[a] * 0.9 - side;
    low[a] = cells[a] * 0.05 + room * between(0.2, 0.8);
    high[a] = low[a] + side;
  }
  return fmt::format(
      "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = {{ box = [[\"{:.3f} mm\", \"{:.3f} mm\", \"{} "
      "mm\"], [\"{:.3f} mm\", \"{:.3f} mm\", \"{} mm\"]] }}\nby = [0, 0, \"{:.4g} mm\"]\n",
      low[0], low[1], cells[2], high[0], high[1], cells[2], -cells[2] * between(0.03, 0.15));
}

UnseenScene UnseenScenes::draw() {
  UnseenScene scene;
  const int lot = whole(0, 3);
  scene.shape = lot < 2 ? "box" : lot == 2 ? "ellipsoid" : "muscle";
  int cells[3];
  // Geometric multigrid, which makes references of large boxes cheap, wants cells that can be halved.
  const bool is_even = whole(0, 3) > 0;
  for (int& n : cells)
    n = scene.shape != "box" ? whole(8, 12) : is_even ? 4 * whole(2, whole(0, 5) == 0 ? 8 : 4) : whole(8, 12);
  if (scene.shape == "muscle")
    cells[0] = whole(16, 24);
  const std::string material = draw_material(scene.material),
                    load = draw_load(scene.shape, cells, scene.load);
  scene.text = fmt::format("units = \"m, rad\"\n[specimen]\nshape = \"{}\"\ncells = [{}, {}, {}]\nspacing = "
                           "\"1 mm\"\nmaterial = {}\n",
                           scene.shape, cells[0], cells[1], cells[2], material);
  if (scene.shape == "muscle")
    scene.text +=
        fmt::format("tendon = {{ material = {{ youngs_modulus = \"{:.4g} kPa\", poisson_ratio = 0.35 }}, "
                    "fraction = {:.2f} }}\n",
                    on_logarithm(100, 2000), between(0.08, 0.2));
  scene.text += load;
  scene.error = on_logarithm(0.015, 0.4);
  scene.seconds = on_logarithm(0.3e-3, 0.3);
  return scene;
}

} // namespace maille::lab
