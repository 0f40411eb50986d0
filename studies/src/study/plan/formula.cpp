/// Recursive descent: sum = product {(+|-) product}; product = power {(*|/) power}; power = sign [^ power];
/// sign = (-|+) power | number | name | "(" sum ")".
///
/// A name consists of letters, digits, `_`, `.`, `[` and `]`, like keys of scenes, and starts with a letter
/// or `_`.

#include "study/plan/formula.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace maille::studies {

namespace {

constexpr int deepest = 100; ///< upper bound of nested parentheses and signs

class Formula {
public:
  Formula(std::string_view text, const NamedNumbers* known) : text_(text), known_(known) {}

  double value() {
    const double value = sum();
    if (!text_.empty())
      fail("an operator");
    return value;
  }
  std::vector<std::string> names;

private:
  [[noreturn]] void fail(const char* expected) const {
    throw std::invalid_argument(
        fmt::format("{} in place of {}", text_.empty() ? "the end" : fmt::format("\"{}\"", text_), expected));
  }
  bool takes(char c) {
    text_.remove_prefix(std::min(text_.find_first_not_of(" \t"), text_.size()));
    const bool is_next = text_.starts_with(c);
    text_.remove_prefix(is_next ? 1 : 0);
    return is_next;
  }
  double sum() {
    for (double value = product();;)
      if (takes('+'))
        value += product();
      else if (takes('-'))
        value -= product();
      else
        return value;
  }
  double product() {
    for (double value = power();;)
      if (takes('*'))
        value *= power();
      else if (takes('/'))
        value /= power();
      else
        return value;
  }
  double power() {
    if (++depth_ > deepest)
      fail("fewer parentheses and signs");
    const double base = sign(), value = takes('^') ? std::pow(base, power()) : base;
    --depth_;
    return value;
  }
  double sign() {
    if (takes('-'))
      return -power();
    if (takes('+'))
      return power();
    if (!takes('('))
      return number_or_name();
    const double value = sum();
    if (!takes(')'))
      fail("\")\"");
    return value;
  }
  double number_or_name() {
    double number = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), number);
    if (error == std::errc{} && std::isfinite(number) && !text_.starts_with('i') && !text_.starts_with('n')) {
      text_.remove_prefix(end - text_.data());
      return number;
    }
    const auto is_of_name = [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '[' || c == ']';
    };
    const std::string name(text_.begin(), std::ranges::find_if_not(text_, is_of_name));
    if (name.empty() || (std::isalpha(static_cast<unsigned char>(name[0])) == 0 && name[0] != '_'))
      fail("a number or a name");
    text_.remove_prefix(name.size());
    names.push_back(name);
    if (known_ == nullptr)
      return 1;
    const auto found = std::ranges::find(*known_, name, &std::pair<std::string, double>::first);
    if (found == known_->end())
      throw std::invalid_argument(fmt::format("\"{}\", which is unknown", name));
    return found->second;
  }

  std::string_view text_; ///< remaining text
  const NamedNumbers* known_;
  int depth_ = 0;
};

} // namespace

double value_of_formula(std::string_view formula, const NamedNumbers& known) {
  return Formula(formula, &known).value();
}

std::vector<std::string> names_in_formula(std::string_view formula) {
  Formula reading(formula, nullptr);
  reading.value();
  return reading.names;
}

} // namespace maille::studies
