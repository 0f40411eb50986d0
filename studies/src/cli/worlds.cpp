#include "cli/worlds.hpp"

#include "maille/materials/fault.hpp"

#include <chrono>
#include <stdexcept>
#include <string_view>

namespace maille::studies {

deform::World world_of(const WorldScene& scene, const std::filesystem::path& file) {
  try {
    return deform::World(scene);
  } catch (const std::invalid_argument& error) {
    const std::string_view what = error.what();
    throw InputError({{file.string(), 0, "object", "objects that fit into the world and keep apart",
                       std::string(what.substr(what.starts_with("World: ") ? 7 : 0))}});
  }
}

PlacedWorld placed(const WorldScene& scene, const std::filesystem::path& file) {
  const auto start = std::chrono::steady_clock::now();
  deform::World world = world_of(scene, file);
  PlacedWorld found;
  found.set_up_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  found.map = world.map().bytes();
  found.objects = world.bytes() - found.map;
  for (int object = 0; object < world.n_objects(); ++object)
    found.thin.push_back(100 * world.thin_part(object));
  deform::FrameBudget budget;
  budget.seconds = longest_first_frame;
  found.frame_seconds = world.advance({}, budget).seconds;
  return found;
}

} // namespace maille::studies
