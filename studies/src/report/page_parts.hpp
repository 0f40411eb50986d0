#pragma once
/// What a page is made of, as data for its template (page.html).

#include "chart.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

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

} // namespace maille::studies
