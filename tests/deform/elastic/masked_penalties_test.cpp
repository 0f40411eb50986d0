/// The multigrid of a body of any shape some of whose links are stiffer than its matter.

#include "elastic/masked/masked_solver.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maille::deform {
namespace {

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
