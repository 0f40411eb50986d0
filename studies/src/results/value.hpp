#pragma once
/// Values of result columns, converted to and from text, JSON and CSV.

#include "maille/scene/answer.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

namespace maille::studies {

/// null: no value. Non-finite numbers stay numbers here, though JSON does not support them.
using Value = nlohmann::ordered_json;

/// All values of an enumeration, named by to_string.
template<class Enum>
struct Choices;
template<>
struct Choices<Status> {
  static constexpr std::array all{Status::done,        Status::clamped, Status::budget_reached,
                                  Status::interrupted, Status::refused, Status::failed};
};

template<class T>
inline constexpr bool is_optional = false;
template<class T>
inline constexpr bool is_optional<std::optional<T>> = true;

/// True if read_value supports the type; lists are only written.
template<class T>
inline constexpr bool is_readable =
    std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>;
template<class T>
inline constexpr bool is_readable<std::optional<T>> = is_readable<T>;

/// Integer within the range, from an integer or a double that holds it exactly; else nothing.
std::optional<std::int64_t> whole_number(const Value& value, std::int64_t least, std::int64_t most);

template<class T>
Value value_of(const T& figure) {
  if constexpr (is_optional<T>)
    return figure ? value_of(*figure) : Value();
  else if constexpr (std::is_enum_v<T>)
    return std::string(to_string(figure));
  else
    return figure;
}

/// Converts a value. @return false if it does not fit; `figure` is then unspecified
template<class T>
bool read_value(const Value& value, T& figure) {
  if constexpr (is_optional<T>) {
    figure.reset();
    return value.is_null() || read_value(value, figure.emplace());
  } else if constexpr (std::is_same_v<T, bool>) {
    if (value.is_boolean())
      figure = value.get<bool>();
    return value.is_boolean();
  } else if constexpr (std::is_integral_v<T>) {
    const auto whole = whole_number(value, std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
    figure = static_cast<T>(whole.value_or(0));
    return whole.has_value();
  } else if constexpr (std::is_floating_point_v<T>) {
    if (value.is_number())
      figure = value.get<T>();
    return value.is_number();
  } else if constexpr (std::is_enum_v<T>) {
    for (const T choice : Choices<T>::all)
      if (value.is_string() && value.get_ref<const std::string&>() == to_string(choice)) {
        figure = choice;
        return true;
      }
    return false;
  } else {
    if (value.is_string())
      figure = value.get<std::string>();
    return value.is_string();
  }
}

/// Description of values accepted by read_value.
template<class T>
std::string expected_of() {
  if constexpr (is_optional<T>)
    return expected_of<typename T::value_type>() + ", or nothing";
  else if constexpr (std::is_same_v<T, bool>)
    return "true or false";
  else if constexpr (std::is_integral_v<T>)
    return "a whole number from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
           std::to_string(std::numeric_limits<T>::max());
  else if constexpr (std::is_floating_point_v<T>)
    return "a number";
  else if constexpr (std::is_enum_v<T>) {
    std::string words;
    for (const T choice : Choices<T>::all)
      words += (words.empty() ? "one of " : ", ") + std::string(to_string(choice));
    return words;
  } else
    return "a text";
}

} // namespace maille::studies
