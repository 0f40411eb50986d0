

#include "stability/questions.hpp"

#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <numeric>

namespace maille::lab {

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

namespace {

bool is_elastic(std::string_view method) {
  return method == "coupled" || method.starts_with("fem");
}

/// Every component of every node of the body from where it rests.
template<class At>
Displacement displacement_of(const Scene& scene, const At& at) {
  Displacement u(scene.specimen.grid);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 place = grid.node_at(node);
    if (!scene.specimen.is_node(place))
      continue;
    const Vec3 value = at(place);
    for (int b = 0; b < grid.dimension(); ++b)
      u(b, node) = value[static_cast<std::size_t>(b)];
  }
  return u;
}

} // namespace

Truth uniform_strain(const Vec3& strain, int axis) {
  return [=](const Scene& scene, std::string_view method) {
    return displacement_of(scene, [&](const Index3& node) {
      const Vec3 x = scene.specimen.position(node);
      Vec3 u{};
      for (std::size_t b = 0; b < 3; ++b)
        u[b] = is_elastic(method) || static_cast<int>(b) == axis ? strain[b] * x[b] : 0;
      return u;
    });
  };
}

Truth in_series(const std::vector<double>& stiffness, double by) {
  return [=](const Scene& scene, std::string_view) {
    std::vector<double> sum{0};
    for (const double k : stiffness)
      sum.push_back(sum.back() + 1 / k);
    return displacement_of(scene, [&](const Index3& node) {
      return Vec3{by * sum[static_cast<std::size_t>(node[0])] / sum.back(), 0, 0};
    });
  };
}

Truth shift(const Vec3& by, bool has_slack) {
  return [=](const Scene& scene, std::string_view method) -> std::optional<Displacement> {
    if (has_slack && !is_elastic(method) && method != "relaxed")
      return std::nullopt;
    return displacement_of(scene, [&](const Index3&) { return by; });
  };
}

Truth rigid_turn() {
  return [](const Scene& scene, std::string_view) {
    return displacement_of(scene, [&](const Index3& node) {
      return scene.turns[0].displacement(scene.specimen.position(node));
    });
  };
}

} // namespace maille::lab
