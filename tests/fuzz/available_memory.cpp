/// Stands in for maille::available_memory() (the linker's --wrap): sizes are held against this.

#include <cstdint>

extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv();
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv() {
  return std::int64_t{1} << 20;
}
