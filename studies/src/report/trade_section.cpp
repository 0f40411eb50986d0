#include "page_parts.hpp"

#include <fmt/format.h>

namespace maille::studies {

namespace {

PageData table_of(const PageData& trade, const std::string& id) {
  const std::vector<PageData> rows(at(trade, "rows").begin(), at(trade, "rows").end());
  PageData table{
      {"id", id},
      {"caption", "Every method on every lattice and to every tolerance; a click on a header sorts"},
      {"columns",
       {column("method", false), column("spacing", true, "of the lattice over the scene's"),
        column("nodes", true), column("tolerance", true), column("status", false), column("total", true),
        column("memory", true), column("iterations", true), column("L2 error", true),
        column("max error", true),
        column("front", false,
               "nothing is both nearer and quicker (time), or both nearer and smaller (memory)")}},
      {"rows", PageData::array()}};
  add_measure_columns(rows, table["columns"]);
  for (const PageData& row : rows) {
    std::string front = at(row, "on_front", "time") == true ? "time" : "";
    if (at(row, "on_front", "memory") == true)
      front += front.empty() ? "memory" : ", memory";
    PageData cells{text_cell(plain(at(row, "method")))};
    for (const char* key : {"spacing_factor", "nodes", "tolerance"})
      cells.push_back(number_cell(plain(at(row, key)), at(row, key)));
    cells.push_back(text_cell(plain(at(row, "status"))));
    cells.push_back(number_cell(seconds(at(row, "seconds", "total")), at(row, "seconds", "total")));
    cells.push_back(number_cell(bytes(at(row, "bytes")), at(row, "bytes")));
    cells.push_back(number_cell(plain(at(row, "iterations")), at(row, "iterations")));
    for (const char* norm : {"relative_l2", "relative_max"})
      cells.push_back(number_cell(percent(at(row, "error", norm)), at(row, "error", norm)));
    cells.push_back(text_cell(front));
    add_measure_cells(rows, row, cells);
    table["rows"].push_back({{"cells", std::move(cells)}});
  }
  return table;
}

} // namespace

PageData picture_of_file(const std::filesystem::path& file, std::string alt, std::string caption) {
  return picture(bytes_of_file(file), std::move(alt), std::move(caption),
                 file.extension() == ".svg" ? "image/svg+xml" : "image/png");
}

void add_what_was_asked(const PageData& asked, PageData& run) {
  if (at(asked, "scene_text").is_string())
    run["scene"] = {{"file", std::filesystem::path(plain(at(asked, "scene_file"))).filename().string()},
                    {"text", plain(at(asked, "scene_text"))},
                    {"explain", plain(at(asked, "explanation"))}};
  if (const PageData command = at(asked, "command"); command.is_string())
    run["command"] = command;
}

void add_trade_section(const PageData& trade, const std::vector<std::filesystem::path>& pictures,
                       PageDraft& draft) {
  const std::string scene = plain(at(trade, "scene")), title = plain(at(trade, "title"));
  PageData run{{"id", id_of(scene + "-trade")}, {"heading", "Trade: " + (title.empty() ? scene : title)}};
  run["summary"] =
      fmt::format("{}D, {} cells, {} nodes, {} thread{}, errors against {} ({}).",
                  plain(at(trade, "dimension")), plain(at(trade, "cells")), plain(at(trade, "nodes")),
                  plain(at(trade, "threads")), at(trade, "threads") == 1 ? "" : "s",
                  plain(at(trade, "reference")), plain(at(trade, "reference_algorithm")));
  run["notes"] = PageData::array();
  if (const PageData error = at(trade, "reference_error", "relative_l2"); error.is_number())
    run["notes"].push_back(fmt::format("The reference is itself some {} (L2) off at most.", percent(error)));
  run["pictures"] = PageData::array();
  for (const auto& file : pictures)
    run["pictures"].push_back(
        picture_of_file(file, "Fronts of error over time and over memory; the table has the figures",
                        "Error over time and over memory, with the fronts of what nothing beats"));
  run["table"] = table_of(trade, id_of(scene + "-trade-table"));
  add_what_was_asked(trade, run);
  draft.runs.push_back(std::move(run));
}

} // namespace maille::studies
