#include "maille/studies/report/report.hpp"

#include "maille/scene/memory.hpp"
#include "maille/studies/version.hpp"
#include "page_parts.hpp"

#include <mstch/mstch.hpp>

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <sstream>
#include <stdexcept>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

mstch::node node_of(const PageData& data) {
  if (data.is_object()) {
    mstch::map map;
    for (const auto& [key, value] : data.items())
      map.emplace(key, node_of(value));
    return map;
  }
  if (data.is_array()) {
    mstch::array array;
    for (const PageData& value : data)
      array.push_back(node_of(value));
    return array;
  }
  if (data.is_string())
    return data.get<std::string>();
  if (data.is_boolean())
    return data.get<bool>();
  return data.is_null() ? mstch::node(false) : mstch::node(data.dump());
}

/// The folder's files by name, without pages such as this.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() != ".html" &&
        !entry.path().filename().string().starts_with('.'))
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// Nothing that Maille writes stands deeper; nlohmann prints what is nested by calling itself.
constexpr int deepest = 64;

PageData parsed(const std::string& text, const fs::path& file) {
  const auto is_shallow = [&](int depth, PageData::parse_event_t, const PageData&) {
    if (depth > deepest)
      throw std::runtime_error(fmt::format("{}: more than {} brackets deep", file.string(), deepest));
    return true;
  };
  PageData data = PageData::parse(text, is_shallow, false);
  if (data.is_discarded())
    throw std::runtime_error(file.string() + " is no JSON");
  return data;
}

/// Rows of a study; a last line that is not whole, as a study that was killed leaves, is passed over.
std::vector<PageData> study_rows(const fs::path& file) {
  std::vector<PageData> rows;
  std::istringstream lines(bytes_of_file(file));
  for (std::string line; std::getline(lines, line);)
    if (PageData row = PageData::parse(line, nullptr, false); row.is_object() && row.contains("method"))
      rows.push_back(std::move(row));
  return rows;
}

/// Larger pictures are left to other programs: a page holds them twice over.
constexpr std::uintmax_t largest_picture = std::uintmax_t{16} << 20;

/// Whether a file is what its name says, and small enough; else the draft notes why it is not on the page.
bool is_picture(const fs::path& file, PageDraft& draft) {
  if (fs::file_size(file) > largest_picture) {
    draft.notes.push_back(fmt::format("{}: a picture of {}, more than {}: left out", file.filename().string(),
                                      bytes_in_words(static_cast<double>(fs::file_size(file))),
                                      bytes_in_words(static_cast<double>(largest_picture))));
    return false;
  }
  const std::string bytes = bytes_of_file(file);
  const bool is_one =
      file.extension() == ".png" ? bytes.starts_with("\x89PNG") : bytes.find("<svg") != std::string::npos;
  if (!is_one)
    draft.notes.push_back(file.filename().string() + ": no picture, though its name says so: left out");
  return is_one;
}

/// A picture of a stem that has an SVG too is the same picture.
std::vector<fs::path> pictures_in(const std::vector<fs::path>& files, PageDraft& draft) {
  std::vector<fs::path> pictures;
  for (const fs::path& file : files) {
    fs::path svg = file;
    svg.replace_extension(".svg");
    const bool has_svg = std::ranges::find(files, svg) != files.end();
    if ((file.extension() == ".svg" || (file.extension() == ".png" && !has_svg)) && is_picture(file, draft))
      pictures.push_back(file);
  }
  return pictures;
}

/// What `study` wrote beside its table; null where it did not, or it is damaged.
PageData about_study(const fs::path& table) {
  const fs::path file = table.parent_path() / (table.stem().string() + "_about.json");
  std::error_code no_matter;
  return fs::is_regular_file(file, no_matter) ? PageData::parse(bytes_of_file(file), nullptr, false)
                                              : PageData();
}

