/// Names of methods, without their implementation.

#include "compare/methods.hpp"

#include <algorithm>

namespace maille::studies {

std::vector<std::string> all_methods() {
  std::vector<std::string> names;
  for (const Method method : every_method)
    names.emplace_back(to_string(method));
  return names;
}

bool is_method(std::string_view name) {
  return method_from_string(name).has_value();
}

std::string default_reference(const std::vector<std::string>& methods) {
  const bool fine = std::find(methods.begin(), methods.end(), "fem_q2") != methods.end();
  return fine ? "fem_q2" : "fem_q1";
}

} // namespace maille::studies
