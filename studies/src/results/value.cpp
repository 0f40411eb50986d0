

#include "results/value.hpp"

#include <fmt/format.h>

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

const ResultTable<BenchCheck>& columns_of_checks() {
  static const ResultTable<BenchCheck> table = [] {
    ResultTable<BenchCheck> columns;
    const auto in_figures = [](double value) { return fmt::format("{:g}", value); };
    columns.add({"", "name", "", "of the figure"}, &BenchCheck::name);
    columns.add({}, {"check"}, [](const BenchCheck& check) { return "`" + check.name + "`"; });
    columns.add({"", "value", "", "in this run"}, {"value", 0, in_figures}, &BenchCheck::value);
    columns.add({"", "goal", "", "aimed for"}, &BenchCheck::goal);
    columns.add({}, {"goal"}, [](const BenchCheck& check) {
      return fmt::format("{} {:g}", check.larger_is_better ? "at least" : "at most", check.goal);
    });
    columns.add({"", "met", "", "whether it is reached"}, &BenchCheck::met);
    columns.add({}, {"met"}, [](const BenchCheck& check) { return check.met() ? "yes" : "**no**"; });
    for (const auto& [key, words] : {std::pair{"predicted", &BenchCheck::predicted},
                                     std::pair{"physical_limit", &BenchCheck::physical_limit}})
      columns.add({"", key, "", "in words"}, words).json_where([words = words](const BenchCheck& check) {
        return !(check.*words).empty();
      });
    return columns;
  }();
  return table;
}

} // namespace maille::studies
