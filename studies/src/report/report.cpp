#include "report/report.hpp"

#include "maille/base/arena.hpp"
#include "maille/materials/json.hpp"
#include "maille/studies/version.hpp"
#include "page_parts.hpp"

#include <mstch/mstch.hpp>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fmt/format.h>
#include <map>
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

/// The value of a JSON text; null where the text is faulty.
PageData parsed_or_null(std::string_view text, const fs::path& file) {
  try {
    return parse_json(text, file);
  } catch (const InputError&) {
    return nullptr;
  }
}

using JsonFiles = std::map<fs::path, PageData>;

/// The content of the .json files, each parsed once; notes those that are none.
JsonFiles json_in(const std::vector<fs::path>& files, PageDraft& draft) {
  JsonFiles parsed;
  for (const fs::path& file : files)
    if (file.extension() == ".json")
      try {
        parsed.emplace(file, parse_json(bytes_of_file(file), file));
      } catch (const InputError& error) {
        draft.notes.emplace_back(error.what());
      }
  return parsed;
}

/// Rows of a study; a last line that is not whole, as a study that was killed leaves, is passed over.
std::vector<PageData> study_rows(const fs::path& file) {
  std::vector<PageData> rows;
  std::istringstream lines(bytes_of_file(file));
  for (std::string line; std::getline(lines, line);)
    if (PageData row = parsed_or_null(line, file); row.is_object() && row.contains("method"))
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
PageData about_study(const fs::path& table, const JsonFiles& files) {
  const auto about = files.find(table.parent_path() / (table.stem().string() + "_about.json"));
  return about == files.end() ? PageData() : about->second;
}

/// Takes those out of a list that are so.
template<class Is>
std::vector<fs::path> taken_out(std::vector<fs::path>& pictures, const Is& is) {
  std::vector<fs::path> taken;
  std::ranges::copy_if(pictures, std::back_inserter(taken), is);
  std::erase_if(pictures, is);
  return taken;
}

bool is_of_frames(const PageData& data) {
  return json_entry(data, "trajectory").is_string() && json_entry(data, "frames").is_array() &&
         json_entry(data, "objects").is_array();
}
bool is_of_probe(const PageData& data) {
  return json_entry(data, "ticks").is_number() && json_entry(data, "passivity").is_object() &&
         json_entry(data, "force").is_object();
}

/// The contents of the folder's other file about a play; null if missing.
/// @param is  whether a file is it
template<class Is>
const PageData& beside(const JsonFiles& files, const PageData& scene, const Is& is) {
  for (const auto& [file, data] : files)
    if (json_entry(data, "scene") == scene && is(data))
      return data;
  return json_entry(nullptr, "");
}

/// A play by what it wrote into the folder, and by its frames where those are there too.
void add_play(const PageData& data, const JsonFiles& files, std::vector<fs::path>& pictures,
              PageDraft& draft) {
  const PageData& scene = json_entry(data, "scene");
  const auto is_list = [](const PageData& other) { return json_entry(other, "kind") == "play"; };
  if (is_list(data)) {
    const std::string stem = plain(scene) + "_";
    const auto is_moment = [&](const fs::path& file) {
      const std::string name = file.stem().string();
      return name.starts_with(stem) && name.size() > stem.size() &&
             name.find_first_not_of("0123456789", stem.size()) == std::string::npos;
    };
    const std::vector<fs::path> moments = taken_out(pictures, is_moment);
    add_play_section(data, beside(files, scene, is_of_frames), moments, draft);
  } else if (beside(files, scene, is_list).is_null()) {
    add_play_section(nullptr, data, {}, draft);
  }
}

/// Adds the section of one file, if it is of results.
/// @param files all of the folder @param pictures of which those that belong to the section are taken out
void add_section(const fs::path& file, const fs::path& folder, const JsonFiles& files,
                 std::vector<fs::path>& pictures, PageDraft& draft) {
  if (file.extension() == ".jsonl") {
    if (const auto rows = study_rows(file); !rows.empty() && !file.stem().string().ends_with("_older"))
      add_study_section(rows, file, about_study(file, files), draft);
    return;
  }
  const auto json = files.find(file);
  if (json == files.end())
    return;
  const PageData& data = json->second;
  const PageData& kind = json_entry(data, "kind");
  const auto own = [&](const fs::path& picture) { return picture.stem() == file.stem(); };
  if (kind == "compare" || kind == "run")
    add_answers_section(data, folder, draft);
  else if (kind == "play" || is_of_frames(data))
    add_play(data, files, pictures, draft);
  else if (is_of_probe(data))
    add_probe_section(data, file.stem().string(), taken_out(pictures, own), draft);
  else if (json_entry(data, "rows").is_array() && json_entry(data, "reference_algorithm").is_string())
    add_trade_section(data, taken_out(pictures, own), draft);
}

/// Adds the sections of all results in the folder; a file that cannot be read, or is not what it seems, costs
/// its own section only.
/// @return pictures that belong to none of them
std::vector<fs::path> add_sections(const std::vector<fs::path>& files, const fs::path& folder,
                                   PageDraft& draft) {
  std::vector<fs::path> pictures = pictures_in(files, draft);
  const JsonFiles read = json_in(files, draft);
  for (const fs::path& file : files)
    try {
      add_section(file, folder, read, pictures, draft);
    } catch (const nlohmann::json::exception&) {
      draft.notes.push_back(fmt::format(
          "{}: expected results that Maille wrote, found entries of another form", file.string()));
    } catch (const InputError& error) {
      draft.notes.emplace_back(error.what());
    } catch (const std::runtime_error& error) {
      draft.notes.emplace_back(error.what());
    }
  return pictures;
}

/// A file's name as the address of a link (RFC 3986).
std::string address_of(const std::string& name) {
  std::string address;
  for (const char c : name)
    address +=
        std::isalnum(static_cast<unsigned char>(c)) || std::string_view("-_./~").find(c) != std::string::npos
            ? std::string(1, c)
            : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return address;
}

PageData page_data(const fs::path& folder, const std::string& command, const fs::path& links,
                   PageDraft& draft) {
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
                             {"address", address_of((links / file.filename()).generic_string())},
                             {"size", bytes_in_words(static_cast<double>(fs::file_size(file)))}});
  page["missing"] = draft.notes;
  return page;
}

} // namespace

Report make_report(const fs::path& folder, const std::string& command, const fs::path& links) {
  PageDraft draft;
  const PageData page = page_data(folder, command, links, draft);
  Report report;
  report.has_results = !draft.runs.empty();
  report.notes = draft.notes;
  report.html = mstch::render(std::string(page_html()), node_of(page),
                              {{"figure", std::string(figure_html())}, {"table", std::string(table_html())}});
  return report;
}

} // namespace maille::studies
