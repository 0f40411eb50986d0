#include "elastic/links/interval_field.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/links/interval_field_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Compiled once per kind of vector: see feasible/box/cone_kernel.cpp for what that forbids. Only differences,
// comparisons and maxima: the same bits on every machine.

HWY_BEFORE_NAMESPACE();
namespace maille::deform {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Many = hn::ScalableTag<double>;
using One = hn::CappedTag<double, 1>;

/// Calls visit(tag, low, difference, high) for the links from `first` on, a vector at a time. @return the
/// first remaining link
template<class D, class Visit>
HWY_INLINE int for_links(D d, const LinkRow& links, int first, Visit&& visit) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  int x = first;
  for (; x + lanes <= links.n; x += lanes) {
    const auto low = links.is_same ? hn::Set(d, links.low[0]) : hn::LoadU(d, links.low + x);
    const auto high = links.is_same ? hn::Set(d, links.high[0]) : hn::LoadU(d, links.high + x);
    visit(d, low, hn::Sub(hn::LoadU(d, links.next + x), hn::LoadU(d, links.here + x)), high);
  }
  return x;
}

bool any_outside(const LinkRow& links, double tolerance) {
  bool is_one = false;
  const auto look = [&](auto d, auto low, auto difference, auto high) HWY_ATTR {
    const auto more = hn::Set(d, tolerance);
    const auto is_outside =
        hn::Or(hn::Lt(difference, hn::Sub(low, more)), hn::Gt(difference, hn::Add(high, more)));
    is_one = is_one || !hn::AllFalse(d, is_outside);
  };
  for_links(One(), links, for_links(Many(), links, 0, look), look);
  return is_one;
}

double excess(const LinkRow& links) {
  const Many many;
  auto worst = hn::Zero(many);
  const int rest = for_links(many, links, 0, [&](auto, auto low, auto difference, auto high) HWY_ATTR {
    worst = hn::Max(worst, hn::Max(hn::Sub(low, difference), hn::Sub(difference, high)));
  });
  auto last = hn::Zero(One());
  for_links(One(), links, rest, [&](auto, auto low, auto difference, auto high) HWY_ATTR {
    last = hn::Max(last, hn::Max(hn::Sub(low, difference), hn::Sub(difference, high)));
  });
  const double of_rest = hn::GetLane(last), of_many = hn::GetLane(hn::MaxOfLanes(many, worst));
  return of_rest > of_many ? of_rest : of_many;
}

} // namespace HWY_NAMESPACE
} // namespace maille::deform
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace maille::deform {

HWY_EXPORT(any_outside);
HWY_EXPORT(excess);

bool is_any_outside(const LinkRow& links, double tolerance) {
  return HWY_DYNAMIC_DISPATCH(any_outside)(links, tolerance);
}
double largest_excess(const LinkRow& links) {
  return HWY_DYNAMIC_DISPATCH(excess)(links);
}

} // namespace maille::deform
#endif