/// Adds the section of one file, if it is of results. @param pictures of which those of a trade are taken out
void add_section(const fs::path& file, const fs::path& folder, std::vector<fs::path>& pictures,
                 PageDraft& draft) {
  if (file.extension() == ".jsonl") {
    if (const auto rows = study_rows(file); !rows.empty() && !file.stem().string().ends_with("_older"))
      add_study_section(rows, file.stem().string(), about_study(file), draft);
  } else if (file.extension() == ".json") {
    const PageData data = parsed(bytes_of_file(file), file);
    const PageData kind = at(data, "kind");
    if (kind == "compare" || kind == "run") {
      add_answers_section(data, folder, draft);
    } else if (at(data, "rows").is_array() && at(data, "reference_algorithm").is_string()) {
      const auto own = [&](const fs::path& picture) { return picture.stem() == file.stem(); };
      std::vector<fs::path> of_trade;
      std::ranges::copy_if(pictures, std::back_inserter(of_trade), own);
      std::erase_if(pictures, own);
      add_trade_section(data, of_trade, draft);
    }
  }
}

/// Adds the sections of all results in the folder; a file that cannot be read, or is not what it seems, costs
/// its own section only.
/// @return pictures that belong to none of them
std::vector<fs::path> add_sections(const std::vector<fs::path>& files, const fs::path& folder,
                                   PageDraft& draft) {
  std::vector<fs::path> pictures = pictures_in(files, draft);
  for (const fs::path& file : files)
    try {
      add_section(file, folder, pictures, draft);
    } catch (const nlohmann::json::exception& error) {
      draft.notes.push_back(fmt::format("{}: no results that Maille wrote: {}", file.string(), error.what()));
    } catch (const std::runtime_error& error) {
      draft.notes.emplace_back(error.what());
    }
  return pictures;
}

PageData page_data(const fs::path& folder, const std::string& command, PageDraft& draft) {
  const std::vector<fs::path> files = files_in(folder);
  PageData page{{"maille", version},           {"folder", folder.lexically_normal().string()},
                {"style", style_css()},        {"script", sort_js()},
                {"page_command", command},     {"sections", PageData::array()},
                {"others", PageData::array()}, {"files", PageData::array()}};
  const std::vector<fs::path> pictures = add_sections(files, folder, draft);
  page["runs"] = draft.runs;
  const auto heading = [&](const PageData& run) { return plain(run.at("heading")); };
  for (const PageData& run : draft.runs)
    page["sections"].push_back({{"id", run.at("id")}, {"name", heading(run)}});
  if (draft.runs.size() == 1) { // the title of the page says what it is about
    page["title"] = heading(draft.runs.front());
    page["runs"].front()["heading"] = "Results";
    page["sections"].front()["name"] = "Results";
  } else {
    page["title"] = fmt::format("{} results", draft.runs.size());
  }
  for (const fs::path& file : pictures)
    page["others"].push_back(
        picture_of_file(file, "The picture " + file.filename().string(), file.filename().string()));
  page["others?"] = !pictures.empty();
  if (!pictures.empty())
    page["sections"].push_back({{"id", "pictures"}, {"name", "Other pictures"}});
  page["sections"].push_back({{"id", "files"}, {"name", "Files"}});
  for (const fs::path& file : files)
    page["files"].push_back({{"name", file.filename().string()},
                             {"size", bytes_in_words(static_cast<double>(fs::file_size(file)))}});
  page["missing"] = draft.notes;
  return page;
}

} // namespace

Report make_report(const fs::path& folder, const std::string& command) {
  PageDraft draft;
  const PageData page = page_data(folder, command, draft);
  Report report;
  report.has_results = !draft.runs.empty();
  report.notes = draft.notes;
  report.html = mstch::render(std::string(page_html()), node_of(page),
                              {{"figure", std::string(figure_html())}, {"table", std::string(table_html())}});
  return report;
}

} // namespace maille::studies
