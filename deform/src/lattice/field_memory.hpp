#pragma once
/// Memory of the fields that a solve works with, and of the arrays of one object; fields as rows along x.
///
/// All memory is zeroed, starts on a cache line, and is charged to the open arena. Fields of 64 KiB and more
/// lie in large pages, several small ones in one. Results do not depend on the placement.

#include "maille/scene/arena.hpp"
#include "maille/scene/grid.hpp"

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

namespace maille::deform {

/// Range of layers of cells.
struct LayerRange {
  int first = 0, end = 0;
};
/// Range of planes of nodes; layer z is between planes z and z + 1.
struct PlaneRange {
  int first = 0, end = 0;
};

inline constexpr std::size_t large_page = std::size_t{2} << 20; ///< of the largest kind
/// Fields from here on are mapped for themselves; smaller ones share a large page.
inline constexpr std::size_t least_mapped = large_page / 4 * 3;
/// Smaller fields are the allocator's.
inline constexpr std::size_t least_shared = std::size_t{64} << 10;

/// Zeroed memory in pages of the largest kind where the system grants them: those come in a tenth of the
/// time. Fields of some dozens of kilobytes share such pages, so a field may take up to half a MiB more than
/// its bytes. No memory is kept once the fields are gone.
/// @param charge of what is set aside; pages that fields share are charged as a whole, with the first field,
///        and shared within one arena alone
/// @throws std::bad_alloc
void* allocate_field(std::size_t bytes, Charge& charge);
void release_field(void* memory, std::size_t bytes) noexcept;

/// Zeroed memory that starts on a cache line, or, where it is large, on a page of the largest kind, which
/// the system is asked for: streaming through it then misses the address cache a thousand times less often.
/// @throws std::bad_alloc
void* allocate_zeroed(std::size_t bytes, Charge& charge);
void release_zeroed(void* memory, std::size_t bytes) noexcept;

/// A fixed number of numbers, zero at first, which an open arena counts.
template<class T, void* (*allocate)(std::size_t, Charge&), void (*release)(void*, std::size_t) noexcept>
class ZeroedArray {
  static_assert(std::is_arithmetic_v<T>);

public:
  ZeroedArray() = default;
  explicit ZeroedArray(std::size_t size)
      : data_(size > 0 ? static_cast<T*>(allocate(size * sizeof(T), charge_)) : nullptr), size_(size) {}
  ZeroedArray(ZeroedArray&& other) noexcept
      : charge_(std::move(other.charge_)), data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)) {}
  ZeroedArray& operator=(ZeroedArray&& other) noexcept {
    std::swap(charge_, other.charge_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~ZeroedArray() { release(data_, size_ * sizeof(T)); }

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
template<class T>
using AlignedArray = ZeroedArray<T, allocate_zeroed, release_zeroed>;
/// One number per node where few nodes have anything.
template<class T>
using FieldOf = ZeroedArray<T, allocate_field, release_field>;

/// At least `size` numbers for the calling thread alone, for loops that need some beside their arguments: a
/// few planes. They stay for the next loop of that name, so no arena counts them.
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
