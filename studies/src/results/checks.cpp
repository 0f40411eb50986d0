#include "results/checks.hpp"

#include <fmt/format.h>

namespace maille::studies {

const ResultTable<BenchCheck>& columns_of_checks() {
  static const ResultTable<BenchCheck> table([](ResultTable<BenchCheck>& columns) {
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
  });
  return table;
}

} // namespace maille::studies
