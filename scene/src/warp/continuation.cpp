#include "warp/continuation.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace maille::warping {

namespace {

/// Distances in steps along axes are separable, so that two passes along each axis find the nearest. A layer
/// is processed along all axes while it is in the cache.
/// @tparam Steps an integer that holds twice as many steps as an image has
template<class Steps>
class Passes {
public:
  static constexpr Steps far = std::numeric_limits<Steps>::max() / 2;

  Passes(const Index3& size, std::vector<std::int32_t> known)
      : row_(static_cast<std::size_t>(size[0])), layer_(row_ * static_cast<std::size_t>(size[1])),
        nearest_(std::move(known)) {
    steps_.resize(nearest_.size());
    for (std::size_t layer = 0; layer < nearest_.size(); layer += layer_) {
      for (std::size_t row = layer; row < layer + layer_; row += row_)
        take_along(row);
      for (std::size_t row = layer + row_; row < layer + layer_; row += row_)
        take(row, row - row_, row_);
      for (std::size_t row = layer + layer_ - row_; row > layer; row -= row_)
        take(row - row_, row, row_);
      if (layer > 0)
        take(layer, layer - layer_, layer_);
    }
    for (std::size_t layer = nearest_.size(); layer > layer_; layer -= layer_)
      take(layer - 2 * layer_, layer - layer_, layer_);
  }
  std::vector<std::int32_t> nearest() && { return std::move(nearest_); }

private:
  /// Fills the gaps of a row; steps start at 0.
  void take_along(std::size_t first) {
    Steps* const steps = steps_.data() + first;
    std::int32_t* const nearest = nearest_.data() + first;
    for (std::size_t begin = 0, end = 0; begin < row_; begin = end + 1) {
      while (begin < row_ && nearest[begin] >= 0)
        ++begin;
      for (end = begin; end < row_ && nearest[end] < 0;)
        ++end;
      const std::int32_t before = begin > 0 ? nearest[begin - 1] : -1,
                         behind = end < row_ ? nearest[end] : -1;
      for (std::size_t i = begin; i < end; ++i) {
        const Steps to_before = before >= 0 ? static_cast<Steps>(i + 1 - begin) : far,
                    to_behind = behind >= 0 ? static_cast<Steps>(end - i) : far;
        steps[i] = std::min(to_before, to_behind);
        nearest[i] = to_behind < to_before ? behind : before;
      }
    }
  }
  /// Updates from an adjacent row or layer.
  void take(std::size_t to, std::size_t from, std::size_t count) {
    for (std::size_t i = 0; i < count; i += row_)
      if (is_any_nearer(to + i, from + i))
        take_row(to + i, from + i);
  }
  // Branch-free, so that compilers vectorise it.
  bool is_any_nearer(std::size_t to, std::size_t from) const {
    const Steps *const steps_from = steps_.data() + from, *const steps_to = steps_.data() + to;
    Steps any = 0;
    for (std::size_t i = 0; i < row_; ++i)
      any = static_cast<Steps>(any | (steps_from[i] + Steps{1} < steps_to[i] ? 1 : 0));
    return any != 0;
  }
  void take_row(std::size_t to, std::size_t from) {
    const Steps* const steps_from = steps_.data() + from;
    const std::int32_t* const nearest_from = nearest_.data() + from;
    Steps* const steps_to = steps_.data() + to;
    std::int32_t* const nearest_to = nearest_.data() + to;
#pragma GCC ivdep
    for (std::size_t i = 0; i < row_; ++i) {
      const std::int32_t is_nearer = steps_from[i] + 1 < steps_to[i] ? -1 : 0; // all bits
      nearest_to[i] ^= is_nearer & (nearest_from[i] ^ nearest_to[i]);
      steps_to[i] = std::min(static_cast<Steps>(steps_from[i] + 1), steps_to[i]);
    }
  }

  std::size_t row_, layer_; ///< voxels of a row, of a layer
  std::vector<Steps> steps_;
  std::vector<std::int32_t> nearest_;
};

} // namespace

std::vector<std::int32_t> nearest_known(const Index3& size, std::vector<std::int32_t> known) {
  const std::int64_t most = std::int64_t{size[0]} + size[1] + size[2];
  if (most < Passes<std::int16_t>::far)
    return Passes<std::int16_t>(size, std::move(known)).nearest();
  return Passes<std::int32_t>(size, std::move(known)).nearest();
}

} // namespace maille::warping
