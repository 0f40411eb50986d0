/// What stands in for parts of Maille that fuzzers are built without.

#include "choose/built_in_table.hpp"
#include "maille/scene/answer.hpp"
#include "maille/studies/methods.hpp"

#include <cstdint>

/// For maille::available_memory() (the linker's --wrap): sizes are held against this.
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv();
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv() {
  return std::int64_t{1} << 20;
}

/// The names that studies know, without what stands behind them.
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

std::string default_reference(const std::vector<std::string>&) {
  return "fem_q1";
}

std::string_view built_in_table_text() {
  return {};
}

} // namespace maille::studies
