#pragma once
/// What the readers of holds, moves and loads share.

#include "conditions/prescribe.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>

namespace maille::reader {

/// A vector of quantities: one for each of the scene's axes (one number in one dimension), or three of which
/// those beyond the scene's dimension are 0.
std::optional<Vec3> read_vector(TableReader& table, std::string_view key, Dimension unit, int dimension);

/// Text of a value as the file has it.
std::string in_words(const toml::node& node);

/// `where` of a table that has one.
Asked asked_where(TableReader& table);

/// Calls `read` with a reader for every table of the array `key`.
template<class Read>
void for_each_table(TableReader& root, const char* key, Read&& read) {
  const toml::node* node = root.find(key);
  if (!node)
    return;
  const auto* list = node->as_array();
  if (!list || !list->is_array_of_tables()) {
    root.fault(key, fmt::format("tables [[{}]]", key), describe(*node));
    return;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    TableReader table(*list->get(i)->as_table(), fmt::format("{}[{}]", root.path_of(key), i + 1),
                      root.faults());
    read(table);
    table.finish();
  }
}

} // namespace maille::reader
