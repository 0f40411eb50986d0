#pragma once
/// Holds deal.II, BLAS and OpenMP to the caller's number of threads.

namespace maille::fem_ref {

/// For as long as it lives. Afterwards the numbers are what they were. They belong to the process: two solves
/// at once in one process share them.
class ThreadLimit {
public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
  unsigned deal_ii_before_;
  int blas_before_ = 0;
  int openmp_levels_before_ = 0;
};

} // namespace maille::fem_ref
