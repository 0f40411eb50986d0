/// The multigrid of a box some of whose links are stiffer than its matter.

#include "elastic/box/box_solver.hpp"
#include "elastic/box/box_system.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace maille::deform {
namespace {

/// A block held at its foot, its top held along two axes.
Scene held_block(Index3 cells) {
  Scene scene = test::box_scene(3, cells);
  test::hold_face(scene, 2, false);
  test::prescribe_face(scene, 2, true, 0, 0, false);
  test::prescribe_face(scene, 2, true, 1, 0, false);
  return scene;
}

class PenaltyBlock {
public:
  explicit PenaltyBlock(const Scene& scene)
      : scene_(scene),
        elasticity_(scene), task_{scene, control_, scene.prescribed, team_, clock_, [] { return false; }}, solver_(task_),
        system_(solver_.multigrid(), solver_.unit()), is_fixed_(3) {
    for (auto& component : is_fixed_)
      component.assign(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), false);
    for (const Prescribed& p : scene.prescribed)
      is_fixed_[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  }

  BoxSystem& system() { return system_; }
  BoxSolver& solver() { return solver_; }
  bool is_fixed(std::size_t b, std::size_t i) const { return is_fixed_[b][i]; }

  /// (K + links) u where nodes may move, cell by cell and link by link.
  Displacement apply(const Displacement& u, const List<PenaltyLink>& links) {
    const Grid& grid = scene_.specimen.grid;
    Displacement forces(grid);
    elasticity_.apply(u, forces, team_);
    for (const PenaltyLink& link : links) {
      const std::int64_t far = link.node + grid.stride(link.axis);
      const double force = link.stiffness * (u(link.component, link.node) - u(link.component, far));
      forces(link.component, link.node) += force;
      forces(link.component, far) -= force;
    }
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < forces.n_nodes(); ++i)
        if (is_fixed_[b][i])
          forces(b, i) = 0;
    return forces;
  }

  Displacement random_forces(unsigned seed) {
    std::mt19937 random(seed);
    Displacement forces(scene_.specimen.grid);
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < forces.n_nodes(); ++i)
        forces(b, i) = is_fixed_[b][i] ? 0 : static_cast<double>(random() % 2001) / 1000 - 1;
    return forces;
  }

  /// Links between the columns of a ring about the middle of the upper half, as about a poke: of z, across
  /// it.
  List<PenaltyLink> ring(double stiffness) const {
    const Grid& grid = scene_.specimen.grid;
    List<PenaltyLink> links;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      const int half = grid.cells()[0] / 2,
                distance = std::max(std::abs(at[0] - half), std::abs(at[1] - half));
      for (int axis = 0; axis < 2; ++axis)
        if (at[static_cast<std::size_t>(axis)] < grid.cells()[static_cast<std::size_t>(axis)] &&
            at[2] > grid.cells()[2] / 2 && distance >= half / 4 && distance <= half / 2)
          links.push_back({2, axis, node, stiffness});
    }
    return links;
  }

private:
  const Scene& scene_;
  ThreadTeam team_{1};
  Control control_;
  Clock clock_;
  LatticeElasticity elasticity_;
  CoupledTask task_;
  BoxSolver solver_;
  BoxSystem system_;
  std::vector<std::vector<bool>> is_fixed_;
};

/// @return iterations until the preconditioned residual is a ten thousandth; the operator is the one made of
///         cells and links
int iterations(PenaltyBlock& block, const List<PenaltyLink>& links) {
  Displacement r = block.random_forces(1), z = r, p = r;
  double first = 0, last = 0;
  for (int i = 0; i < 200; ++i) {
    const double now = block.system().precondition(r, z);
    EXPECT_NEAR(now, test::product(r, z), 1e-5 * std::abs(now)) << i;
    first = i == 0 ? now : first;
    if (now <= 1e-8 * first)
      return i;
    const double beta = i > 0 ? now / last : 0;
    last = now;
    for (std::size_t k = 0; k < p.values().size(); ++k)
      p.values()[k] = z.values()[k] + (i > 0 ? beta * p.values()[k] : 0);
    const Displacement q = block.apply(p, links);
    const double step = now / test::product(p, q);
    for (std::size_t k = 0; k < r.values().size(); ++k)
      r.values()[k] -= step * q.values()[k];
  }
  return 200;
}

