#pragma once
/// What a page is made of, as data for its template (page.html): files as parts of it, plots by gnuplot.

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
PageData picture(const std::string& png, std::string alt, std::string caption);
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

} // namespace maille::studies
