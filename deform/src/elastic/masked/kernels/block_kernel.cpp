#include "elastic/masked/block_matrix.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/block_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <Eigen/Core>

#include <cstdint>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Vectors hold the
// components of one row, in the same order of sums on every machine and any number of threads.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using F = hn::CappedTag<float, block_stride>;
using VF = hn::VFromD<F>;

/// Calls visit(offset) for the vectors of rows: one a row, or one a number on machines without vectors.
template<class Visit>
HWY_INLINE void for_vectors(std::int32_t first, std::int32_t end, Visit&& visit) {
  for (std::int32_t row = first; row < end; ++row)
    for (int part = 0; part < block_stride; part += static_cast<int>(hn::Lanes(F())))
      visit(row, part);
}

/// Sums of a block, column by column, times the displacement of its vertex; columns stay apart until the row
/// ends. Nine numbers fit one vector, or take three; the operations are the same.
#if HWY_MAX_BYTES >= 64
class BlockSums {
  using Whole = hn::FixedTag<float, 16>;

public:
  HWY_INLINE BlockSums() : sum_(hn::Zero(Whole())) {}
  HWY_INLINE void add(const float* block, const float* of_u, int /*part*/) {
    const Whole d;
    const hn::FixedTag<float, 8> half;
    const auto u = hn::ZeroExtendVector(d, hn::ZeroExtendVector(half, hn::LoadU(F(), of_u)));
    sum_ = hn::MulAdd(hn::LoadU(d, block), hn::TableLookupLanes(u, hn::SetTableIndices(d, component)), sum_);
  }
  HWY_INLINE void add(const BlockSums& other) { sum_ = hn::Add(sum_, other.sum_); }
  HWY_INLINE VF total() const {
    const Whole d;
    const auto y = hn::TableLookupLanes(sum_, hn::SetTableIndices(d, second)),
               z = hn::TableLookupLanes(sum_, hn::SetTableIndices(d, third));
    return hn::LowerHalf(F(), hn::LowerHalf(hn::FixedTag<float, 8>(), hn::Add(hn::Add(sum_, y), z)));
  }

private:
  alignas(64) static constexpr std::int32_t component[16] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3},
                                            second[16] = {3, 4, 5, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
                                            third[16] = {6, 7, 8, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6};
  hn::VFromD<Whole> sum_;
};
#else
class BlockSums {
public:
  HWY_INLINE BlockSums() : x_(hn::Zero(F())), y_(hn::Zero(F())), z_(hn::Zero(F())) {}
  HWY_INLINE void add(const float* block, const float* of_u, int part) {
    const F d;
    add(hn::LoadU(d, block + part), hn::LoadU(d, block + 3 + part), hn::LoadU(d, block + 6 + part), of_u);
  }
  HWY_INLINE void add(VF x, VF y, VF z, const float* of_u) {
    const F d;
    x_ = hn::MulAdd(x, hn::Set(d, of_u[0]), x_);
    y_ = hn::MulAdd(y, hn::Set(d, of_u[1]), y_);
    z_ = hn::MulAdd(z, hn::Set(d, of_u[2]), z_);
  }
  HWY_INLINE void add(const BlockSums& other) {
    x_ = hn::Add(x_, other.x_);
    y_ = hn::Add(y_, other.y_);
    z_ = hn::Add(z_, other.z_);
  }
  HWY_INLINE VF total() const { return hn::Add(hn::Add(x_, y_), z_); }

private:
  VF x_, y_, z_;
};
#endif

/// Calls add(sum, number of a block) for the blocks of a row, with four sums in turn to hide latency, and
/// all_four(number of the first) for four blocks at once.
template<class Four, class Add>
HWY_INLINE void in_turns(std::int32_t n, const Four& all_four, const Add& add) {
  std::int32_t i = 0;
  for (; i + 4 <= n; i += 4)
    all_four(i);
  if (i + 2 <= n) {
    add(0, i);
    add(1, i + 1);
    i += 2;
  }
  if (i < n)
    add(2, i);
}

