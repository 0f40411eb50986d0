#include "relax/block_matrix.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "relax/block_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see propagate/cone_kernel.cpp for what that forbids. Vectors hold the components of one row, in the
// same order of sums on every machine and any number of threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, block_stride>;
using VF = hn::VFromD<F>;

/// Calls visit(where in the fields) for the vectors of rows: one each, but on machines without vectors.
template<class Visit>
HWY_INLINE void for_vectors(std::int32_t first, std::int32_t end, Visit&& visit) {
  for (std::int32_t row = first; row < end; ++row)
    for (int part = 0; part < block_stride; part += static_cast<int>(hn::Lanes(F())))
      visit(row, part);
}

/// Of row `row` of A u; its fourth number does not count. Three sums, one for each column of the blocks, wait less for one another.
HWY_INLINE VF row_of(const BlockMatrix& A, std::int32_t row, int part, const float* u) {
  const F d;
  VF x = hn::Zero(d), y = hn::Zero(d), z = hn::Zero(d);
  const std::int32_t* const first = A.first.data() + row;
  const std::int32_t* const column = A.column.data();
  const float* block = A.blocks.data() + std::int64_t{9} * first[0] + part;
  for (std::int32_t i = first[0]; i < first[1]; ++i, block += 9) {
    const float* const of_u = u + std::int64_t{block_stride} * column[i];
    x = hn::MulAdd(hn::LoadU(d, block), hn::Set(d, of_u[0]), x);
    y = hn::MulAdd(hn::LoadU(d, block + 3), hn::Set(d, of_u[1]), y);
    z = hn::MulAdd(hn::LoadU(d, block + 6), hn::Set(d, of_u[2]), z);
  }
  return hn::Add(hn::Add(x, y), z);
}

HWY_INLINE std::int64_t place(std::int32_t row, int part) {
  return std::int64_t{block_stride} * row + part;
}

void apply(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* u, float* out) {
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    hn::StoreU(row_of(A, row, part, u), F(), out + place(row, part));
  });
}

void residual(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* f, const float* u,
              float* out) {
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    const std::int64_t at = place(row, part);
    hn::StoreU(hn::Sub(hn::LoadU(F(), f + at), row_of(A, row, part, u)), F(), out + at);
  });
}

void relax(const BlockMatrix& A, std::int32_t first, std::int32_t end, float weight, const float* inverse,
           const float* f, const float* u, float* next) {
  const F d;
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    const std::int64_t at = place(row, part);
    const VF change = hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + at));
    hn::StoreU(
        hn::MulAdd(hn::Sub(hn::LoadU(d, f + at), row_of(A, row, part, u)), change, hn::LoadU(d, u + at)), d,
        next + at);
  });
}

void interpolate(const Weights& P, std::int32_t first, std::int32_t end, const float* u, bool adds,
                 float* out) {
  const F d;
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    float* const at = out + place(row, part);
    VF sum = adds ? hn::LoadU(d, at) : hn::Zero(d);
    for (std::int32_t i = P.first.data()[row]; i < P.first.data()[row + 1]; ++i)
      sum =
          hn::MulAdd(hn::Set(d, P.weight.data()[i]), hn::LoadU(d, u + place(P.column.data()[i], part)), sum);
    hn::StoreU(sum, d, at);
  });
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(apply);
HWY_EXPORT(residual);
HWY_EXPORT(relax);
HWY_EXPORT(interpolate);

void apply_blocks(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(apply)(A, first, end, u, out);
}
void find_block_residual(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* f,
                         const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(residual)(A, first, end, f, u, out);
}
void relax_blocks(const BlockMatrix& A, std::int32_t first, std::int32_t end, float weight,
                  const float* inverse, const float* f, const float* u, float* next) {
  HWY_DYNAMIC_DISPATCH(relax)(A, first, end, weight, inverse, f, u, next);
}
void interpolate_blocks(const Weights& P, std::int32_t first, std::int32_t end, const float* u, bool adds,
                        float* out) {
  HWY_DYNAMIC_DISPATCH(interpolate)(P, first, end, u, adds, out);
}

} // namespace maille::deform
#endif
