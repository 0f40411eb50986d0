#include "study/plan/dotted_key.hpp"

#include <charconv>

namespace maille::studies {

namespace {

/// The child of a table by name or of an array by index; nullptr where there is none.
toml::node* child(toml::node& parent, std::string_view name) {
  if (toml::table* table = parent.as_table())
    return table->get(name);
  toml::array* array = parent.as_array();
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (!array || error != std::errc{} || end != name.data() + name.size())
    return nullptr;
  return array->get(index);
}

void put(toml::node& parent, std::string_view name, const toml::node& value) {
  value.visit([&](const auto& concrete) {
    if (toml::table* table = parent.as_table()) {
      table->insert_or_assign(name, concrete);
      return;
    }
    std::size_t index = 0;
    std::from_chars(name.data(), name.data() + name.size(), index);
    toml::array& array = *parent.as_array();
    array.replace(array.cbegin() + static_cast<std::ptrdiff_t>(index), concrete);
  });
}

} // namespace

DottedNode find_dotted(toml::table& root, std::string_view key) {
  DottedNode found{&root, ""};
  for (std::size_t start = 0; start <= key.size();) {
    const std::size_t dot = std::min(key.find('.', start), key.size());
    toml::node* next = child(*found.node, key.substr(start, dot - start));
    if (!next)
      return {nullptr, found.last};
    found = {next, std::string(key.substr(0, dot))};
    start = dot + 1;
  }
  return found;
}

void replace_dotted(toml::table& root, std::string_view key, const std::string& value) {
  const toml::table document = toml::parse("value = " + value);
  const std::size_t dot = key.rfind('.');
  toml::node& parent = dot == std::string_view::npos ? root : *find_dotted(root, key.substr(0, dot)).node;
  put(parent, dot == std::string_view::npos ? key : key.substr(dot + 1), *document.get("value"));
}

} // namespace maille::studies
