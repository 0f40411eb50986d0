#include "maille/scene/method.hpp"

#include <algorithm>

namespace maille {

namespace {

/// In the order of the enumeration.
constexpr std::array<std::string_view, every_method.size()> names{
    "limits", "dijkstra", "literal", "sweep", "relaxed", "coupled", "fem_q1", "fem_q2", "calculix"};

} // namespace

std::string_view to_string(Method method) {
  return names.at(static_cast<std::size_t>(method));
}

std::optional<Method> method_from_string(std::string_view name) {
  const auto* const found = std::ranges::find(names, name);
  return found == names.end() ? std::nullopt
                              : std::optional(every_method[static_cast<std::size_t>(found - names.begin())]);
}

bool has_stress(std::string_view method) {
  constexpr std::array<std::string_view, 4> without{"limits", "literal", "sweep", "dijkstra"};
  return std::ranges::find(without, method) == without.end();
}

} // namespace maille
