#pragma once
/// Memory of the arrays of one object.

#include <cstddef>
#include <span>
#include <utility>

namespace maille::deform {

/// Zeroed memory that starts on a cache line, or, where it is large, on a page of the largest kind, which
/// the system is asked for: streaming through it then misses the address cache a thousand times less often.
/// @throws std::bad_alloc
void* allocate_zeroed(std::size_t bytes);
void release_zeroed(void* memory, std::size_t bytes) noexcept;

/// A fixed number of numbers, zero at first. Holds exactly bytes() of memory.
template<class T>
class AlignedArray {
public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size)
      : data_(size > 0 ? static_cast<T*>(allocate_zeroed(size * sizeof(T))) : nullptr), size_(size) {}
  AlignedArray(AlignedArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  AlignedArray& operator=(AlignedArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~AlignedArray() { release_zeroed(data_, bytes()); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<T> all() { return {data_, size_}; }
  std::span<const T> all() const { return {data_, size_}; }

private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

} // namespace maille::deform
