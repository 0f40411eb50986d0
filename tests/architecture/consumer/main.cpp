/// A user's program: reads a scene, answers it, prints how far the middle of the body moved along x.

#include <maille/deform/solve.hpp>
#include <maille/scene/read_scene.hpp>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2)
    return 2;
  const maille::Scene scene = maille::read_scene(argv[1]);
  const maille::Answer answer = maille::deform::solve(scene, "limits");
  const maille::Grid& grid = scene.specimen.grid;
  const auto middle = grid.node({grid.nodes()[0] / 2, grid.nodes()[1] / 2, grid.nodes()[2] / 2});
  std::printf("%s %s %.3f mm\n", answer.method.c_str(), maille::to_string(answer.status).data(),
              1e3 * answer.displacement(0, middle));
}
