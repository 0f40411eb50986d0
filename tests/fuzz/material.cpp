/// Files that hold one material, as `maille fit` writes them.

#include "fuzzing.hpp"
#include "maille/scene/read_scene.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maille::set_file_scope(maille::FileScope::sandbox); // what is tried reads nothing but fixtures
  using namespace maille;
  static const fuzzing::ScratchFile file("material.toml");
  const auto folder = file.holding(fuzzing::text_of(data, size)).parent_path();
  return fuzzing::tried([&] {
    const Scene scene = parse_scene("[specimen]\nshape = \"box\"\ncells = [2, 2, 2]\nspacing = \"1 mm\"\n"
                                    "material = \"material.toml\"\n[[hold]]\nwhere = \"x-\"\n",
                                    folder / "scene.toml");
    fuzzing::require(violated_inequalities(scene.materials.at(0).elasticity).empty(),
                     "positive strain energy");
  });
}
