#pragma once
/// Holds deal.II, BLAS and OpenMP to the caller's number of threads, and OpenBLAS to its address space.

namespace maille::fem_ref {

/// For as long as it lives. Afterwards the numbers of BLAS and OpenMP are what they were; deal.II keeps its
/// own until the next solve. They belong to the process: two solves at once in one process share them.
class ThreadLimit {
public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
  int blas_before_ = 0;
  int openmp_levels_before_ = 0;
};

/// Whether OpenBLAS has the buffer that it takes for its first product: where it cannot have it, it asks
/// again for ever. Takes it for OpenBLAS, which keeps it, if memory is limited (ulimit -v, -d); to be asked
/// before anything large takes what there is.
bool has_blas_memory();

} // namespace maille::fem_ref
