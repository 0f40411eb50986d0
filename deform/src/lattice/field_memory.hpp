#pragma once
/// Memory of the fields that a solve works with, and of the arrays of one object; fields as rows along x.
///
/// All memory is zeroed, starts on a cache line, and is charged to the open arena. Results do not depend on
/// its place.

#include "maille/base/arena.hpp"
#include "maille/base/grid.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

namespace maille::deform {

/// Numbers of float32 or int32 in a cache line; rows of fields are padded to whole lines.
inline constexpr int line_of_floats = 16;
/// In lists of indices: none.
inline constexpr std::int32_t no_index = -1;

/// Range of layers of cells.
struct LayerRange {
  int first = 0, end = 0;
};
/// Range of planes of nodes; layer z is between planes z and z + 1.
struct PlaneRange {
  int first = 0, end = 0;
};

/// Zeroed memory that starts on a cache line. From 1.5 MiB on it is mapped, on large pages where the system
/// grants them; smaller arrays lie beside others (allocate_array).
/// @throws std::bad_alloc
void* allocate_zeroed(std::size_t bytes, Charge& charge);
void release_zeroed(void* memory, std::size_t bytes) noexcept;

/// A fixed number of numbers, zero at first, which an open arena counts.
template<class T>
class AlignedArray {
  static_assert(std::is_arithmetic_v<T>);

public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size)
      : data_(size > 0 ? static_cast<T*>(allocate_zeroed(size * sizeof(T), charge_)) : nullptr), size_(size) {
  }
  AlignedArray(AlignedArray&& other) noexcept
      : charge_(std::move(other.charge_)), data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)) {}
  AlignedArray& operator=(AlignedArray&& other) noexcept {
    std::swap(charge_, other.charge_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~AlignedArray() { release_zeroed(data_, size_ * sizeof(T)); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  std::span<T> all() { return {data_, size_}; }
  std::span<const T> all() const { return {data_, size_}; }

private:
  Charge charge_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Scratch memory of at least `size` numbers for the calling thread. It stays for the next loop of that name,
/// so no arena counts it.
template<class T, class Name>
T* scratch_of_thread(std::size_t size) {
  thread_local AlignedArray<T> scratch;
  if (scratch.size() < size) {
    const Arena::Open outside(nullptr);
    scratch = AlignedArray<T>(size);
  }
  return scratch.data();
}

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
