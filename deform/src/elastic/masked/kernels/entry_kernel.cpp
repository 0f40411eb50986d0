#include "elastic/masked/masked_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/kernels/entry_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Sums have 16
// parts, so bits do not depend on the length of vectors.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Line = hn::CappedTag<float, 16>;
using One = hn::CappedTag<float, 1>;

/// Calls visit(tag, i) for vectors of entries. @pre n is a multiple of 16
template<class Visit>
HWY_INLINE void for_entries(std::int64_t n, Visit&& visit) {
  const Line d;
  for (std::int64_t i = 0; i < n; i += static_cast<std::int64_t>(hn::Lanes(d)))
    visit(d, i);
}

/// The same for any n: the remainder of a vector is processed one by one.
template<class Visit>
HWY_INLINE void for_any_entries(std::int64_t n, Visit&& visit) {
  const Line d;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  std::int64_t i = 0;
  for (; i + lanes <= n; i += lanes)
    visit(d, i);
  for (; i < n; ++i)
    visit(One(), i);
}

void noise(std::int64_t n, std::int64_t first, const float* inverse, float* f) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    const hn::RebindToUnsigned<Line> whole;
    const auto mix = [&](auto mixed, std::uint32_t factor) HWY_ATTR {
      return hn::Mul(hn::Xor(mixed, hn::ShiftRight<16>(mixed)), hn::Set(whole, factor));
    };
    const auto number = hn::Iota(whole, static_cast<std::uint32_t>(first + i) + 1);
    const auto once = mix(number, 0x85ebca6bU), shifted = hn::ShiftRight<13>(once);
    const auto twice = hn::Mul(hn::Xor(once, shifted), hn::Set(whole, 0xc2b2ae35U));
    const auto bit = hn::And(hn::Xor(twice, hn::ShiftRight<16>(twice)), hn::Set(whole, 1));
    const auto is_plus = hn::MaskFromVec(hn::BitCast(d, hn::Sub(hn::Zero(whole), bit)));
    const auto diagonal = hn::LoadU(d, inverse + i);
    const auto sign = hn::IfThenElse(is_plus, hn::Set(d, 1.0F), hn::Set(d, -1.0F));
    hn::StoreU(hn::IfThenElseZero(hn::Gt(diagonal, hn::Zero(d)), hn::Div(sign, hn::Sqrt(diagonal))), d,
               f + i);
  });
}

void start(std::int64_t n, float weight, const float* inverse, const float* f, float* u) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(hn::Mul(hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + i)), hn::LoadU(d, f + i)), d,
               u + i);
  });
}

template<class D>
HWY_INLINE hn::VFromD<D> step_of(D d, std::int64_t i, float weight, const float* inverse, const float* f,
                                 const float* u, const float* Au) {
  const auto change = hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + i));
  return hn::MulAdd(hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, Au + i)), change, hn::LoadU(d, u + i));
}

void relax(std::int64_t n, float weight, const float* inverse, const float* f, const float* Au, float* u) {
  for_entries(n, [&](Line d, std::int64_t i)
                     HWY_ATTR { hn::StoreU(step_of(d, i, weight, inverse, f, u, Au), d, u + i); });
}

void subtract(std::int64_t n, const float* inverse, const float* f, float* Au) {
  for_any_entries(n, [&](auto d, std::int64_t i) HWY_ATTR {
    const auto may_move = hn::Gt(hn::LoadU(d, inverse + i), hn::Zero(d));
    hn::StoreU(hn::IfThenElseZero(may_move, hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, Au + i))), d, Au + i);
  });
}

/// Sixteen running sums of products for any vector length: the result of visit(tag, i, sums) goes to sum i %
/// 16. The remainder is processed one by one.
template<class Visit>
HWY_INLINE double sum_of_parts(std::int64_t n, const Visit& visit) {
  constexpr int whole = 16, vectors = whole / static_cast<int>(hn::MaxLanes(Line()));
  const Line d;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  hn::VFromD<Line> sums[vectors]; // in registers
  for (auto& sum : sums)
    sum = hn::Zero(d);
  std::int64_t i = 0;
  for (; i + whole <= n; i += whole)
    for (int k = 0; k < vectors; ++k)
      visit(d, i + k * lanes, sums[k]);
  HWY_ALIGN float parts[whole];
  for (int k = 0; k < vectors; ++k)
    hn::Store(sums[k], d, parts + k * lanes);
  for (float* part = parts; i < n; ++i, ++part) {
    auto of_one = hn::Load(One(), part);
    visit(One(), i, of_one);
    hn::Store(of_one, One(), part);
  }
  double sum = 0;
  for (const float part : parts)
    sum += double{part};
  return sum;
}

