#include "checks/random_scene.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::lab {

namespace {

/// One slack of a link, over its rest length.
double random_slack(Choices& choices) {
  switch (choices.below(8)) {
  case 1:
    return 0;
  case 2:
    return 1e-6;
  case 3:
    return 1e6;
  default:
    return 0.01 + 0.5 * choices.uniform();
  }
}

NeighbourLimits random_limits(Choices& choices) {
  NeighbourLimits limits;
  for (std::size_t a = 0; a < 3; ++a) {
    limits.stretch[a] = 1 + random_slack(choices);
    limits.compress[a] = 1 - std::min(1.0, random_slack(choices));
    for (std::size_t b = 0; b < 3; ++b)
      limits.shear[a][b] = a == b ? 0 : random_slack(choices);
  }
  return limits;
}

ElasticConstants random_elasticity(Choices& choices) {
  const double E = 10e3 * choices.one_of(std::array{1.0, 2.0, 1e3, 1e6, 1e-3});
  if (!choices.is_one_in(3))
    return ElasticConstants::isotropic(E, choices.one_of(std::array{0.3, 0.0, 0.45, 0.499, -0.5}));
  // |nu_fibre| < sqrt(E_fibre / E_cross), and nu_cross is kept small: valid for all of these ratios.
  const double ratio = choices.one_of(std::array{2.0, 10.0, 1e3});
  return ElasticConstants::transversely_isotropic(ratio * E, E, E * choices.one_of(std::array{0.4, 0.05}),
                                                  choices.one_of(std::array{0.3, 0.0, 0.45}), 0.2);
}

Vec3 random_direction(Choices& choices, int dimension) {
  Vec3 f{1, 0, 0};
  for (int a = 0; a < dimension; ++a)
    f[static_cast<std::size_t>(a)] += choices.uniform() - (a == 0 ? 0 : 0.5);
  const double length = std::hypot(f[0], f[1], f[2]);
  return {f[0] / length, f[1] / length, f[2] / length};
}

void choose_body(Choices& choices, Scene& scene) {
  const int dimension = 1 + choices.below(3);
  const int most = std::array{24, 6, 4}[static_cast<std::size_t>(dimension - 1)];
  Index3 cells{1, 1, 1};
  Vec3 spacing{1e-3, 1e-3, 1e-3};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a) {
    cells[a] = 1 + choices.below(most);
    spacing[a] *= choices.is_one_in(4) ? 1 + choices.uniform() : 1;
  }
  if (choices.is_one_in(12))
    spacing[static_cast<std::size_t>(choices.below(dimension))] *= 1000;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(dimension, cells, spacing);
}

void choose_matter(Choices& choices, Scene& scene) {
  Specimen& body = scene.specimen;
  const int n_materials = 1 + choices.below(3);
  for (int i = 0; i < n_materials; ++i) {
    Material material;
    material.name = fmt::format("matter {}", i);
    material.elasticity = random_elasticity(choices);
    scene.materials.push_back(material);
  }
  const bool has_holes = choices.is_one_in(3);
  if (n_materials > 1 || has_holes) {
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
      body.material_id.push_back(has_holes && choices.is_one_in(4)
                                     ? no_material
                                     : static_cast<std::uint8_t>(choices.below(n_materials)));
    if (body.n_matter_cells() == 0)
      body.material_id[0] = 0;
  }
  if (choices.is_one_in(2))
    body.fibre = random_direction(choices, scene.dimension());
  if (choices.is_one_in(8))
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
      const Vec3 f = random_direction(choices, scene.dimension());
      body.fibres.push_back({static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2])});
    }
  if (scene.dimension() == 2 && choices.is_one_in(2))
    scene.plane = PlaneAssumption::stress;
}

/// @pre the materials are chosen
void choose_limits(Choices& choices, Scene& scene) {
  scene.limits.from = choices.one_of(
      std::array{LimitSource::given, LimitSource::taut, LimitSource::material, LimitSource::none});
  if (scene.limits.from == LimitSource::given)
    scene.limits.given = random_limits(choices);
  // Without [limits] materials may have some, which bind methods of limits alone.
  if (scene.limits.from == LimitSource::material ||
      (scene.limits.from == LimitSource::none && choices.is_one_in(2)))
    for (Material& material : scene.materials)
      material.limits = random_limits(choices);
}

/// Prescribed components, the last word counts where two speak of one.
class Conditions {
public:
  explicit Conditions(Scene& scene) : scene_(scene) {}
  ~Conditions() {
    for (const auto& [place, p] : all_)
      scene_.prescribed.push_back(p);
  }
  Conditions(const Conditions&) = delete;
  Conditions& operator=(const Conditions&) = delete;

  void add(std::int64_t node, int component, double value, bool held) {
    all_[{component, node}] = {node, component, held ? 0 : value, held};
  }

private:
  Scene& scene_;
  std::map<std::pair<int, std::int64_t>, Prescribed> all_;
};

std::vector<std::int64_t> nodes_of(const Specimen& body) {
  std::vector<std::int64_t> nodes;
  for (std::int64_t n = 0; n < body.grid.n_nodes(); ++n)
    if (body.is_node(body.grid.node_at(n)))
      nodes.push_back(n);
  return nodes;
}

