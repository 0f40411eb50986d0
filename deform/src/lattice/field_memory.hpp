#pragma once
/// Memory of the fields that a solve works with, and of the arrays of one object; fields as rows along x.

#include "maille/scene/grid.hpp"

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

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

template<class T>
struct Field {
  T* data = nullptr;
  Index3 nodes{1, 1, 1};
  std::int64_t row_stride = 0;  ///< from a node to the next along y
  std::int64_t slab_stride = 0; ///< from a node to the next along z

  T* row(int y, int z) const { return data + y * row_stride + z * slab_stride; }
  T& at(const Index3& node) const { return row(node[1], node[2])[node[0]]; }
};

/// The numbers of a grid in its own order, without padding.
template<class T>
Field<T> dense_field(const Grid& grid, T* data) {
  const Index3& n = grid.nodes();
  return {data, n, n[0], std::int64_t{1} * n[0] * n[1]};
}

} // namespace maille::deform
