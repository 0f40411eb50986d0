#include "maille/deform/solve.hpp"

#include "maille/deform/propagate/dispatch.hpp"
#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/propagate/literal.hpp"
#include "maille/deform/relax/relaxed.hpp"
#include "maille/deform/relax/sweep.hpp"
#include "method.hpp"

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace maille::deform {

namespace {

struct Method {
  std::string_view name;
  Answer (*solve)(const Scene&, const Control&);
};

/// `limits` by shortest paths whatever the scene: the oracle of the ways that the dispatcher takes.
Answer solve_dijkstra(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "dijkstra"); !reason.empty())
    return refusal("dijkstra", std::move(reason));
  Answer answer = solve_limits(scene, control);
  answer.method = "dijkstra";
  return answer;
}

constexpr std::array<Method, 5> all_methods{{{"limits", solve_by_cheapest_way},
                                             {"dijkstra", solve_dijkstra},
                                             {"literal", solve_literal},
                                             {"sweep", solve_sweep},
                                             {"relaxed", solve_relaxed}}};

} // namespace

const std::vector<std::string_view>& methods() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const Method& method : all_methods)
      list.push_back(method.name);
    return list;
  }();
  return names;
}

Answer solve(const Scene& scene, std::string_view method, const Control& control) {
  for (const Method& known : all_methods)
    if (known.name == method)
      return known.solve(scene, control);
  return refusal(std::string(method), fmt::format("there is no method `{}` here; known are {}", method,
                                                  fmt::join(methods(), ", ")));
}

} // namespace maille::deform
