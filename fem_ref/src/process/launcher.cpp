#include "process/launcher.hpp"

#include <cstdlib>

namespace maille::fem_ref {

int announced_ranks() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name))
      return std::atoi(size);
  return 1;
}

} // namespace maille::fem_ref
