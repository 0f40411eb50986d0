#pragma once
/// Limits deal.II, BLAS and OpenMP to the caller's number of threads, and OpenBLAS to its address space.

namespace maille::fem_ref {

/// Sets the limits in its lifetime. Destruction restores the numbers of BLAS and OpenMP; deal.II keeps its
/// number until the next solve. The settings are global to the process: simultaneous solves share them.
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

/// True if OpenBLAS can have the buffer for its first product; without it, OpenBLAS retries for ever. If
/// memory is limited (ulimit -v, -d), allocates the buffer, which OpenBLAS keeps. Call it before any large
/// allocation.
bool has_blas_memory();

} // namespace maille::fem_ref
