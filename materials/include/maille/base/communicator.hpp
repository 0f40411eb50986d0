#pragma once
/// Interface of several processes that solve one scene together.

#include <cstddef>
#include <span>
#include <vector>

namespace maille {

/// Ranks 0 ... size() - 1 call the same functions in the same order. Implementations join them by MPI
/// (fem_ref) or as threads of one process (tests/support).
class Communicator {
public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool is_first() const { return rank() == 0; }

  /// Data for a rank, or memory for data from it; both ranks use the same length.
  struct Part {
    int rank = 0;
    std::span<std::byte> bytes;
  };
  /// Returns when all is sent and received. A rank occurs at most once in each list; none sends to itself.
  virtual void exchange(std::span<const Part> to, std::span<const Part> from) = 0;
};

/// Bytes of numbers, for sending and receiving.
template<class Numbers>
std::span<std::byte> bytes_of(Numbers& numbers) {
  return std::as_writable_bytes(std::span(numbers));
}

/// Copies the first rank's numbers to every rank.
template<class Number>
void share_from_first(Communicator& all, std::span<Number> numbers) {
  std::vector<Communicator::Part> parts;
  for (int rank = 1; rank < all.size() && all.is_first(); ++rank)
    parts.push_back({rank, std::as_writable_bytes(numbers)});
  const Communicator::Part from_first{0, std::as_writable_bytes(numbers)};
  all.is_first() ? all.exchange(parts, {}) : all.exchange({}, std::span(&from_first, 1));
}

/// One number of every rank, by rank.
template<class Number>
std::vector<Number> from_every_rank(Communicator& all, Number own) {
  std::vector<Number> numbers(all.size(), own);
  std::vector<Communicator::Part> to, from;
  for (int other = 0; other < all.size(); ++other)
    if (other != all.rank()) {
      to.push_back({other, std::as_writable_bytes(std::span(&own, 1))});
      from.push_back({other, std::as_writable_bytes(std::span(&numbers[other], 1))});
    }
  all.exchange(to, from);
  return numbers;
}

} // namespace maille
