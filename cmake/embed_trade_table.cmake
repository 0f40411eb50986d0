# Writes a C++ file that holds the text of TABLE, for built_in_table_text.
file(READ ${TABLE} content)
file(WRITE ${OUTPUT} "// Made from studies/trade/table.csv by cmake/embed_trade_table.cmake.\n"
  "#include \"choose/built_in_table.hpp\"\n\nnamespace maille::studies {\n"
  "std::string_view built_in_table_text() {\n  return R\"csv(${content})csv\";\n}\n} // namespace maille::studies\n")
