#pragma once
/// The sections of a page, one a kind of results.

#include "page_parts.hpp"

#include <filesystem>

namespace maille::studies {

/// What `compare --out` or `run --out` wrote (see write_results).
/// @param results the file's content; @param folder where the files for ParaView are
void add_answers_section(const PageData& results, const std::filesystem::path& folder, PageDraft& draft);
/// @param rows of one table of JSON lines of `maille study`; @param name of the file without ending
/// @param about what `study` wrote beside it; null where there is none
void add_study_section(const std::vector<PageData>& rows, const std::string& name, const PageData& about,
                       PageDraft& draft);
/// @param trade what `trade --json` says; @param pictures PNG or SVG files that it drew
void add_trade_section(const PageData& trade, const std::vector<std::filesystem::path>& pictures,
                       PageDraft& draft);

/// The scene's or the study's file, what `explain` says of it, and the command, where `asked` has them (see
/// asked_about).
void add_what_was_asked(const PageData& asked, PageData& run);

/// A picture file as it is. @param file PNG or SVG
PageData picture_of_file(const std::filesystem::path& file, std::string alt, std::string caption);

} // namespace maille::studies
