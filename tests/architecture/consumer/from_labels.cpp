#include <maille/deform/solve.hpp>
#include <maille/scene/measure/measure.hpp>
#include <maille/scene/scene_builder.hpp>

#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
  // A bar of label 17 in an array of 10 x 4 x 4 voxels of 1 mm, in the order of array[x][y][z].
  const auto layout = maille::ArrayLayout::z_fastest({10, 4, 4});
  std::vector<std::uint16_t> labels(10 * 4 * 4, 0);
  for (int x = 1; x < 9; ++x)
    for (int y = 1; y < 3; ++y)
      for (int z = 1; z < 3; ++z)
        labels[static_cast<std::size_t>(layout.element({x, y, z}))] = 17;
  try {
    const auto [scene, measures] =
        maille::SceneBuilder("bar")
            .labels(labels, layout, maille::affine_of({1e-3, 1e-3, 1e-3}))
            .material(17, "muscle/soleus")
            .hold("x-")
            .move("x+", {2e-3, 0, 0}) // metres
            .measure("middle", "displacement = { at = [5e-3, 2e-3, 2e-3] }\ncomponent = \"x\"")
            .measure("pull", "force = \"move[1]\"\ncomponent = \"x\"")
            .build_with_measures();
    const maille::Answer answer = maille::deform::solve(scene, maille::Method::coupled);
    const auto values = maille::measured(scene, measures, answer); // in the order in which they were asked
    std::printf("%s: %s, %.3f mm\n", answer.method.c_str(), maille::to_string(answer.status).data(),
                1e3 * values[0].value.value());
    return maille::is_converged(answer.status) ? 0 : 1;
  } catch (const maille::InputError& error) { // every fault, one a line
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
