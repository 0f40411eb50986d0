#include "warp/continuation.hpp"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace maille::warping {

namespace {

constexpr std::int32_t far = std::numeric_limits<std::int32_t>::max() / 2;

/// Distances in steps along axes add up axis by axis, so that two passes along each axis find the nearest.
class Passes {
public:
  Passes(const Index3& size, const std::vector<bool>& is_known)
      : size_(size), steps_(is_known.size(), far), nearest_(is_known.size(), -1) {
    for (std::size_t voxel = 0; voxel < is_known.size(); ++voxel)
      if (is_known[voxel]) {
        steps_[voxel] = 0;
        nearest_[voxel] = static_cast<std::int32_t>(voxel);
      }
  }
  void along(std::size_t axis) {
    const std::size_t stride = axis == 0 ? 1
                               : axis == 1
                                   ? static_cast<std::size_t>(size_[0])
                                   : static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
    const auto length = static_cast<std::size_t>(size_[axis]);
    const std::size_t block = stride * length;
    for (std::size_t first = 0; first < steps_.size(); first += block) {
      for (std::size_t row = 1; row < length; ++row)
        take(first + row * stride, first + (row - 1) * stride, stride);
      for (std::size_t row = length - 1; row-- > 0;)
        take(first + row * stride, first + (row + 1) * stride, stride);
    }
  }
  std::vector<std::int32_t> nearest() && { return std::move(nearest_); }

private:
  void take(std::size_t to, std::size_t from, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      if (steps_[from + i] + 1 < steps_[to + i]) {
        steps_[to + i] = steps_[from + i] + 1;
        nearest_[to + i] = nearest_[from + i];
      }
  }

  Index3 size_;
  std::vector<std::int32_t> steps_, nearest_;
};

} // namespace

std::vector<std::int32_t> nearest_known(const Index3& size, const std::vector<bool>& is_known) {
  Passes passes(size, is_known);
  for (std::size_t axis = 0; axis < 3; ++axis)
    passes.along(axis);
  return std::move(passes).nearest();
}

} // namespace maille::warping
