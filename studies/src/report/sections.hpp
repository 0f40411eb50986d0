#pragma once
/// The sections of a page, one a kind of results.

#include "page_parts.hpp"

#include <filesystem>

namespace maille::studies {

/// What `compare --out` or `run --out` wrote (see write_results).
/// @param results the file's content; @param folder where the files for ParaView are
void add_answers_section(const PageData& results, const std::filesystem::path& folder, PageDraft& draft);
/// @param rows of one table of JSON lines of `maille study`; @param name of the file without ending
void add_study_section(const std::vector<PageData>& rows, const std::string& name, PageDraft& draft);
/// @param trade what `trade --json` says; @param pictures PNG or SVG files that it drew
void add_trade_section(const PageData& trade, const std::vector<std::filesystem::path>& pictures,
                       PageDraft& draft);

/// A picture file as it is. @param file PNG or SVG
PageData picture_of_file(const std::filesystem::path& file, std::string alt, std::string caption);

} // namespace maille::studies
