// Moves the lanes of a mask to the front of a vector. Included once per vector target.

#if defined(MAILLE_PACKING_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MAILLE_PACKING_INL_HPP
#undef MAILLE_PACKING_INL_HPP
#else
#define MAILLE_PACKING_INL_HPP
#endif

#include "cast/sampling-inl.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace maille::render {
namespace HWY_NAMESPACE {

#if HWY_TARGET <= HWY_AVX3 // has an instruction for it

class Packing {
public:
  explicit HWY_INLINE Packing(M lanes) : lanes_(lanes) {}
  HWY_INLINE std::size_t n() const { return hn::CountTrue(DF(), lanes_); }
  HWY_INLINE V packed(V from) const { return hn::Compress(from, lanes_); }
  HWY_INLINE VI packed(VI from) const { return hn::Compress(from, hn::RebindMask(DI(), lanes_)); }

private:
  M lanes_;
};

#else

/// Order of lanes for every mask; hn::Compress of Highway 1.0.3 copies such a table to the stack each time.
struct LaneOrders {
  static constexpr std::size_t most = hn::MaxLanes(DF());
  static_assert(most <= 8);
  std::array<std::array<std::int32_t, most>, std::size_t{1} << most> of{};

  constexpr LaneOrders() {
    for (std::size_t set = 0; set < of.size(); ++set) {
      std::size_t n = 0;
      for (std::size_t lane = 0; lane < most; ++lane)
        if ((set >> lane & 1) != 0)
          of[set][n++] = static_cast<std::int32_t>(lane);
    }
  }
};
alignas(64) constexpr LaneOrders lane_orders;

class Packing {
public:
  explicit HWY_INLINE Packing(M lanes) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(DF(), lanes, bytes);
    set_ = bytes[0];
  }
  HWY_INLINE std::size_t n() const { return static_cast<std::size_t>(std::popcount(set_)); }
  HWY_INLINE V packed(V from) const {
    return hn::TableLookupLanes(from, hn::SetTableIndices(DF(), lane_orders.of[set_].data()));
  }
  HWY_INLINE VI packed(VI from) const {
    return hn::TableLookupLanes(from, hn::SetTableIndices(DI(), lane_orders.of[set_].data()));
  }

private:
  std::uint8_t set_;
};

#endif

} // namespace HWY_NAMESPACE
} // namespace maille::render
HWY_AFTER_NAMESPACE();

#endif
