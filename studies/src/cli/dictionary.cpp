#include "cli/dictionary.hpp"

#include "compare/comparison_columns.hpp"
#include "mechanics/mechanics_report.hpp"
#include "study/columns.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

namespace maille::studies {

namespace {

std::string dictionary_of(const char* title, const Columns& columns) {
  const auto line = [](const std::string& csv, const std::string& json, const std::string& unit,
                       const std::string& meaning) {
    const auto shown = [](const std::string& text) { return text.empty() ? "-" : text; };
    return fmt::format("  {:<23} {:<29} {:<9} {}\n", shown(csv), shown(json), shown(unit), meaning);
  };
  std::string text = fmt::format("{}\n{}", title, line("CSV", "JSON", "unit", "meaning"));
  for (const Column& column : columns.list())
    if (!column.csv.empty() || !column.json.empty())
      text += line(column.is_open ? "(one each)" : column.csv, column.json, column.unit, column.meaning);
  return text;
}

} // namespace

std::string columns_in_words() {
  return dictionary_of("compare, a row a method:", columns_of_comparison()) + "\n" +
         dictionary_of("mechanics of run and compare, a row a label, a material or the body:",
                       columns_of_parts()) +
         "\n" + dictionary_of("mechanics, a row a hold, a move or a load:", columns_of_resultants()) + "\n" +
         dictionary_of("run --steps, a row a step:", columns_of_curve()) + "\n" +
         dictionary_of("study, a row a case and a method:", columns_of_study()) + "\n" +
         dictionary_of("trade, a row a method, a lattice and a tolerance:", columns_of_trade());
}

} // namespace maille::studies
