#pragma once
/// Address space for OpenBLAS.

#include <cstddef>

#include <sys/mman.h>

namespace maille::fem_ref {

/// Whether OpenBLAS can have the buffer that it takes at its first product: where it cannot, it asks again for ever. Once it could, it keeps
/// it. To be asked before dense blocks of a factor are multiplied.
inline bool has_blas_memory() {
  constexpr std::size_t buffer = std::size_t{136} << 20; // 128 MiB, and what stands before and behind it
  static bool has_it = false;
  if (!has_it) {
    void* const address =
        mmap(nullptr, buffer, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    has_it = address != MAP_FAILED;
    if (has_it)
      munmap(address, buffer);
  }
  return has_it;
}

} // namespace maille::fem_ref