/// The truth is the operator made of cells and links one by one; measured 6 iterations and 10, and 30 if the
/// multigrid is not told.
TEST(BoxPenaltiesOracle, TheCycleSolvesForPenalizedLinksToo) {
  for (const Index3& cells : {Index3{16, 16, 16}, Index3{17, 12, 9}}) {
    const Scene scene = held_block(cells);
    PenaltyBlock block(scene);
    const double own = scene.cell_stiffness(0)(3, 3) * 1e-3; // of a link [N/m]: shear modulus times spacing
    for (const auto& [times, most] : {std::pair(10.0, 8), std::pair(100.0, 14)}) {
      const auto links = block.ring(times * own);
      ASSERT_GT(links.size(), 50u);
      block.system().set_penalties({});
      const int without = iterations(block, links);
      block.system().set_penalties(links);
      const int with = iterations(block, links);
      EXPECT_LE(with, most) << times;
      EXPECT_LT(times == 100 ? 2 * with : with, without) << times;
    }
  }
}

/// Products of a stored direction by one cycle and by conjugate gradients, whose steps give its product with
/// the first residual.
TEST(BoxPenaltiesOracle, ProductsOfAKeptDirectionAreSumsOverItsNodes) {
  const Scene scene = held_block({17, 12, 9});
  PenaltyBlock block(scene);
  const double own = scene.cell_stiffness(0)(3, 3) * 1e-3;
  block.system().set_penalties(block.ring(100 * own));
  const Displacement residual = block.random_forces(3);
  for (const int most : {1, 4}) {
    const auto found = block.system().keep_direction(residual, most, 1e-9, [] { return false; });
    EXPECT_EQ(found.iterations, most);
    Displacement direction = residual;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < direction.n_nodes(); ++i)
        direction(b, i) = block.is_fixed(b, i) ? 0 : block.system().kept(static_cast<int>(b), i);
    const double descent = test::product(direction, residual), length = test::product(direction, direction),
                 curvature = test::product(direction, block.apply(direction, {}));
    EXPECT_NEAR(found.products.descent, descent, 1e-4 * descent) << most;
    EXPECT_NEAR(found.products.length, length, 1e-5 * length) << most;
    EXPECT_NEAR(found.products.curvature, curvature, 1e-4 * curvature) << most;
  }
}

TEST(BoxPenaltiesContract, LinksAreForgottenWhenOthersArePenalized) {
  const Scene scene = held_block({9, 8, 7});
  PenaltyBlock block(scene);
  const Displacement forces = block.random_forces(2);
  Displacement before = forces, after = forces;
  block.system().precondition(forces, before);
  block.system().set_penalties(block.ring(1e3));
  block.system().precondition(forces, after);
  EXPECT_NE(after, before);
  block.system().set_penalties({});
  block.system().precondition(forces, after);
  EXPECT_EQ(after, before);
}

/// Of displacements linear along an axis every link along it stores the same energy: stiffness / 2 times its
/// length squared.
TEST(BoxPenaltiesAnalytic, CoarseLinksKeepTheEnergyOfLinearDisplacements) {
  const Scene scene = held_block({8, 12, 16});
  PenaltyBlock block(scene);
  const BoxLevel& level = block.solver().multigrid().finest();
  for (int axis = 0; axis < 3; ++axis) {
    List<PenaltyLink> links;
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      if (scene.specimen.grid.node_at(node)[static_cast<std::size_t>(axis)] <
          scene.specimen.grid.cells()[static_cast<std::size_t>(axis)])
        links.push_back({1, axis, node, 3});
    double fine = 0, coarse = 0;
    for (const PenaltyLink& link : links)
      fine += link.stiffness;
    for (const PenaltyLink& link : level.coarse_links(links)) {
      EXPECT_EQ(link.axis, axis);
      coarse += link.stiffness * 4; // twice as long
    }
    EXPECT_NEAR(coarse, fine, 1e-9 * fine);
  }
}

/// The multigrid of a body of any shape some of whose links are stiffer than its matter.

