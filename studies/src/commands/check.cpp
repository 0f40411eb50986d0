#include "commands.hpp"
#include "world_in_words.hpp"

#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/read_world_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace maille::studies {

int check_command(const CommonOptions& options) {
  if (options.json) {
    nlohmann::ordered_json out{{"scene", options.scene.string()},
                               {"faults", nlohmann::ordered_json::array()}};
    try {
      if (is_world_scene(options.scene))
        world_of(read_world_scene(options.scene), options.scene);
      else
        read_scene(options.scene);
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults())
        out["faults"].push_back({{"file", fault.file},
                                 {"line", fault.line},
                                 {"key", fault.key},
                                 {"expected", fault.expected},
                                 {"found", fault.found}});
    }
    deliver(json_text(out), options.json);
    return out["faults"].empty() ? exit_done : exit_faulty_input;
  }
  if (is_world_scene(options.scene)) { // faults are reported by main
    const WorldScene world = read_world_scene(options.scene);
    world_of(world, options.scene);
    deliver(fmt::format("{}: no faults; {}\n", options.scene.string(), in_words(world)), std::nullopt);
    return exit_done;
  }
  const Scene scene = read_scene(options.scene);
  std::string text =
      fmt::format("{}: no faults; {}D, {} cells, {} nodes, {} material{}, {} prescribed components\n",
                  options.scene.string(), scene.dimension(), scene.specimen.n_matter_cells(),
                  scene.specimen.n_matter_nodes(), scene.materials.size(),
                  scene.materials.size() == 1 ? "" : "s", scene.prescribed.size());
  if (scene.specimen.fibre_report.source == "tensor_image")
    text += fmt::format("fibres: {}\n", in_words(scene.specimen.fibre_report));
  for (const LeftOutPiece& piece : scene.left_out)
    text += fmt::format("left out: {}\n", piece.name);
  deliver(text, std::nullopt);
  return exit_done;
}

} // namespace maille::studies
