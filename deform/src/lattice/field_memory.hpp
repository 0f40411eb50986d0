#pragma once
/// Memory of the fields that a solve works with.

#include <cstddef>
#include <type_traits>

namespace maille::deform {

/// Zeroed memory that starts on a cache line, in pages of the largest kind where the system grants them:
/// those come in a tenth of the time. Fields of some dozens of kilobytes share such pages, so a field may
/// take up to half a MiB more than its bytes. No memory is kept once the fields are gone.
/// @throws std::bad_alloc
void* allocate_field(std::size_t bytes);
void release_field(void* memory, std::size_t bytes) noexcept;

/// An array of numbers in such memory, zero at first: one per node where few nodes have anything.
template<class Number>
class FieldOf {
  static_assert(std::is_arithmetic_v<Number>);

public:
  explicit FieldOf(std::size_t size)
      : values_(static_cast<Number*>(allocate_field(size * sizeof(Number)))), size_(size) {}
  FieldOf(const FieldOf&) = delete;
  FieldOf& operator=(const FieldOf&) = delete;
  ~FieldOf() { release_field(values_, size_ * sizeof(Number)); }

  Number& operator[](std::size_t i) { return values_[i]; }
  Number* begin() { return values_; }
  Number* end() { return values_ + size_; }
  std::size_t size() const { return size_; }

private:
  Number* values_;
  std::size_t size_;
};

} // namespace maille::deform
