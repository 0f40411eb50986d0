#include "cli/commands.hpp"

#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "inputs.hpp"
#include "json_parts.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include <sys/stat.h>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::int64_t largest_list = std::int64_t{1} << 30; ///< [bytes]

/// Where a name leads; of a pipe, which leads to no file, the name.
fs::path place_of(const fs::path& file) {
  std::error_code error;
  const fs::path place = fs::weakly_canonical(fs::absolute(file), error);
  return error ? fs::absolute(file) : place;
}

/// A list of results; nothing for another file.
ordered_json list_in(const fs::path& file) {
  ordered_json list;
  try {
    list = parse_json(read_own_text_file(file, "a list of results", largest_list), file);
  } catch (const InputError&) { // another program's file
    return list;
  }
  const bool is_list =
      list.is_object() &&
      std::ranges::all_of(std::array{"kind", "scene", "maille", "scene_text"},
                          [&](const char* key) { return list.contains(key) && list[key].is_string(); });
  return is_list ? list : ordered_json();
}

std::string text_in(const ordered_json& list, const char* key) {
  const auto at = list.find(key);
  return at != list.end() && at->is_string() ? at->get<std::string>() : "";
}

/// Splits `stem_0012.vtu` into `stem_` and `.vtu`; empty without a number.
std::pair<std::string, std::string> series_of(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  const std::size_t last = dot == std::string::npos ? dot : name.find_last_not_of("0123456789", dot - 1);
  if (last == std::string::npos || name[last] != '_' || dot - last < 5) // at least four digits
    return {};
  return {name.substr(0, last + 1), name.substr(dot)};
}

/// Time of the last change of a file, or of its placement with an older time [s]; 0: it does not exist.
long double changed(const fs::path& file) {
  using Stat = struct stat;
  Stat known{};
  const auto seconds = [](const timespec& of) { return of.tv_sec + 1e-9L * of.tv_nsec; };
  return stat(file.c_str(), &known) == 0 ? std::max(seconds(known.st_mtim), seconds(known.st_ctim)) : 0;
}

FolderLock lock_of(const fs::path& folder, const std::string& scene, std::vector<std::string> sure,
                   const std::string& kind) {
  prepare_folder(folder);
  try {
    sure.push_back(fmt::format("_{}_results.json", kind));
    return {folder, scene, FolderLock::Sharing::none, sure};
  } catch (const FolderTaken& error) {
    throw UsageError(fmt::format("--out {}", error.what()));
  } catch (const fs::filesystem_error& error) {
    throw UsageError(fmt::format("--out {}: expected a folder that can be written, found {}", folder.string(),
                                 message_of(error)));
  }
}

} // namespace

ResultsFolder::ResultsFolder(fs::path folder, std::string scene, const fs::path& scene_file, std::string kind,
                             const std::vector<std::string>& sure)
    : folder_(std::move(folder)), scene_(std::move(scene)), kind_(std::move(kind)),
      scene_file_(place_of(scene_file).string()), scene_text_(scene_text_of(scene_file)),
      inputs_(digests_of_opened_files()), lock_(lock_of(folder_, scene_, sure, kind_)) {
  for (const std::string& ending : sure)
    plan(ending);
  plan(fmt::format("_{}_results.json", kind_));
  std::vector<fs::path> lists;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.is_regular_file() && entry.path().filename().string().ends_with("_results.json"))
      lists.push_back(entry.path());
  std::sort(lists.begin(), lists.end());
  for (const fs::path& list : lists)
    look_at(list);
  if (!may_overwrite() && !fs::exists(file(fmt::format("_{}_results.json", kind_))))
    refuse_older_than_inputs();
  if (kind_ == "compare")
    add_stale(scene_ + ".pvd", scene_); // methods are no time steps
  // Files of a killed run are in no list.
  for (const std::string& method : all_methods())
    for (const char* ending : {".vti", ".vtu", ".pvtu", ".pvd"}) {
      const bool is_of_compare = std::string_view(ending) != ".pvd";
      if (kind_ == (is_of_compare ? "compare" : "run"))
        add_stale(fmt::format("{}_{}{}", scene_, method, ending), scene_);
      if (kind_ == "run")
        add_stale(fmt::format("{}_{}_0000{}", scene_, method, ending), scene_); // its series: see finish()
    }
}

void ResultsFolder::look_at(const fs::path& file) {
  const ordered_json list = list_in(file);
  if (list.is_null())
    return;
  const std::string text = text_in(list, "scene_text");
  const bool is_same_scene =
      text_in(list, "scene") == scene_ && (text == scene_text_ || text_in(list, "scene_file") == scene_file_);
  const std::string by = text_in(list, "maille");
  if (!may_overwrite() && (!is_same_scene || by != version))
    throw UsageError(fmt::format(
        "--out {}: expected a folder without results of another {}, found those of {} by maille {} "
        "({}); --overwrite replaces them",
        folder_.string(), is_same_scene ? "version" : "scene", text_in(list, "scene"), by,
        file.filename().string()));
  if (!is_same_scene || by != version || text_in(list, "kind") == kind_ || text != scene_text_ ||
      has_other_inputs(list)) {
    // Ignore a list under another name.
    if (file.filename() == fmt::format("{}_{}_results.json", text_in(list, "scene"), text_in(list, "kind"))) {
      add_stale(file.filename().string(), text_in(list, "scene"), digest_of(file));
      add_stale_of(list);
    }
  }
}