double mask_and_dot(std::int64_t n, const float* inverse, const float* p, float* Ap) {
  return sum_of_parts(n, [&](auto d, std::int64_t i, auto& sum) HWY_ATTR {
    const auto may_move = hn::Gt(hn::LoadU(d, inverse + i), hn::Zero(d));
    const auto force = hn::IfThenElseZero(may_move, hn::LoadU(d, Ap + i));
    hn::StoreU(force, d, Ap + i);
    sum = hn::MulAdd(hn::LoadU(d, p + i), force, sum);
  });
}

double dot(std::int64_t n, const float* a, const float* b) {
  return sum_of_parts(n, [&](auto d, std::int64_t i, auto& sum)
                             HWY_ATTR { sum = hn::MulAdd(hn::LoadU(d, a + i), hn::LoadU(d, b + i), sum); });
}

void step_from(std::int64_t n, float weight, const float* inverse, const float* f, const float* u,
               float* Au) {
  for_any_entries(n, [&](auto d, std::int64_t i)
                         HWY_ATTR { hn::StoreU(step_of(d, i, weight, inverse, f, u, Au), d, Au + i); });
}

double step_and_dot(std::int64_t n, float weight, const float* inverse, const float* f, const float* u,
                    float* Au) {
  return sum_of_parts(n, [&](auto d, std::int64_t i, auto& sum) HWY_ATTR {
    const auto next = step_of(d, i, weight, inverse, f, u, Au);
    hn::StoreU(next, d, Au + i);
    sum = hn::MulAdd(next, hn::LoadU(d, f + i), sum);
  });
}

void direct(std::int64_t n, const float* v, float beta, float* p) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(hn::MulAdd(hn::Set(d, beta), hn::LoadU(d, p + i), hn::LoadU(d, v + i)), d, p + i);
  });
}

void combine(std::int64_t n, float of_a, const float* a, float of_u, float* u) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(
        hn::MulAdd(hn::Set(d, of_a), hn::LoadU(d, a + i), hn::Mul(hn::Set(d, of_u), hn::LoadU(d, u + i))), d,
        u + i);
  });
}

void step(std::int64_t n, float size, const float* q, float* r) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(hn::NegMulAdd(hn::Set(d, size), hn::LoadU(d, q + i), hn::LoadU(d, r + i)), d, r + i);
  });
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(noise);
HWY_EXPORT(start);
HWY_EXPORT(relax);
HWY_EXPORT(subtract);
HWY_EXPORT(mask_and_dot);
HWY_EXPORT(dot);
HWY_EXPORT(step_from);
HWY_EXPORT(step_and_dot);
HWY_EXPORT(direct);
HWY_EXPORT(combine);
HWY_EXPORT(step);

void noise_entries(std::int64_t n, std::int64_t first, const float* inverse, float* f) {
  HWY_DYNAMIC_DISPATCH(noise)(n, first, inverse, f);
}
void start_entries(std::int64_t n, float weight, const float* inverse, const float* f, float* u) {
  HWY_DYNAMIC_DISPATCH(start)(n, weight, inverse, f, u);
}
void relax_entries(std::int64_t n, float weight, const float* inverse, const float* f, const float* Au,
                   float* u) {
  HWY_DYNAMIC_DISPATCH(relax)(n, weight, inverse, f, Au, u);
}
void subtract_entries(std::int64_t n, const float* inverse, const float* f, float* Au) {
  HWY_DYNAMIC_DISPATCH(subtract)(n, inverse, f, Au);
}
double mask_and_dot_entries(std::int64_t n, const float* inverse, const float* p, float* Ap) {
  return HWY_DYNAMIC_DISPATCH(mask_and_dot)(n, inverse, p, Ap);
}
double dot_entries(std::int64_t n, const float* a, const float* b) {
  return HWY_DYNAMIC_DISPATCH(dot)(n, a, b);
}
void step_from_entries(std::int64_t n, float weight, const float* inverse, const float* f, const float* u,
                       float* Au) {
  HWY_DYNAMIC_DISPATCH(step_from)(n, weight, inverse, f, u, Au);
}
double step_and_dot_entries(std::int64_t n, float weight, const float* inverse, const float* f,
                            const float* u, float* Au) {
  return HWY_DYNAMIC_DISPATCH(step_and_dot)(n, weight, inverse, f, u, Au);
}
void direct_entries(std::int64_t n, const float* v, float beta, float* p) {
  HWY_DYNAMIC_DISPATCH(direct)(n, v, beta, p);
}
void combine_entries(std::int64_t n, float of_a, const float* a, float of_u, float* u) {
  HWY_DYNAMIC_DISPATCH(combine)(n, of_a, a, of_u, u);
}
void step_entries(std::int64_t n, float size, const float* q, float* r) {
  HWY_DYNAMIC_DISPATCH(step)(n, size, q, r);
}

} // namespace maille::deform
#endif
