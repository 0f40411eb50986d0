#include "elastic/masked/masked_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/masked/entry_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Sums have 16
// parts, so bits do not depend on the length of vectors.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Line = hn::CappedTag<float, 16>;

/// Calls visit(tag, i) for vectors of entries. @pre n is a multiple of 16
template<class Visit>
HWY_INLINE void for_entries(std::int64_t n, Visit&& visit) {
  const Line d;
  for (std::int64_t i = 0; i < n; i += static_cast<std::int64_t>(hn::Lanes(d)))
    visit(d, i);
}

void start(std::int64_t n, float weight, const float* inverse, const float* f, float* u) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(hn::Mul(hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + i)), hn::LoadU(d, f + i)), d,
               u + i);
  });
}

void relax(std::int64_t n, float weight, const float* inverse, const float* f, const float* Au, float* u) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    const auto change = hn::Mul(hn::Set(d, weight), hn::LoadU(d, inverse + i));
    hn::StoreU(hn::MulAdd(hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, Au + i)), change, hn::LoadU(d, u + i)), d,
               u + i);
  });
}

void subtract(std::int64_t n, const float* inverse, const float* f, float* Au) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    const auto may_move = hn::Gt(hn::LoadU(d, inverse + i), hn::Zero(d));
    hn::StoreU(hn::IfThenElseZero(may_move, hn::Sub(hn::LoadU(d, f + i), hn::LoadU(d, Au + i))), d, Au + i);
  });
}

/// Sixteen running sums of products, whatever the length of vectors.
template<class Product>
HWY_INLINE double sum_of_products(std::int64_t n, Product&& product) {
  const Line d;
  HWY_ALIGN float parts[16] = {};
  for_entries(n, [&](Line, std::int64_t i) HWY_ATTR {
    float* const part = parts + i % 16;
    const auto [a, b] = product(d, i);
    hn::Store(hn::MulAdd(a, b, hn::Load(d, part)), d, part);
  });
  double sum = 0;
  for (const float part : parts)
    sum += double{part};
  return sum;
}

template<class V>
struct Pair {
  V a, b;
};

double mask_and_dot(std::int64_t n, const float* inverse, const float* p, float* Ap) {
  return sum_of_products(n, [&](Line d, std::int64_t i) HWY_ATTR {
    const auto may_move = hn::Gt(hn::LoadU(d, inverse + i), hn::Zero(d));
    const auto force = hn::IfThenElseZero(may_move, hn::LoadU(d, Ap + i));
    hn::StoreU(force, d, Ap + i);
    return Pair<hn::VFromD<Line>>{hn::LoadU(d, p + i), force};
  });
}

double dot(std::int64_t n, const float* a, const float* b) {
  return sum_of_products(n, [&](Line d, std::int64_t i) HWY_ATTR {
    return Pair<hn::VFromD<Line>>{hn::LoadU(d, a + i), hn::LoadU(d, b + i)};
  });
}

void direct(std::int64_t n, const float* v, float beta, float* p) {
  for_entries(n, [&](Line d, std::int64_t i) HWY_ATTR {
    hn::StoreU(hn::MulAdd(hn::Set(d, beta), hn::LoadU(d, p + i), hn::LoadU(d, v + i)), d, p + i);
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

HWY_EXPORT(start);
HWY_EXPORT(relax);
HWY_EXPORT(subtract);
HWY_EXPORT(mask_and_dot);
HWY_EXPORT(dot);
HWY_EXPORT(direct);
HWY_EXPORT(step);

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
void direct_entries(std::int64_t n, const float* v, float beta, float* p) {
  HWY_DYNAMIC_DISPATCH(direct)(n, v, beta, p);
}
void step_entries(std::int64_t n, float size, const float* q, float* r) {
  HWY_DYNAMIC_DISPATCH(step)(n, size, q, r);
}

} // namespace maille::deform
#endif
