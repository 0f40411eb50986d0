#pragma once
/// The newest of what one thread makes, for one other thread, without either waiting.

#include <array>
#include <atomic>
#include <cstdint>

namespace maille::deform {

/// A double buffer, and a third place between its two so that the writer need not wait until the reader has looked: the writer fills one
/// place, the reader reads another, and the newest whole one lies between them. What the reader never took is overwritten.
///
/// One writer, one reader. Places are never made nor freed; what they hold (memory, counted pointers) is let go by the writer, when
/// it fills them again.
template<class T>
class TripleBuffer {
public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& value) : places_{value, value, value} {}

  /// The writer's: to be filled wholly, as it holds something older.
  T& back() { return places_[back_]; }
  /// The writer's: what is in back() is now the newest.
  void publish() { back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & index; }
  void publish(const T& value) {
    back() = value;
    publish();
  }

  /// The reader's: takes the newest. @return whether there was something newer
  bool update() {
    if ((middle_.load(std::memory_order_relaxed) & fresh) == 0)
      return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & index;
    return true;
  }
  /// The reader's: what it took last.
  const T& front() const { return places_[front_]; }

private:
  static constexpr std::uint32_t index = 3, fresh = 4;
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

  std::array<T, 3> places_{};
  alignas(64) std::uint32_t back_ = 0;
  alignas(64) std::uint32_t front_ = 1;
  alignas(64) std::atomic<std::uint32_t> middle_{2};
};

} // namespace maille::deform
