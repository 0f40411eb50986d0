#pragma once
/// Columns and pairs of blocks with springs, loads and sliding borders, and the solvers that answer them.

#include "maille/scene/answer.hpp"
#include "support/bodies/layers.hpp"

#include <functional>
#include <vector>

namespace maille::test {

/// A solver that conditions_test.cpp asks.
struct ConditionSolver {
  const char* name; ///< of the method, as the command line has it
  std::function<Answer(const Scene&)> solve;
  double accuracy;          ///< relative, of forces at sliding borders [1]
  bool is_confined = false; ///< strains of one axis alone
  bool has_friction = false;
};

/// The solvers of this program of tests.
std::vector<ConditionSolver> condition_solvers();

/// A column whose lower end glides on a plane, kept from moving sideways; sort_prescribed() follows.
inline Scene column(const Index3& cells, double spacing, const Material& material) {
  Scene scene = box_scene(3, cells, {spacing, spacing, spacing});
  scene.materials = {material};
  scene.relaxation.tolerance = 1e-9;
  add_prescribed(scene, {0, 0, 0}, 0, 0, true);
  add_prescribed(scene, {0, 0, 0}, 1, 0, true);
  add_prescribed(scene, {cells[0], 0, 0}, 1, 0, true);
  return scene;
}

/// Blocks of n x n x 4 and n x n x 6 cells on each other, labels 1 and 2, moved by `shift` [m] along z on
/// top; neither moves sideways nor turns.
inline Scene two_blocks(int n, double shift, double spacing, const Material& below, const Material& above) {
  const auto label = [](const Vec3& at) { return at[2] < 4 ? 1 : 2; };
  Scene scene = labelled({n, n, 10}, spacing, label, below, above)
                    .hold("z-", "z")
                    .move("z+", {0, 0, shift}, "z")
                    .build();
  for (const int z : {0, 10}) {
    add_prescribed(scene, {0, 0, z}, 0, 0, true);
    add_prescribed(scene, {0, 0, z}, 1, 0, true);
    add_prescribed(scene, {n, 0, z}, 1, 0, true);
  }
  sort_prescribed(scene);
  scene.relaxation.tolerance = 1e-8;
  return scene;
}

/// Makes the border of two_blocks() slide, and draws the upper block along x as a whole.
inline void draw_upper_block(Scene& scene, double by) {
  for (Prescribed& p : scene.prescribed)
    if (p.component == 0 && scene.specimen.grid.node_at(p.node)[2] == 10)
      p.value = by, p.held = false;
  scene.sliding = {{1, 2}};
}

} // namespace maille::test
