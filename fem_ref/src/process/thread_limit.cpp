

#include "process/thread_limit.hpp"

#include <deal.II/base/multithread_info.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <dlfcn.h>
#include <limits>
#include <sys/mman.h>
#include <sys/resource.h>

namespace maille::fem_ref {
namespace {

/// Finds a function at run time, because the BLAS and OpenMP libraries of CHOLMOD are only known when the
/// program is loaded.
template<typename Function>
Function find(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

int ask(const char* name) {
  const auto function = find<int (*)()>(name);
  return function != nullptr ? function() : 0;
}

void tell(const char* name, int value) {
  if (const auto function = find<void (*)(int)>(name))
    function(value);
}

/// Upper bound from the environment; it is 1 if address space is limited, because threads of OpenBLAS would
/// request their buffers for ever.
int most_blas_threads() {
  const char* const wish = std::getenv("OPENBLAS_NUM_THREADS");
  const int most = wish == nullptr ? 0 : std::atoi(wish);
  return most > 0 ? most : std::numeric_limits<int>::max();
}

} // namespace

ThreadLimit::ThreadLimit(int threads)
    : blas_before_(ask("openblas_get_num_threads")), openmp_levels_before_(ask("omp_get_max_active_levels")) {
  dealii::MultithreadInfo::set_thread_limit(static_cast<unsigned>(threads));
  tell("openblas_set_num_threads", std::min(threads, most_blas_threads()));
  // CHOLMOD requests four OpenMP threads on any machine; zero active levels disable them. BLAS does the work.
  tell("omp_set_max_active_levels", 0);
}

/// deal.II's limit is not restored: TBB would start threads at once, and end the process if memory is
/// insufficient.
ThreadLimit::~ThreadLimit() {
  if (blas_before_ > 0)
    tell("openblas_set_num_threads", blas_before_);
  if (openmp_levels_before_ > 0)
    tell("omp_set_max_active_levels", openmp_levels_before_);
}

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

/// Takes a buffer by OpenBLAS's own allocator; OpenBLAS keeps a returned buffer for the next product.
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
  // The buffer of 128 MiB with its guard areas, and as much again for other needs.
  constexpr std::size_t enough = std::size_t{256} << 20;
  static bool has_it = false;
  if (!has_it)
    has_it = !is_limited() || (could_have(enough) && take_buffer());
  return has_it;
}

} // namespace maille::fem_ref
