#pragma once
/// A folder with the results of one scene, replaced as a set.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace maille::studies {

/// What is in a folder is listed by `SCENE_KIND_results.json`, KIND being run, compare or play. Results of
/// the same scene, by the same version, take the place of earlier ones; the earlier files that have no
/// follower go once the new ones stand, so that nothing is lost when the process is killed. Results of two
/// kinds stay side by side as long as the scene's text is the same.
class ResultsFolder {
public:
  /// Makes the folder. @throws UsageError where it cannot be written, or holds results of another scene or
  /// version, unless `overwrite`: then they go, too
  ResultsFolder(std::filesystem::path folder, std::string scene, const std::filesystem::path& scene_file,
                std::string kind, bool overwrite);

  const std::filesystem::path& path() const { return folder_; }
  /// A path in the folder: `SCENE` and this.
  std::filesystem::path file(const std::string& ending) const;
  /// Says that a file has been written.
  void add(const std::filesystem::path& file);
  void add(const std::vector<std::filesystem::path>& files);
  /// Says that the command came to no end: what it has not replaced stays, and the next one takes it away.
  void keep_earlier() { keeps_earlier_ = true; }
  /// Writes the list, with `results` in it, and takes away what the new results replace. @return the list's
  /// file
  std::filesystem::path finish(nlohmann::ordered_json results);

private:
  void look_at(const std::filesystem::path& list, bool overwrite);
  void add_stale_of(const nlohmann::ordered_json& list);
  bool is_of_replaced_series(const std::string& name) const;

  std::filesystem::path folder_;
  std::string scene_, kind_, scene_file_, scene_text_;
  std::set<std::string> written_, stale_; ///< names in the folder
  bool keeps_earlier_ = false;
};

} // namespace maille::studies
