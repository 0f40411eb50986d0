#pragma once
/// How deep tables stand in tables, before anything is built from the text.

#include <optional>
#include <string_view>

namespace maille {

/// The line (from 1) of the first key of TOML that has more than `most` dots, those of the keys around it
/// counted; nothing where there is none. Every dot is a table within a table, and tables go one inside the
/// other, on the stack: a key of 100,000 parts overruns it. (toml++ bounds brackets by itself, keys from
/// version 3.4 on.)
/// Cost  one pass
std::optional<int> line_of_deep_key(std::string_view text, int most);

} // namespace maille
