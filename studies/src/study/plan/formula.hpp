#pragma once
/// Numbers that follow from others: `E_cross * ratio`, `(a + 2) / b ^ 0.5`.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::studies {

using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// The formula's value: numbers, names, + - * / ^ and parentheses, with the usual precedence.
/// @throws std::invalid_argument with what is there instead: for a message behind "found"
double value_of_formula(std::string_view formula, const NamedNumbers& known);

/// The names in a formula, in their order.
std::vector<std::string> names_in_formula(std::string_view formula);

} // namespace maille::studies
