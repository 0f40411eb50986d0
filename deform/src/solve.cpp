#include "maille/deform/solve.hpp"

#include "maille/deform/propagate/dispatch.hpp"
#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/propagate/literal.hpp"
#include "maille/deform/relax/sweep.hpp"
#include "memory_check.hpp"
#include "method.hpp"

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace maille::deform {

namespace {

struct Method {
  std::string_view name;
  Answer (*solve)(const Scene&, const Control&);
  std::int64_t (*bytes)(const Scene&); ///< that it needs at most, by what can be told without limits
};

/// `limits` by shortest paths whatever the scene: the oracle of the ways that the dispatcher takes.
Answer solve_dijkstra(const Scene& scene, const Control& control) {
  Answer answer = solve_limits(scene, control);
  answer.method = "dijkstra";
  return answer;
}

/// Refuses by itself, by the plan of the way that it takes.
std::int64_t bytes_for_limits(const Scene& scene) {
  return bytes_at_least(scene);
}

constexpr std::array<Method, 4> all_methods{{{"limits", solve_by_cheapest_way, bytes_for_limits},
                                             {"dijkstra", solve_dijkstra, bytes_for_dijkstra},
                                             {"literal", solve_literal, bytes_for_literal},
                                             {"sweep", solve_sweep, bytes_for_sweep}}};

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
    if (known.name == method) {
      std::string reason = reason_to_refuse(scene, method);
      if (reason.empty())
        reason = reason_of_memory(method, known.bytes(scene), control);
      return reason.empty() ? known.solve(scene, control) : refusal(std::string(method), std::move(reason));
    }
  return refusal(std::string(method), fmt::format("there is no method `{}` here; known are {}", method,
                                                  fmt::join(methods(), ", ")));
}

std::int64_t bytes_needed(const Scene& scene, std::string_view method) {
  if (method == "limits")
    return plan_limits(scene, LinkLimits(scene)).bytes;
  for (const Method& known : all_methods)
    if (known.name == method)
      return known.bytes(scene);
  return 0;
}

} // namespace maille::deform
