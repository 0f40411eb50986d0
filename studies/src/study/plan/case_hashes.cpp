#include "maille/images/image.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/version.hpp"
#include "study/plan/study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>

#include <array>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Increment it when the meaning of a row's values changes.
constexpr int format_of_results = 1;
constexpr auto largest_file = std::numeric_limits<std::int64_t>::max();

std::string sha256(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("libcrypto gives no SHA-256");
  std::string hexadecimal;
  for (unsigned int i = 0; i < size; ++i)
    hexadecimal += fmt::format("{:02x}", digest[i]);
  return hexadecimal;
}

/// All texts in the table and its children.
void collect_texts(const toml::node& node, std::vector<std::string>& texts) {
  if (const toml::table* table = node.as_table())
    for (const auto& [key, value] : *table)
      collect_texts(value, texts);
  else if (const toml::array* array = node.as_array())
    for (const toml::node& value : *array)
      collect_texts(value, texts);
  else if (const auto text = node.value<std::string>())
    texts.push_back(*text);
}

/// The file named by a text, if any; for a file of materials a material name follows `.toml#`.
fs::path named_by(const std::string& text, const fs::path& folder) {
  const std::size_t one = text.find(".toml#");
  return named_file(one == std::string::npos ? text : text.substr(0, one + 5), folder).file;
}

} // namespace

CaseHashes::CaseHashes(const StudyFile& study, std::string settings)
    : study_(study), settings_(std::move(settings)) {}

std::string CaseHashes::digest_of_file(const fs::path& file) {
  if (const auto known = known_files_.find(file); known != known_files_.end())
    return known->second;
  std::error_code no_matter;
  std::string digest; // empty for texts without a file
  if (!file.empty() && fs::is_regular_file(file, no_matter))
    if (const auto parts = files_of_image(file); parts.size() <= 2 && parts.front() == file)
      for (const fs::path& part : parts)
        if (fs::is_regular_file(part, no_matter))
          digest += sha256(read_own_text_file(part, "a file of a scene", largest_file));
  known_files_.emplace(file, digest);
  return digest;
}

std::string CaseHashes::digests_of_opened(const StudyCase& one, const std::vector<std::string>& texts) {
  const fs::path file = study_.scenes[one.scene].file, folder = file.parent_path();
  std::set<std::string> named;
  std::set<fs::path> known{fs::absolute(file)};
  std::error_code no_matter;
  for (const std::string& text : texts)
    if (const fs::path at = named_by(text, folder); !at.empty() && fs::exists(at, no_matter)) {
      named.insert(at.string());
      if (!digest_of_file(at).empty())
        for (const fs::path& part : files_of_image(at))
          known.insert(fs::absolute(part));
    }
  const auto [digests, is_new] = known_opened_.try_emplace(fmt::format("{}", fmt::join(named, "\n")));
  if (!is_new || named.empty())
    return digests->second;
  const OpenedFiles opened;
  bool is_whole = true;
  try {
    parse_scene_and_measures(resolved_scene(study_, one), file);
  } catch (const std::exception&) { // reported in its row
    is_whole = false;
  }
  for (const fs::path& part : std::set(opened.files()))
    if (!known.contains(part))
      digests->second +=
          fmt::format("{} {}\n", part.lexically_relative(fs::absolute(file).parent_path()).string(),
                      sha256(read_own_text_file(part, "a file of a scene", largest_file)));
  std::string found = digests->second;
  if (!is_whole)
    known_opened_.erase(digests); // it may not have opened all files
  return found;
}

std::vector<std::string> CaseHashes::of_case(const StudyCase& one, const std::vector<std::string>& methods) {
  const fs::path file = study_.scenes[one.scene].file;
  toml::table scene = parse_toml(resolved_scene(study_, one), file.string());
  scene.erase("title");
  std::ostringstream canonical; // toml::table keeps its keys sorted
  canonical << toml::json_formatter(scene) << "\n";
  std::vector<std::string> texts;
  collect_texts(scene, texts);
  for (const std::string& text : texts)
    if (const std::string digest = digest_of_file(named_by(text, file.parent_path())); !digest.empty())
      canonical << text << " " << digest << "\n";
  canonical << digests_of_opened(one, texts);
  const std::string of_scene = sha256(canonical.view());
  std::vector<std::string> hashes;
  for (const std::string& method : methods)
    hashes.push_back(sha256(fmt::format(
        "{}\nmethod {}\nreference {} {}\nrepetitions {}\nsettings {}\nmaille {}\nformat {}\n", of_scene,
        method, study_.reference, study_.reference == "best" ? study_.reference_seconds : 0,
        study_.repetitions, settings_, version, format_of_results)));
  return hashes;
}

} // namespace maille::studies
