#include "page_parts.hpp"

#include "data_uri.hpp"
#include "maille/scene/memory.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace maille::studies {

std::string percent(const PageData& ratio) {
  return ratio.is_number() ? fmt::format("{:.3g} %", 100 * ratio.get<double>()) : "–";
}

std::string seconds(const PageData& value) {
  if (!value.is_number())
    return "–";
  const double s = value;
  return s >= 1 || s == 0 ? fmt::format("{:.3g} s", s)
         : s >= 1e-3      ? fmt::format("{:.3g} ms", 1e3 * s)
                          : fmt::format("{:.3g} µs", 1e6 * s);
}

std::string bytes(const PageData& value) {
  return value.is_number() && value.get<double>() > 0 ? bytes_in_words(value.get<double>()) : "–";
}

std::string plain(const PageData& value) {
  if (value.is_string())
    return value.get<std::string>();
  if (value.is_number_integer())
    return fmt::format("{}", value.get<std::int64_t>());
  return value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : "–";
}

PageData number_cell(std::string text, const PageData& key) {
  PageData cell{{"text", std::move(text)}, {"is_number", true}};
  if (key.is_number())
    cell["key"] = key.is_number_integer() ? fmt::format("{}", key.get<std::int64_t>())
                                          : fmt::format("{:.9g}", key.get<double>());
  return cell;
}

PageData text_cell(std::string text) {
  return {{"text", std::move(text)}};
}

PageData column(std::string name, bool is_number, std::string why) {
  PageData result{{"name", std::move(name)}, {"is_number", is_number}};
  if (!why.empty())
    result["why"] = std::move(why);
  return result;
}

PageData at(const PageData& object, const std::string& first, const std::string& second) {
  if (!object.is_object() || !object.contains(first))
    return nullptr;
  return second.empty() ? object.at(first) : at(object.at(first), second);
}

PageData picture(const std::string& png, std::string alt, std::string caption) {
  return {{"source", data_uri("image/png", png)},
          {"look", "picture"},
          {"alt", std::move(alt)},
          {"caption", std::move(caption)}};
}

std::optional<PageData> plot(const Chart& chart, std::string alt, std::string caption, PageDraft& draft) {
  std::string why_not;
  const auto drawn = draw_chart(chart, why_not);
  if (!drawn) {
    if (std::ranges::find(draft.notes, why_not) == draft.notes.end())
      draft.notes.push_back(why_not);
    return std::nullopt;
  }
  return PageData{{"source", data_uri("image/svg+xml", drawn->light_svg)},
                  {"dark", data_uri("image/svg+xml", drawn->dark_svg)},
                  {"look", "plot"},
                  {"alt", std::move(alt)},
                  {"caption", std::move(caption)}};
}

void SeriesByMethod::add(const std::string& method, double x, double y) {
  auto found = std::ranges::find(series, method, &ChartSeries::name);
  if (found == series.end())
    found = series.insert(series.end(), {method, {}});
  found->points.push_back({x, y});
}

std::string id_of(const std::string& text) {
  std::string id = "id-";
  for (const char c : text)
    id += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  return id;
}

} // namespace maille::studies