void refuse_name_of_result(const std::string& option, const std::optional<std::string>& file,
                           const fs::path& folder, const std::function<bool(const std::string&)>& is_result) {
  const fs::path path = file && *file != "-" ? place_of(*file) : fs::path();
  if (!path.empty() && path.parent_path() == place_of(folder) && is_result(path.filename().string()))
    throw UsageError(
        fmt::format("{} {}: expected a file of its own, found the name of a result of --out", option, *file));
}

/// True if a file read by both runs, an image or a material, has changed in between.
bool ResultsFolder::has_other_inputs(const ordered_json& list) const {
  const auto known = list.find("inputs");
  return known != list.end() && known->is_object() && std::ranges::any_of(inputs_, [&](const auto& input) {
           return known->contains(input.first) && (*known)[input.first] != input.second;
         });
}

/// A killed run has no list, hence no digests of its inputs: file times show whether these have changed.
void ResultsFolder::refuse_older_than_inputs() const {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (const std::string name = entry.path().filename().string(); is_name_of_result(name, scene_))
      names.insert(name);
  for (const std::string& name : std::set(names))
    if (const ordered_json list = name.ends_with("_results.json") ? list_in(folder_ / name) : ordered_json();
        list.contains("written"))
      for (const ordered_json& one : list["written"])
        names.erase(one.is_string() ? one.get<std::string>() : "");
  for (const std::string& name : names)
    for (const auto& [input, digest] : inputs_)
      if (const fs::path file = folder_ / name; changed(file) < changed(input) && has_provenance(file))
        throw UsageError(fmt::format("--out {}: expected no files of a run that was cut short before {} "
                                     "changed, found {}; --overwrite replaces them",
                                     folder_.string(), input, name));
}

/// Ignores list entries with other names or folders, and files changed since.
void ResultsFolder::add_stale(const std::string& name, const std::string& scene, const std::string& digest) {
  if (is_name_of_result(name, scene))
    if (std::string& known = stale_[name]; known.empty())
      known = digest;
}

bool ResultsFolder::is_stale(const fs::path& file) const {
  const std::string name = file.filename().string();
  const auto known = stale_.find(name);
  // Check the name first: opening and closing the lock file would release the lock.
  if (written_.contains(name) || (known == stale_.end() && !is_of_replaced_series(name)) ||
      is_kept_input(file))
    return false;
  if (has_provenance(file))
    return true;
  return known != stale_.end() && !known->second.empty() && known->second == digest_of(file);
}

void ResultsFolder::add_stale_of(const ordered_json& list) {
  const std::string scene = text_in(list, "scene");
  const auto digests = list.find("digests");
  const bool is_digests = digests != list.end() && digests->is_object();
  if (const auto names = list.find("written"); names != list.end() && names->is_array())
    for (const ordered_json& name : *names)
      if (name.is_string())
        add_stale(name.get<std::string>(), scene,
                  is_digests ? text_in(*digests, name.get<std::string>().c_str()) : "");
  if (const auto files = list.find("files"); files != list.end() && files->is_array())
    for (const ordered_json& file : *files)
      if (file.is_object())
        add_stale(text_in(file, "file"), scene);
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
         std::any_of(stale_.begin(), stale_.end(), [&](const auto& known) { return is_of_it(known.first); });
}

fs::path ResultsFolder::finish(ordered_json results) {
  const fs::path list = file(fmt::format("_{}_results.json", kind_));
  add(list);
  ordered_json all{{"kind", kind_}};
  all.update(made_by());
  all.update({{"command", command_line()},
              {"scene", scene_},
              {"scene_file", scene_file_},
              {"scene_text", scene_text_},
              {"inputs", inputs_}});
  all.update(results);
  std::vector<fs::path> gone;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (is_stale(entry.path()))
      gone.push_back(entry.path());
  if (keeps_earlier_) {
    add(gone);
    gone.clear();
  }
  all["written"] = written_;
  all["digests"] = ordered_json::object();
  for (const std::string& name : written_)
    if (const fs::path file = folder_ / name; file != list && !has_provenance(file))
      if (const std::string digest = digest_of(file); !digest.empty())
        all["digests"][name] = digest;
  write_whole(list, json_text(all));
  for (const fs::path& stale : gone)
    remove_result(stale);
  return list;
}

} // namespace maille::studies
