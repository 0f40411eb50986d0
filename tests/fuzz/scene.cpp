/// Scenes. Those without fault are looked at once more: what methods are given has to be what they are
/// promised.

#include "fuzzing.hpp"
#include "maille/scene/read_scene.hpp"

#include <cmath>

namespace maille::fuzzing {
namespace {

void check_scene(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  for (int axis = 0; axis < grid.dimension(); ++axis)
    require(grid.cells()[static_cast<std::size_t>(axis)] > 0 &&
                std::isfinite(grid.spacing()[static_cast<std::size_t>(axis)]) &&
                grid.spacing()[static_cast<std::size_t>(axis)] > 0,
            "a grid that is one");
  require(!scene.materials.empty() && scene.specimen.n_matter_cells() > 0, "a body");
  require(scene.specimen.material_id.empty() ||
              static_cast<std::int64_t>(scene.specimen.material_id.size()) == grid.n_cells(),
          "a material for every cell");
  for (const auto& prescribed : scene.prescribed)
    require(prescribed.node >= 0 && prescribed.node < grid.n_nodes() && prescribed.component >= 0 &&
                prescribed.component < grid.dimension() && std::isfinite(prescribed.value),
            "prescribed components of nodes that there are");
}

} // namespace
} // namespace maille::fuzzing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maille::set_file_scope(maille::FileScope::sandbox); // what is tried reads nothing but fixtures
  using namespace maille;
  return fuzzing::tried([&] {
    fuzzing::check_scene(parse_scene(fuzzing::text_of(data, size), fuzzing::fixtures() / "scene.toml"));
  });
}