/// The same without all_four().
template<class Add>
HWY_INLINE void in_turns(std::int32_t n, const Add& add) {
  in_turns(
      n,
      [&](std::int32_t i) HWY_ATTR {
        for (int k = 0; k < 4; ++k)
          add(k, i + k);
      },
      add);
}

template<class Sums>
HWY_INLINE VF total(Sums* sums) {
  sums[0].add(sums[1]);
  sums[2].add(sums[3]);
  sums[0].add(sums[2]);
  return sums[0].total();
}

/// Row `row` of A u; the fourth number is unused.
HWY_INLINE VF sum_of_blocks(const BlockMatrix& A, std::int32_t row, int part, const float* u) {
  BlockSums sums[4];
  const std::int32_t begin = A.first.data()[row], n = A.first.data()[row + 1] - begin;
  const std::int32_t* const column = A.column.data() + begin;
  const float* const block = A.blocks.data() + std::int64_t{9} * begin;
  const auto add = [&](int sum, std::int32_t i) HWY_ATTR {
    sums[sum].add(block + 9 * i, u + std::int64_t{block_stride} * column[i], part);
  };
  in_turns(n, add);
  return total(sums);
}

#if HWY_MAX_BYTES >= 32
/// One vector has the first eight numbers of a block; another has the ninth numbers of four blocks.
HWY_INLINE VF sum_of_blocks(const RoundedBlockMatrix& A, std::int32_t row, int, const float* u) {
  using Eight = hn::FixedTag<float, 8>;
  using VE = hn::VFromD<Eight>;
  const Eight d;
  const F four;
  const hn::Repartition<std::uint8_t, Eight> bytes;
  alignas(32) static constexpr std::uint8_t component[32] = {
      0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7, 8, 9, 10, 11, 8, 9, 10, 11};
  const auto of_columns = hn::Load(bytes, component);
  const std::int32_t begin = A.first.data()[row], n = A.first.data()[row + 1] - begin;
  const std::int32_t* const column = A.column.data() + begin;
  const std::uint16_t *const block = A.blocks.data() + std::int64_t{8} * begin, *const last =
                                                                                    A.last.data() + begin;
  VE sums[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  VF of_last = hn::Zero(four);
  const auto numbers = [](auto tag, const std::uint16_t* at) HWY_ATTR {
    return hn::PromoteTo(tag, hn::LoadU(hn::Rebind<hwy::float16_t, decltype(tag)>(),
                                        reinterpret_cast<const hwy::float16_t*>(at)));
  };
  const auto add_eight = [&](int sum, std::int32_t i) HWY_ATTR {
    const VE of_u = hn::LoadDup128(d, u + std::int64_t{block_stride} * column[i]);
    const VE factors = hn::BitCast(d, hn::TableLookupBytes(hn::BitCast(bytes, of_u), of_columns));
    sums[sum] = hn::MulAdd(numbers(d, block + 8 * i), factors, sums[sum]);
    return hn::LowerHalf(four, of_u);
  };
  const auto zs_of = [&](VF one, VF other) HWY_ATTR { return hn::InterleaveUpper(four, one, other); };
  in_turns(
      n,
      [&](std::int32_t i) HWY_ATTR {
        const VF a = add_eight(0, i), b = add_eight(1, i + 1), c = add_eight(2, i + 2),
                 e = add_eight(3, i + 3);
        of_last = hn::MulAdd(numbers(four, last + i), hn::ConcatLowerLower(four, zs_of(c, e), zs_of(a, b)),
                             of_last);
      },
      [&](int sum, std::int32_t i) HWY_ATTR {
        const VF of_u = add_eight(sum, i);
        const VF own = hn::IfThenElseZero(hn::FirstN(four, 1), numbers(four, last + i)),
                 z = hn::IfThenElseZero(hn::FirstN(four, 1), hn::ShiftRightLanes<2>(four, of_u));
        of_last = sum == 0   ? hn::MulAdd(own, z, of_last)
                  : sum == 1 ? hn::MulAdd(hn::ShiftLeftLanes<1>(own), hn::ShiftLeftLanes<1>(z), of_last)
                             : hn::MulAdd(hn::ShiftLeftLanes<2>(own), hn::ShiftLeftLanes<2>(z), of_last);
      });
  const VE eight = hn::Add(hn::Add(sums[0], sums[1]), hn::Add(sums[2], sums[3]));
  const VF pairs = hn::Add(of_last, hn::Shuffle2301(of_last)),
           ninth = hn::Add(pairs, hn::ShiftRightLanes<2>(four, pairs));
  const VF low = hn::LowerHalf(four, eight), high = hn::UpperHalf(four, eight);
  const VF y = hn::CombineShiftRightBytes<12>(four, high, low),
           z = hn::CombineShiftRightBytes<8>(four, ninth, high);
  return hn::Add(hn::Add(low, y), z);
}
#else
HWY_INLINE VF sum_of_blocks(const RoundedBlockMatrix& A, std::int32_t row, int part, const float* u) {
  BlockSums sums[4];
  const std::int32_t begin = A.first.data()[row], n = A.first.data()[row + 1] - begin;
  const std::int32_t* const column = A.column.data() + begin;
  const std::uint16_t *const block = A.blocks.data() + std::int64_t{8} * begin, *const last =
                                                                                    A.last.data() + begin;
  const auto numbers = [&](const std::uint16_t* at) HWY_ATTR {
    return hn::PromoteTo(
        F(), hn::LoadU(hn::Rebind<hwy::float16_t, F>(), reinterpret_cast<const hwy::float16_t*>(at + part)));
  };
  const auto add = [&](int sum, std::int32_t i) HWY_ATTR {
    const std::uint16_t* const at = block + 8 * i;
    const std::uint16_t column_of_z[8] = {at[6], at[7], last[i]};
    sums[sum].add(numbers(at), numbers(at + 3), numbers(column_of_z),
                  u + std::int64_t{block_stride} * column[i]);
  };
  in_turns(n, add);
  return total(sums);
}
#endif

/// See round_blocks().
void round_numbers(const float* blocks, std::int32_t n, float unit, std::uint16_t* eight,
                   std::uint16_t* last) {
#if HWY_MAX_BYTES >= 32
  const auto put = [&](auto d, const float* from, std::uint16_t* to) HWY_ATTR {
    const hn::Rebind<hwy::float16_t, decltype(d)> half;
    hn::StoreU(hn::DemoteTo(half, hn::Mul(hn::LoadU(d, from), hn::Set(d, 1 / unit))), half,
               reinterpret_cast<hwy::float16_t*>(to));
  };
  for (std::int32_t i = 0; i < n; ++i) {
    put(hn::FixedTag<float, 8>(), blocks + 9 * i, eight + 8 * i);
    put(hn::FixedTag<float, 1>(), blocks + 9 * i + 8, last + i);
  }
#else // where vectors round towards 0
  for (std::int32_t i = 0; i < 9 * n; ++i)
    (i % 9 < 8 ? eight[8 * (i / 9) + i % 9] : last[i / 9]) = Eigen::half(blocks[i] / unit).x;
#endif
}

HWY_INLINE VF row_of(const BlockMatrix& A, std::int32_t row, int part, const float* u) {
  return sum_of_blocks(A, row, part, u);
}
HWY_INLINE VF row_of(const RoundedBlockMatrix& A, std::int32_t row, int part, const float* u) {
  return hn::Mul(hn::Set(F(), A.scale.data()[row]), sum_of_blocks(A, row, part, u));
}

HWY_INLINE std::int64_t place(std::int32_t row, int part) {
  return std::int64_t{block_stride} * row + part;
}

template<class Matrix>
HWY_INLINE void apply_all(const Matrix& A, std::int32_t first, std::int32_t end, const float* u, float* out) {
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    hn::StoreU(row_of(A, row, part, u), F(), out + place(row, part));
  });
}
void apply(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* u, float* out) {
  apply_all(A, first, end, u, out);
}
void apply_rounded(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* u,
                   float* out) {
  apply_all(A, first, end, u, out);
}

