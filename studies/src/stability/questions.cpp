#include "stability/questions.hpp"

#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

namespace maille::studies {

std::string Question::text() const {
  std::string text = fmt::format(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = {}\nspacing = {}\nmaterial = {}\n", cells,
      spacing, material);
  if (!fibre.empty())
    text += "fibre = " + fibre + "\n";
  text += conditions;
  if (!limits.empty())
    text += "[limits]\n" + limits;
  if (!relaxation.empty())
    text += "[relaxation]\n" + relaxation;
  return text;
}

Scene Question::scene() const {
  return parse_scene(text(), "extreme.toml");
}

std::string given_limits(double stretch, double compress, double shear) {
  return fmt::format("from = \"given\"\nstretch = {}\ncompress = {}\nshear = {}\n", stretch, compress, shear);
}

std::string pulled(int dimension, int axis, double by) {
  std::string text;
  for (int a = 0; a < dimension; ++a)
    text += fmt::format("[[hold]]\nwhere = \"{0}-\"\naxes = \"{0}\"\n", "xyz"[a]);
  Vec3 shift{};
  shift[static_cast<std::size_t>(axis)] = by;
  text += fmt::format("[[move]]\nwhere = \"{0}+\"\naxes = \"{0}\"\nby = [", "xyz"[axis]);
  for (int a = 0; a < dimension; ++a)
    text += fmt::format("{}{}", a > 0 ? ", " : "", shift[static_cast<std::size_t>(a)]);
  return text + "]\n";
}

std::string clamped(const std::string& by) {
  return "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = " + by + "\n";
}

std::string poked(const Vec3& spacing, double depth) {
  return fmt::format("[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = {{ box = [[{}, {}, {}], [{}, {}, {}]] }}\n"
                     "by = [0, 0, {}]\n",
                     2.5 * spacing[0], 2.5 * spacing[1], 8 * spacing[2], 5.5 * spacing[0], 5.5 * spacing[1],
                     8 * spacing[2], -depth);
}

std::string moved_node(const Vec3& position, const Vec3& by) {
  return fmt::format(
      "[[move]]\nwhere = {{ box = [[{0}, {1}, {2}], [{0}, {1}, {2}]] }}\nby = [{3}, {4}, {5}]\n", position[0],
      position[1], position[2], by[0], by[1], by[2]);
}

} // namespace maille::studies
