#include "cli/commands.hpp"
#include "export/calculix/calculix.hpp"

namespace maille::studies {

void write_deck(const Scene& scene, const std::string& file) {
  if (const std::string reason = why_no_deck(scene); !reason.empty())
    throw UsageError("--write: expected a scene that a deck of CalculiX can say: " + reason);
  deliver(calculix_deck(scene), file);
}

} // namespace maille::studies
