#include "maille/deform/solve.hpp"

#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/propagate/literal.hpp"
#include "maille/deform/relax/sweep.hpp"

#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace maille::deform {

namespace {

struct Method {
  std::string_view name;
  Answer (*solve)(const Scene&, const Control&);
};

constexpr std::array<Method, 3> all_methods{
    {{"limits", solve_limits}, {"literal", solve_literal}, {"sweep", solve_sweep}}};

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
