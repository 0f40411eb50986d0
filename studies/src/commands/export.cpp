#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "export/calculix/calculix.hpp"
#include "maille/scene/read_scene.hpp"

namespace maille::studies {

int export_command(const ExportOptions& options) {
  keep_inputs({options.scene});
  prepare_file("--out", options.file);
  const Scene scene = read_scene(options.scene);
  if (const std::string reason = why_no_deck(scene); !reason.empty())
    throw UsageError("export: expected a scene that a deck of CalculiX can say: " + reason);
  deliver(calculix_deck(scene), options.file);
  return exit_done;
}

} // namespace maille::studies
