#pragma once
/// Builds that check every access: ten to fifty times as slow.

namespace maille::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

/// How many of a series of like cases are tried: a sanitizer has seen the code after a few of them, numbers
/// are judged by all of them elsewhere.
template<class Number>
constexpr Number cases(Number all, Number when_sanitized) {
  return is_sanitized ? when_sanitized : all;
}

} // namespace maille::test