template<class Matrix>
HWY_INLINE void find_residual(const Matrix& A, std::int32_t first, std::int32_t end, const float* f,
                              const float* u, float* out) {
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    const std::int64_t at = place(row, part);
    hn::StoreU(hn::Sub(hn::LoadU(F(), f + at), row_of(A, row, part, u)), F(), out + at);
  });
}
void residual(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* f, const float* u,
              float* out) {
  find_residual(A, first, end, f, u, out);
}
void residual_rounded(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* f,
                      const float* u, float* out) {
  find_residual(A, first, end, f, u, out);
}

template<class Matrix>
HWY_INLINE void take_step(const Matrix& A, std::int32_t first, std::int32_t end, float weight,
                          const float* inverse, const float* f, const float* u, float* next) {
  const F d;
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    const std::int64_t at = place(row, part);
    const VF change = hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + at));
    hn::StoreU(
        hn::MulAdd(hn::Sub(hn::LoadU(d, f + at), row_of(A, row, part, u)), change, hn::LoadU(d, u + at)), d,
        next + at);
  });
}
void relax(const BlockMatrix& A, std::int32_t first, std::int32_t end, float weight, const float* inverse,
           const float* f, const float* u, float* next) {
  take_step(A, first, end, weight, inverse, f, u, next);
}
void relax_rounded(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, float weight,
                   const float* inverse, const float* f, const float* u, float* next) {
  take_step(A, first, end, weight, inverse, f, u, next);
}

