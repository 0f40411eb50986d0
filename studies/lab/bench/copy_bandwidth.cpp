#include "bench/bench_report.hpp"

#include <cstring>
#include <memory>
#include <thread>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace maille::lab {

namespace {

constexpr std::size_t line = 64; // bytes

/// Writes past the cache, so that no line is read only to be overwritten.
void streaming_copy(char* to, const char* from, std::size_t bytes) {
#if defined(__SSE2__)
  for (std::size_t i = 0; i < bytes; i += line)
    for (std::size_t part = 0; part < line; part += 16)
      _mm_stream_si128(reinterpret_cast<__m128i*>(to + i + part),
                       _mm_load_si128(reinterpret_cast<const __m128i*>(from + i + part)));
  _mm_sfence();
#else
  std::memcpy(to, from, bytes);
#endif
}

/// Runs `copy` on equal shares of the arrays.
template<class Copy>
void in_shares(int threads, std::size_t bytes, Copy&& copy) {
  const auto n = static_cast<std::size_t>(threads);
  const std::size_t share = bytes / n / line * line;
  std::vector<std::thread> team;
  for (std::size_t t = 1; t < n; ++t)
    team.emplace_back([&copy, share, t] { copy(t * share, share); });
  copy(0, share);
  for (std::thread& member : team)
    member.join();
}

} // namespace

double copy_bandwidth(std::size_t bytes, int repeats, int threads) {
  bytes = std::max(line, bytes / line * line);
  const auto array = [&] {
    std::unique_ptr<char, decltype(&std::free)> memory(static_cast<char*>(std::aligned_alloc(line, bytes)),
                                                       &std::free);
    if (!memory)
      throw std::bad_alloc();
    std::memset(memory.get(), 1, bytes);
    return memory;
  };
  const auto from = array(), to = array();
  const double plain = median_seconds(
      repeats, [] {},
      [&] {
        in_shares(threads, bytes,
                  [&](std::size_t at, std::size_t n) { std::memcpy(to.get() + at, from.get() + at, n); });
      });
  const double streaming = median_seconds(
      repeats, [] {},
      [&] {
        in_shares(threads, bytes,
                  [&](std::size_t at, std::size_t n) { streaming_copy(to.get() + at, from.get() + at, n); });
      });
  return 2.0 * static_cast<double>(bytes) / std::min(plain, streaming) / 1e9;
}

} // namespace maille::lab
