/// The names that studies know, without what stands behind them.

#include "choose/built_in_table.hpp"
#include "maille/studies/methods.hpp"

#include <algorithm>

namespace maille::studies {

std::vector<std::string> all_methods() {
  return {"limits", "dijkstra", "literal", "sweep", "relaxed", "coupled", "fem_q1", "fem_q2", "calculix"};
}

bool is_method(std::string_view name) {
  const auto names = all_methods();
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string default_reference(const std::vector<std::string>&) {
  return "fem_q1";
}

std::string_view built_in_table_text() {
  return {};
}

} // namespace maille::studies
