#include "results/value.hpp"

#include <charconv>
#include <cmath>
#include <utility>

namespace maille::studies {

std::optional<std::int64_t> whole_number(const Value& value, std::int64_t least, std::int64_t most) {
  std::int64_t whole = 0;
  if (value.is_number_float()) {
    constexpr double exact = 9007199254740992.0; // 2^53: beyond, a double stands for several
    const double number = value.get<double>();
    if (!(std::abs(number) <= exact) || number != std::floor(number))
      return std::nullopt;
    whole = static_cast<std::int64_t>(number);
  } else if (value.is_number_integer() &&
             !(value.is_number_unsigned() && !std::in_range<std::int64_t>(value.get<std::uint64_t>())))
    whole = value.get<std::int64_t>();
  else
    return std::nullopt;
  return whole >= least && whole <= most ? std::optional(whole) : std::nullopt;
}

Value number_in_cell(const std::string& text) {
  if (text.empty())
    return nullptr;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? Value(number) : Value(text);
}

} // namespace maille::studies
