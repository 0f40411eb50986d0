#pragma once
/// Detection of sanitizer builds, which are ten to fifty times as slow.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) // g++ says so
#define MAILLE_CHECKS_ACCESS
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) // clang
#define MAILLE_CHECKS_ACCESS
#endif
#endif

namespace maille::test {

#ifdef MAILLE_CHECKS_ACCESS
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

/// Number of cases in a series: with a sanitizer a few cases cover the code; other builds check the values of
/// all of them.
template<class Number>
constexpr Number cases(Number all, Number when_sanitized) {
  return is_sanitized ? when_sanitized : all;
}

} // namespace maille::test
