#pragma once
/// What a page is made of, as data for its template (page.html): sections, one a kind of results, files as
/// parts of it, plots by gnuplot. Texts are compiled in (see cmake/embed_texts.cmake).

#include "maille/scene/answer.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

struct ChartPoint {
  double x = 0, y = 0;
};

struct ChartSeries {
  std::string name; ///< a method's name has the colour that it has everywhere
  std::vector<ChartPoint> points;
};

struct Chart {
  std::string x_label, y_label;
  bool log_x = false, log_y = false;
  bool has_lines = false; ///< between the points of a series
  std::vector<ChartSeries> series;
};

/// For pages of light and of dark colour, without ground.
struct DrawnChart {
  std::string light_svg, dark_svg;
};

/// @return nothing where there is no gnuplot, or it failed; `why_not` then says so
std::optional<DrawnChart> draw_chart(const Chart& chart, std::string& why_not);

using PageData = nlohmann::ordered_json;

/// A page in the making: its sections, and what could not be put on it.
struct PageDraft {
  PageData runs = PageData::array();
  std::vector<std::string> notes;
};

/// `percent` of null, and of what is no number, is a dash; likewise the others.
std::string percent(const PageData& ratio);
std::string seconds(const PageData& value);
std::string bytes(const PageData& value);
std::string plain(const PageData& value);

/// One cell of a table: what is shown, and what is sorted by.
PageData number_cell(std::string text, const PageData& key);
PageData text_cell(std::string text);
PageData column(std::string name, bool is_number, std::string why = {});

/// `object` / `first` / `second`, or null.
PageData at(const PageData& object, const std::string& first, const std::string& second = {});

/// @param alt what a picture shows, for those who do not see it
PageData picture(const std::string& bytes, std::string alt, std::string caption,
                 const char* type = "image/png");
/// Nothing where it cannot be drawn, which the draft then notes.
std::optional<PageData> plot(const Chart& chart, std::string alt, std::string caption, PageDraft& draft);
/// Points of each method, in the order in which methods first appear.
class SeriesByMethod {
public:
  void add(const std::string& method, double x, double y);
  std::vector<ChartSeries> series;
};

/// Letters, digits and hyphens of `text`: an id of HTML. Not empty.
std::string id_of(const std::string& text);

/// `data:TYPE;base64,...` (RFC 2397, RFC 4648)
std::string data_uri(std::string_view type, std::string_view bytes);

/// @throws std::runtime_error
std::string bytes_of_file(const std::filesystem::path& file);

/// What `compare --out` or `run --out` wrote (see write_results).
/// @param results the file's content; @param folder where the files for ParaView are
void add_answers_section(const PageData& results, const std::filesystem::path& folder, PageDraft& draft);
/// @param rows of one table of JSON lines of `maille study`; @param table the file
/// @param about the description that `study` wrote beside it; null if missing
void add_study_section(const std::vector<PageData>& rows, const std::filesystem::path& table,
                       const PageData& about, PageDraft& draft);
/// @param trade what `trade --json` says; @param pictures PNG or SVG files that it drew
void add_trade_section(const PageData& trade, const std::vector<std::filesystem::path>& pictures,
                       PageDraft& draft);

/// @param results what `play --out` wrote, or null @param frames what `play --json` says, or null
/// @param moments pictures of frames, in their order
void add_play_section(const PageData& results, const PageData& frames,
                      const std::vector<std::filesystem::path>& moments, PageDraft& draft);
/// @param probe what `probe --json` says; @param name of the file without ending
void add_probe_section(const PageData& probe, const std::string& name,
                       const std::vector<std::filesystem::path>& pictures, PageDraft& draft);

/// The scene's or the study's file, what `explain` says of it, and the command, where `asked` has them (see
/// asked_about).
void add_what_was_asked(const PageData& asked, PageData& run);

/// A picture file as it is. @param file PNG or SVG
PageData picture_of_file(const std::filesystem::path& file, std::string alt, std::string caption);

/// What a scene asks, in a sentence: the body, what is done to it, and what that comes to.
std::string question_of(const Scene& scene);

/// Tables of parts (labels, else materials) and of forces, of the rows of `run` or `compare` that have
/// `mechanics`; older results have none.
PageData mechanics_tables(const std::vector<PageData>& rows, const std::string& reference, int dimension,
                          const std::string& id);

/// Names of the measures in rows of `run`, `compare` or `trade`, in order of first appearance.
std::vector<std::string> names_of_measures(const std::vector<PageData>& rows);
/// A row a measure and method: value, error, vector; nothing where the scene asks for none.
std::optional<PageData> measures_table(const std::vector<PageData>& rows, const std::string& reference,
                                       const std::string& id);
/// Two columns a measure, its value and its error, and a row's cells of them.
void add_measure_columns(const std::vector<PageData>& rows, PageData& columns);
void add_measure_cells(const std::vector<PageData>& rows, const PageData& row, PageData& cells);

std::string_view page_html();
std::string_view figure_html();
std::string_view table_html();
std::string_view style_css();
std::string_view sort_js();

} // namespace maille::studies
