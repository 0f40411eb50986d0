#pragma once
/// The sections of a page, one a kind of results; texts are compiled in (see cmake/embed_texts.cmake).

#include "maille/scene/answer.hpp"
#include "page_parts.hpp"

#include <filesystem>
#include <optional>
#include <string_view>

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

/// On the scene's grid, object's frame [m].
struct AnswerFields {
  Displacement displacement;
  std::optional<Displacement> reference, error, estimate;
};

/// @param file that write_vtk wrote of this scene
/// @throws std::runtime_error where it cannot be read, or is of another body
AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file);

std::string_view page_html();
std::string_view figure_html();
std::string_view table_html();
std::string_view style_css();
std::string_view sort_js();

} // namespace maille::studies
