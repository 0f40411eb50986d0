#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/export/calculix.hpp"

namespace maille::studies {

int export_command(const ExportOptions& options) {
  keep_inputs({options.scene});
  prepare_file("--out", options.file);
  deliver(calculix_deck(read_scene(options.scene)), options.file);
  return exit_done;
}

} // namespace maille::studies
