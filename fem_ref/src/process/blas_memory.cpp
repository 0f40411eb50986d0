#include "process/blas_memory.hpp"

#include <cstddef>

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace maille::fem_ref {
namespace {

bool is_limited() {
  rlimit space{}, data{};
  return (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) ||
         (getrlimit(RLIMIT_DATA, &data) == 0 && data.rlim_cur != RLIM_INFINITY);
}

bool could_have(std::size_t bytes) {
  void* const address =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED)
    return false;
  munmap(address, bytes);
  return true;
}

/// OpenBLAS's own way to its buffers. What it is given back it keeps for the next product.
bool take_buffer() {
  constexpr int for_anything = 0;
  const auto take = reinterpret_cast<void* (*)(int)>(dlsym(RTLD_DEFAULT, "blas_memory_alloc"));
  const auto give_back = reinterpret_cast<void (*)(void*)>(dlsym(RTLD_DEFAULT, "blas_memory_free"));
  if (take == nullptr || give_back == nullptr)
    return true; // another BLAS
  void* const buffer = take(for_anything);
  if (buffer != nullptr)
    give_back(buffer);
  return buffer != nullptr;
}

} // namespace

bool has_blas_memory() {
  // The buffer, 128 MiB and what stands before and behind it, and as much for what is done besides.
  constexpr std::size_t enough = std::size_t{256} << 20;
  static bool has_it = false;
  if (!has_it)
    has_it = !is_limited() || (could_have(enough) && take_buffer());
  return has_it;
}

} // namespace maille::fem_ref