/// Held at its foot; a slot through the upper half, a stiffer quarter, spacings of their own.
Scene slotted_block() {
  Scene scene = test::box_scene(3, {14, 12, 10}, {1e-3, 1.2e-3, 0.9e-3});
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(100e3, 0.3);
  const Grid& grid = scene.specimen.grid;
  scene.specimen.material_id.assign(static_cast<std::size_t>(grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    scene.specimen.material_id[static_cast<std::size_t>(cell)] =
        at[0] == 7 && at[2] > 4 ? no_material : static_cast<std::uint8_t>(at[0] < 4 && at[1] < 4 ? 1 : 0);
  }
  test::hold_face(scene, 2, false);
  return scene;
}

class PenalizedBody {
public:
  explicit PenalizedBody(const Scene& scene)
      : scene_(scene), task_{scene, control_, scene.prescribed, team_, clock_, [] { return false; }}, solver_(task_),
        system_(scene.specimen.grid, solver_.elasticity(), solver_.multigrid(), team_) {}

  MaskedSystem& system() { return system_; }

  /// (K + links) u where nodes may move, cell by cell and link by link.
  Displacement apply(const Displacement& u, const List<PenaltyLink>& links) {
    Displacement forces(scene_.specimen.grid);
    solver_.elasticity().apply(u, forces, team_);
    for (const PenaltyLink& link : links) {
      const std::int64_t far = link.node + scene_.specimen.grid.stride(link.axis);
      const double force = link.stiffness * (u(link.component, link.node) - u(link.component, far));
      forces(link.component, link.node) += force;
      forces(link.component, far) -= force;
    }
    return without_fixed(std::move(forces));
  }
  Displacement random_forces() {
    std::mt19937 random(3);
    Displacement forces(scene_.specimen.grid);
    for (int b = 0; b < 3; ++b)
      for (std::int64_t node = 0; node < scene_.specimen.grid.n_nodes(); ++node)
        forces(b, node) = scene_.specimen.is_node(scene_.specimen.grid.node_at(node))
                              ? static_cast<double>(random() % 2001) / 1000 - 1
                              : 0;
    return without_fixed(std::move(forces));
  }
  /// All links of matter along two axes in some layers.
  List<PenaltyLink> layers(double stiffness) const {
    const LinkLimits limits(scene_);
    List<PenaltyLink> links;
    for (std::int64_t node = 0; node < scene_.specimen.grid.n_nodes(); ++node)
      for (int axis = 0; axis < 2; ++axis) {
        const Index3 at = scene_.specimen.grid.node_at(node);
        const auto a = static_cast<std::size_t>(axis);
        if (at[2] % 4 != 3 || at[a] + 1 >= scene_.specimen.grid.nodes()[a] || !limits.intervals(at, axis))
          continue;
        for (int component = 0; component < 3; ++component)
          links.push_back({component, axis, node, stiffness});
      }
    return links;
  }

private:
  Displacement without_fixed(Displacement field) const {
    for (const Prescribed& p : scene_.prescribed)
      field(p.component, p.node) = 0;
    return field;
  }

  const Scene& scene_;
  ThreadTeam team_{1};
  Control control_;
  Clock clock_;
  CoupledTask task_;
  MaskedSolver solver_;
  MaskedSystem system_;
};

/// The truth is the operator made of cells and links one by one.
TEST(MaskedPenaltiesOracle, DirectionsSolveForPenalizedLinksToo) {
  const Scene scene = slotted_block();
  PenalizedBody body(scene);
  const double own = scene.cell_stiffness(scene.specimen.grid.n_cells() - 1)(3, 3) * 1e-3; // of a link [N/m]
  const Displacement forces = body.random_forces();
  for (const double times : {0.0, 10.0, 1000.0}) {
    const auto links = times > 0 ? body.layers(times * own) : List<PenaltyLink>{};
    body.system().set_penalties(links);
    Displacement direction(scene.specimen.grid);
    const int iterations = body.system().find_direction(
        forces, 60, 1e-5, [] { return false; }, direction);
    EXPECT_LE(iterations, times > 10 ? 40 : 25) << times;
    Displacement rest = body.apply(direction, links);
    for (std::size_t i = 0; i < rest.values().size(); ++i)
      rest.values()[i] -= forces.values()[i];
    EXPECT_LE(test::norm(rest), 1e-3 * test::norm(forces)) << times << ' ' << iterations;
  }
}

TEST(MaskedPenaltiesContract, LinksAreForgottenWhenOthersArePenalized) {
  const Scene scene = slotted_block();
  PenalizedBody body(scene);
  const Displacement forces = body.random_forces();
  Displacement before(scene.specimen.grid), after = before;
  const auto find = [&](Displacement& direction) {
    body.system().find_direction(
        forces, 1, 0, [] { return false; }, direction);
  };
  find(before);
  body.system().set_penalties(body.layers(1e3));
  find(after);
  EXPECT_NE(after, before);
  body.system().set_penalties({});
  find(after);
  EXPECT_EQ(after, before);
}

} // namespace
} // namespace maille::deform
