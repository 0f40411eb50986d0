#pragma once
/// Formulas of other numbers: `E_cross * ratio`, `(a + 2) / b ^ 0.5`.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::studies {

using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// Value of a formula of numbers, names, + - * / ^ and parentheses, with the usual precedence.
/// @throws std::invalid_argument with the text found, for a message after "found"
double value_of_formula(std::string_view formula, const NamedNumbers& known);

/// Names in a formula, in order of appearance.
std::vector<std::string> names_in_formula(std::string_view formula);

} // namespace maille::studies
