#include "process/thread_limit.hpp"

#include <deal.II/base/multithread_info.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include <dlfcn.h>

namespace maille::fem_ref {
namespace {

/// Which BLAS and which OpenMP stand behind CHOLMOD is settled when the program is loaded, so they are asked
/// then.
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

/// What the environment allows: where address space is short, one, since its threads would ask for their
/// buffers without end.
int most_blas_threads() {
  const char* const wish = std::getenv("OPENBLAS_NUM_THREADS");
  const int most = wish == nullptr ? 0 : std::atoi(wish);
  return most > 0 ? most : std::numeric_limits<int>::max();
}

} // namespace

ThreadLimit::ThreadLimit(int threads)
    : deal_ii_before_(dealii::MultithreadInfo::n_threads()), blas_before_(ask("openblas_get_num_threads")),
      openmp_levels_before_(ask("omp_get_max_active_levels")) {
  dealii::MultithreadInfo::set_thread_limit(static_cast<unsigned>(threads));
  tell("openblas_set_num_threads", std::min(threads, most_blas_threads()));
  // CHOLMOD asks for four OpenMP threads whatever the machine has; no active level means none. BLAS does the
  // work.
  tell("omp_set_max_active_levels", 0);
}

ThreadLimit::~ThreadLimit() {
  dealii::MultithreadInfo::set_thread_limit(deal_ii_before_);
  if (blas_before_ > 0)
    tell("openblas_set_num_threads", blas_before_);
  if (openmp_levels_before_ > 0)
    tell("omp_set_max_active_levels", openmp_levels_before_);
}

} // namespace maille::fem_ref