/// A face of the grid, or a node.
std::vector<std::int64_t> random_region(Choices& choices, const Specimen& body,
                                        const std::vector<std::int64_t>& nodes) {
  if (choices.is_one_in(2))
    return {nodes[static_cast<std::size_t>(choices.below(static_cast<int>(nodes.size())))]};
  const auto axis = static_cast<std::size_t>(choices.below(body.grid.dimension()));
  const int at = choices.is_one_in(2) ? body.grid.nodes()[axis] - 1 : 0;
  std::vector<std::int64_t> face;
  for (const std::int64_t n : nodes)
    if (body.grid.node_at(n)[axis] == at)
      face.push_back(n);
  return face;
}

void choose_conditions(Choices& choices, Scene& scene) {
  Conditions conditions(scene);
  const std::vector<std::int64_t> nodes = nodes_of(scene.specimen);
  const double size = scene.specimen.grid.spacing()[0] * choices.one_of(std::array{0.1, 0.5, 3.0, 1e-6, 1e4});
  const int n_holds = choices.below(3), n_moves = 1 + choices.below(3);
  for (int i = 0; i < n_holds + n_moves; ++i) {
    const bool held = i < n_holds;
    const bool all_components = !choices.is_one_in(3);
    const int only = choices.below(scene.dimension());
    Vec3 by{};
    for (int b = 0; b < scene.dimension() && !held; ++b)
      by[static_cast<std::size_t>(b)] = size * (1 - 2 * choices.uniform());
    for (const std::int64_t node : random_region(choices, scene.specimen, nodes))
      for (int b = 0; b < scene.dimension(); ++b)
        if (all_components || b == only)
          conditions.add(node, b, by[static_cast<std::size_t>(b)], held);
  }
}

void choose_loads(Choices& choices, Scene& scene) {
  if (!choices.is_one_in(8))
    return;
  for (int a = 0; a < scene.dimension(); ++a)
    scene.gravity[static_cast<std::size_t>(a)] = 10 * (1 - 2 * choices.uniform());
  if (choices.is_one_in(2))
    scene.active_stress.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()),
                               100 * choices.uniform());
}

/// Images are stored along any axes, and scanners lie oblique to them.
void choose_placement(Choices& choices, Scene& scene) {
  if (scene.dimension() < 3 || !choices.is_one_in(3))
    return;
  Eigen::Matrix3d direction = Eigen::Matrix3d::Zero();
  const int first = choices.below(3), second = (first + 1 + choices.below(2)) % 3;
  const int axes[] = {first, second, 3 - first - second};
  for (int a = 0; a < 3; ++a)
    direction(axes[a], a) = choices.is_one_in(2) ? 1 : -1;
  if (choices.is_one_in(3))
    direction = Eigen::AngleAxisd(choices.uniform(), Eigen::Vector3d(1, 2, 3).normalized()) * direction;
  Placement& placement = scene.specimen.placement;
  for (std::size_t a = 0; a < 3; ++a) {
    placement.origin[a] = 0.1 * choices.uniform();
    for (std::size_t b = 0; b < 3; ++b)
      placement.direction[a][b] = direction(static_cast<int>(a), static_cast<int>(b));
  }
}

} // namespace

Scene random_scene(Choices& choices) {
  Scene scene;
  scene.name = scene.title = "random";
  choose_body(choices, scene);
  choose_matter(choices, scene);
  choose_limits(choices, scene);
  choose_conditions(choices, scene);
  choose_loads(choices, scene);
  scene.relaxation.tolerance = choices.one_of(std::array{1e-4, 1e-2, 1e-6});
  scene.relaxation.sweeps = 200;
  if (choices.is_one_in(6))
    scene.relaxation.mode = RelaxationMode::deformable;
  if (choices.is_one_in(8))
    scene.relaxation.extrapolation = Extrapolation::nested;
  choose_placement(choices, scene);
  return scene;
}

std::string in_words(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  std::string text =
      fmt::format("{}D, cells {}, spacing {} m, {} of {} cells are matter, limits {}, {}\n", grid.dimension(),
                  grid.cells(), grid.spacing(), scene.specimen.n_matter_cells(), grid.n_cells(),
                  scene.limits.from == LimitSource::given  ? "given"
                  : scene.limits.from == LimitSource::taut ? "taut"
                  : scene.limits.from == LimitSource::none ? "not asked for"
                                                           : "of the materials",
                  scene.has_loads() ? "loads" : "no loads");
  if (scene.limits.from == LimitSource::given)
    text += fmt::format("  stretch {}, compress {}, shear {}\n", scene.limits.given.stretch,
                        scene.limits.given.compress, scene.limits.given.shear);
  for (const Material& m : scene.materials)
    text += fmt::format("  {}: E {} Pa, nu {} {} {}, G {} {} {} Pa\n", m.name, m.elasticity.youngs_modulus,
                        m.elasticity.nu12, m.elasticity.nu13, m.elasticity.nu23, m.elasticity.G12,
                        m.elasticity.G13, m.elasticity.G23);
  constexpr std::size_t most = 12;
  for (std::size_t i = 0; i < std::min(most, scene.prescribed.size()); ++i) {
    const Prescribed& p = scene.prescribed[i];
    text += fmt::format("  node {} {} along {} by {} m\n", grid.node_at(p.node), p.held ? "held" : "moved",
                        "xyz"[p.component], p.value);
  }
  if (scene.prescribed.size() > most)
    text += fmt::format("  and {} more\n", scene.prescribed.size() - most);
  return text;
}

} // namespace maille::lab
