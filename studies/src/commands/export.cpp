#include "commands.hpp"

#include "maille/scene/read_scene.hpp"
#include "maille/studies/export/calculix.hpp"

namespace maille::studies {

int export_command(const ExportOptions& options) {
  prepare_file("--out", options.file);
  deliver(calculix_deck(read_scene(options.scene)), options.file);
  return exit_done;
}

} // namespace maille::studies
