#include "cli/commands.hpp"

#include "inputs.hpp"
#include "maille/materials/json.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/methods.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::int64_t largest_list = std::int64_t{1} << 30; ///< [bytes]

/// A list of results, or nothing where the file is none.
ordered_json list_in(const fs::path& file) {
  ordered_json list;
  try {
    list = parse_json(read_text_file(file, "a list of results", largest_list), file);
  } catch (const InputError&) { // another program's file
    return list;
  }
  const bool is_list = list.is_object() && list.contains("kind") && list.contains("scene") &&
                       list["kind"].is_string() && list["scene"].is_string();
  return is_list ? list : ordered_json();
}

std::string text_in(const ordered_json& list, const char* key) {
  const auto at = list.find(key);
  return at != list.end() && at->is_string() ? at->get<std::string>() : "";
}

/// `stem_0012.vtu` as `stem_` and `.vtu`; nothing where there is no number.
std::pair<std::string, std::string> series_of(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  const std::size_t last = dot == std::string::npos ? dot : name.find_last_not_of("0123456789", dot - 1);
  if (last == std::string::npos || name[last] != '_' || dot - last < 5) // at least four digits
    return {};
  return {name.substr(0, last + 1), name.substr(dot)};
}

/// One plain name: what a list says of other folders is not believed.
bool is_plain(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && name != "." && name != "..";
}

} // namespace

ResultsFolder::ResultsFolder(fs::path folder, std::string scene, const fs::path& scene_file, std::string kind,
                             bool overwrite)
    : folder_(std::move(folder)), scene_(std::move(scene)), kind_(std::move(kind)),
      scene_file_(fs::weakly_canonical(fs::absolute(scene_file)).string()),
      scene_text_(scene_text_of(scene_file)) {
  prepare_folder(folder_);
  std::vector<fs::path> lists;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.is_regular_file() && entry.path().filename().string().ends_with("_results.json"))
      lists.push_back(entry.path());
  std::sort(lists.begin(), lists.end());
  for (const fs::path& list : lists)
    look_at(list, overwrite);
  if (kind_ == "compare")
    stale_.insert(scene_ + ".pvd"); // methods are no time steps
  // What a run that was killed has left stands in no list.
  for (const std::string& method : all_methods())
    for (const char* ending : {".vti", ".vtu", ".pvtu", ".pvd"}) {
      const bool is_of_compare = std::string_view(ending) != ".pvd";
      if (kind_ == (is_of_compare ? "compare" : "run"))
        stale_.insert(fmt::format("{}_{}{}", scene_, method, ending));
      if (kind_ == "run")
        stale_.insert(fmt::format("{}_{}_0000{}", scene_, method, ending)); // and its series, see finish()
    }
}

void ResultsFolder::look_at(const fs::path& file, bool overwrite) {
  const ordered_json list = list_in(file);
  if (list.is_null())
    return;
  const std::string text = text_in(list, "scene_text");
  const bool is_same_scene =
      text_in(list, "scene") == scene_ && (text == scene_text_ || text_in(list, "scene_file") == scene_file_);
  const std::string by = text_in(list, "maille");
  if (!overwrite && (!is_same_scene || by != version))
    throw UsageError(fmt::format(
        "--out {}: expected a folder without results of another {}, found those of {} by maille {} "
        "({}); --overwrite replaces them",
        folder_.string(), is_same_scene ? "version" : "scene", text_in(list, "scene"), by,
        file.filename().string()));
  if (!is_same_scene || by != version || text_in(list, "kind") == kind_ || text != scene_text_) {
    stale_.insert(file.filename().string());
    add_stale_of(list);
  }
}

void ResultsFolder::add_stale_of(const ordered_json& list) {
  if (const auto names = list.find("written"); names != list.end() && names->is_array())
    for (const ordered_json& name : *names)
      if (name.is_string() && is_plain(name.get<std::string>()))
        stale_.insert(name.get<std::string>());
  if (const auto files = list.find("files"); files != list.end() && files->is_array())
    for (const ordered_json& file : *files)
      if (file.is_object() && is_plain(text_in(file, "file")))
        stale_.insert(text_in(file, "file"));
}

fs::path ResultsFolder::file(const std::string& ending) const {
  return folder_ / (scene_ + ending);
}

void ResultsFolder::add(const fs::path& file) {
  written_.insert(file.filename().string());
}

void ResultsFolder::add(const std::vector<fs::path>& files) {
  for (const fs::path& file : files)
    add(file);
}

bool ResultsFolder::is_of_replaced_series(const std::string& name) const {
  const auto [stem, ending] = series_of(name);
  if (stem.empty())
    return false;
  const auto is_of_it = [&, stem = stem, ending = ending](const std::string& known) {
    return series_of(known) == std::pair(stem, ending);
  };
  return std::any_of(written_.begin(), written_.end(), is_of_it) ||
         std::any_of(stale_.begin(), stale_.end(), is_of_it);
}

fs::path ResultsFolder::finish(ordered_json results) {
  const fs::path list = file(fmt::format("_{}_results.json", kind_));
  add(list);
  ordered_json all{{"kind", kind_},   {"maille", version},         {"command", command_line()},
                   {"scene", scene_}, {"scene_file", scene_file_}, {"scene_text", scene_text_}};
  all.update(results);
  std::vector<fs::path> gone;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (!written_.contains(name) && (stale_.contains(name) || is_of_replaced_series(name)) &&
        entry.is_regular_file() && !is_kept_input(entry.path()))
      gone.push_back(entry.path());
  }
  if (keeps_earlier_) {
    add(gone);
    gone.clear();
  }
  all["written"] = written_;
  write_whole(list, json_text(all));
  std::error_code ignored; // what cannot be removed stays, and no result suffers
  for (const fs::path& stale : gone) {
    fs::remove(stale, ignored);
    if (stale.extension() == ".pvtu") // its pieces
      fs::remove_all(fs::path(stale).replace_extension(), ignored);
  }
  return list;
}

} // namespace maille::studies
