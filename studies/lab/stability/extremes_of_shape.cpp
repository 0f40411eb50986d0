#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

constexpr double strain = 0.01, nu = 0.3;

/// A box pulled along an axis, with its truth.
Extreme pull(std::string extreme, std::string setting, std::vector<int> cells, const Vec3& spacing,
             int axis) {
  const int dimension = static_cast<int>(cells.size());
  std::string counts, lengths;
  for (std::size_t a = 0; a < cells.size(); ++a) {
    counts += fmt::format("{}{}", a > 0 ? ", " : "", cells[a]);
    lengths += fmt::format("{}{}", a > 0 ? ", " : "", spacing[a]);
  }
  const auto along = static_cast<std::size_t>(axis);
  Vec3 strains{-nu * strain, -nu * strain, -nu * strain};
  strains[along] = strain;
  if (dimension == 2)
    strains[1] *= 1 / (1 - nu); // plane strain
  const double by = strain * spacing[along] * cells[along];
  return {.extreme = std::move(extreme),
          .setting = std::move(setting),
          .scene =
              [=] {
                return Question{.cells = "[" + counts + "]",
                                .spacing = "[" + lengths + "]",
                                .conditions = pulled(dimension, axis, by)}
                    .scene();
              },
          .truth = uniform_strain(strains, axis)};
}

Extreme plain(std::string extreme, std::string setting, const Question& question) {
  return {.extreme = std::move(extreme), .setting = std::move(setting), .scene = [=] {
            return question.scene();
          }};
}

/// Marks the first of an extreme as the normal setting.
Extreme normal(Extreme one) {
  one.is_normal = true;
  return one;
}

void add_spacing_ratios(std::vector<Extreme>& list) {
  for (const bool pushed : {false, true})
    for (const double ratio : {1.0, 10.0, 100.0, 1000.0})
      for (const bool is_long : {false, true}) {
        if (ratio == 1 && is_long)
          continue;
        const Vec3 spacing{1e-3, 1e-3, is_long ? 1e-3 * ratio : 1e-3 / ratio};
        const std::string extreme = pushed ? "spacing ratio, poked" : "spacing ratio, pulled";
        const std::string setting = fmt::format("1:{:g}, {}", ratio,
                                                ratio == 1 ? "normal"
                                                : is_long  ? "long along z"
                                                           : "short along z");
        Extreme one = pushed ? plain(extreme, setting,
                                     {.spacing = fmt::format("[0.001, 0.001, {}]", spacing[2]),
                                      .conditions = poked(spacing, 0.5 * spacing[2])})
                             : pull(extreme, setting, {6, 6, 6}, spacing, 0);
        list.push_back(ratio == 1 ? normal(one) : one);
      }
}

void add_thin_bodies(std::vector<Extreme>& list, int long_body) {
  constexpr Vec3 h{1e-3, 1e-3, 1e-3};
  constexpr const char* thin = "one cell thick";
  list.push_back(normal(pull(thin, "normal: 8 x 8 x 8, pulled", {8, 8, 8}, h, 0)));
  list.push_back(pull(thin, "24 x 24 x 1, pulled", {24, 24, 1}, h, 0));
  list.push_back(pull(thin, "1 x 24 x 24, pulled along x", {1, 24, 24}, h, 0));
  list.push_back(pull(thin, "2D, 32 x 1, pulled", {32, 1}, h, 0));
  list.push_back(plain(thin, "24 x 24 x 1, one end lifted",
                       {.cells = "[24, 24, 1]", .conditions = clamped("[0, 0, 0.002]")}));
  list.push_back(plain(thin, "32 x 1 x 1, one end lifted",
                       {.cells = "[32, 1, 1]", .conditions = clamped("[0, 0, 0.004]")}));
  const char* const extreme = "long bodies of 1 x 1 cells";
  list.push_back(normal(pull(extreme, "normal: 8 x 8 x 8, pulled", {8, 8, 8}, h, 2)));
  list.push_back(
      pull(extreme, fmt::format("1 x 1 x {}, pulled along z", long_body), {1, 1, long_body}, h, 2));
  list.push_back(pull(extreme, fmt::format("1D, {} cells, pulled", long_body), {long_body}, h, 0));
}

void add_single_cells(std::vector<Extreme>& list) {
  constexpr Vec3 h{1e-3, 1e-3, 1e-3};
  constexpr const char* extreme = "a single cell";
  list.push_back(normal(pull(extreme, "normal: 8 x 8 x 8, pulled", {8, 8, 8}, h, 0)));
  list.push_back(pull(extreme, "1D, pulled", {1}, h, 0));
  list.push_back(pull(extreme, "2D, pulled", {1, 1}, h, 0));
  list.push_back(pull(extreme, "3D, pulled", {1, 1, 1}, h, 0));
  list.push_back(plain(extreme, "3D, every node prescribed",
                       {.cells = "[1, 1, 1]", .conditions = clamped("[0.0001, 0, 0.0001]")}));
}

/// A box of 8 x 8 x 8 cells, held below and moved above, of which only some cells are matter.
template<class IsMatter>
Extreme carved(std::string setting, const std::string& conditions, const IsMatter& is_matter) {
  return {.extreme = "islands and one-node bridges", .setting = std::move(setting), .scene = [=] {
            Scene scene = Question{.conditions = conditions}.scene();
            Specimen& body = scene.specimen;
            for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
              body.material_id.push_back(is_matter(body.grid.cell_at(cell)) ? std::uint8_t{0} : no_material);
            std::erase_if(scene.prescribed,
                          [&](const Prescribed& p) { return !body.is_node(body.grid.node_at(p.node)); });
            return scene;
          }};
}

void add_carved_bodies(std::vector<Extreme>& list) {
  const std::string ends = "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [0.0001, 0, 0.0002]\n";
  list.push_back(normal(carved("normal: a whole box", ends, [](const Index3&) { return true; })));
  list.push_back(
      carved("two islands, one held, one moved", ends, [](const Index3& c) { return c[2] < 3 || c[2] > 4; }));
  list.push_back(carved("an island that nothing holds", ends, [](const Index3& c) {
    return c[2] < 2 || c[2] > 5 || (c[0] == 4 && c[1] == 4 && c[2] == 4);
  }));
  list.push_back(carved("two blocks that share a node", ends, [](const Index3& c) {
    return (c[0] < 4) == (c[2] < 4) && (c[1] < 4) == (c[2] < 4);
  }));
  list.push_back(carved("two blocks that share an edge", ends,
                        [](const Index3& c) { return (c[0] < 4) == (c[2] < 4); }));
  list.push_back(carved("a bridge of one cell", ends,
                        [](const Index3& c) { return c[2] < 3 || c[2] > 4 || (c[0] == 4 && c[1] == 4); }));
  list.push_back(carved("cells that share only edges and corners", ends, [](const Index3& c) {
    return c[2] == 0 || c[2] == 7 || (c[0] + c[1] + c[2]) % 2 == 0;
  }));
}

} // namespace

void add_extremes_of_shape(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  add_spacing_ratios(list);
  add_thin_bodies(list, sizes.long_body);
  add_single_cells(list);
  add_carved_bodies(list);
}

} // namespace maille::lab