HWY_INLINE VF sum_of_row(const Weights& P, std::int32_t row, int part, const float* u, VF sum) {
  for (std::int32_t i = P.first.data()[row]; i < P.first.data()[row + 1]; ++i)
    sum = hn::MulAdd(hn::Set(F(), P.weight.data()[i]), hn::LoadU(F(), u + place(P.column.data()[i], part)),
                     sum);
  return sum;
}

void interpolate(const Weights& P, std::int32_t first, std::int32_t end, const float* u, bool adds,
                 float* out) {
  const F d;
  for_vectors(first, end, [&](std::int32_t row, int part) HWY_ATTR {
    float* const at = out + place(row, part);
    hn::StoreU(sum_of_row(P, row, part, u, adds ? hn::LoadU(d, at) : hn::Zero(d)), d, at);
  });
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(apply);
HWY_EXPORT(apply_rounded);
HWY_EXPORT(residual);
HWY_EXPORT(residual_rounded);
HWY_EXPORT(relax);
HWY_EXPORT(relax_rounded);
HWY_EXPORT(interpolate);
HWY_EXPORT(round_numbers);

void apply_blocks(const BlockMatrix& A, std::int32_t first, std::int32_t end, const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(apply)(A, first, end, u, out);
}
void apply_blocks(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* u,
                  float* out) {
  HWY_DYNAMIC_DISPATCH(apply_rounded)(A, first, end, u, out);
}
void round_blocks(const float* blocks, std::int32_t n, float unit, std::uint16_t* eight,
                  std::uint16_t* last) {
  HWY_DYNAMIC_DISPATCH(round_numbers)(blocks, n, unit, eight, last);
}
void find_block_residual(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, const float* f,
                         const float* u, float* out) {
  HWY_DYNAMIC_DISPATCH(residual_rounded)(A, first, end, f, u, out);
}
void relax_blocks(const RoundedBlockMatrix& A, std::int32_t first, std::int32_t end, float weight,
                  const float* inverse, const float* f, const float* u, float* next) {
  HWY_DYNAMIC_DISPATCH(relax_rounded)(A, first, end, weight, inverse, f, u, next);
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
