#pragma once
/// The stored table, as text; its source file is made from studies/trade/table.csv when Maille is built.

#include <string_view>

namespace maille::studies {

std::string_view built_in_table_text();

} // namespace maille::studies
