/// Which files Maille wrote, and so may remove.
///
/// A result is removed only if its name has the form of results and its content proves where it is from. Data
/// sets for viewers name their provenance among their first arrays, lists of data sets in a comment.
/// Tables and pictures have no place for it: the list of results has a digest of each, so that a file
/// which was changed, or which a foreign list names, stays.

#include "export/whole_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>

namespace maille::studies {

namespace fs = std::filesystem;

namespace {

bool is_plain_file(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() == fs::file_type::regular;
}

/// `0012.vtu`
bool is_name_of_piece(const std::string& name) {
  return name.size() >= 8 && name.ends_with(".vtu") &&
         std::all_of(name.begin(), name.end() - 4, [](unsigned char c) { return std::isdigit(c) != 0; });
}

void remove_pieces(const fs::path& folder) {
  std::error_code error;
  if (fs::symlink_status(folder, error).type() != fs::file_type::directory)
    return;
  std::vector<fs::path> pieces;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_name_of_piece(entry.path().filename().string()) && has_provenance(entry.path()))
      pieces.push_back(entry.path());
  for (const fs::path& piece : pieces)
    fs::remove(piece, error);
}

} // namespace

bool is_name_of_result(std::string_view name, std::string_view stem) {
  static constexpr std::array endings{".vti", ".vtu", ".pvtu", ".pvd", ".vtm", ".vtp",  ".csv", ".json",
                                      ".png", ".svg", ".mp4",  ".nii", ".gz",  ".nrrd", ".mha"};
  return !stem.empty() && !name.starts_with('.') && name.find('/') == std::string_view::npos &&
         name.starts_with(stem) && name.size() > stem.size() + 3 &&
         (name[stem.size()] == '_' || name[stem.size()] == '.') &&
         std::ranges::any_of(endings, [&](std::string_view ending) { return name.ends_with(ending); });
}

bool has_provenance(const fs::path& file) {
  if (!is_plain_file(file))
    return false;
  std::string head(std::size_t{1} << 16, '\0'); // field data come first
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.erase(head.begin() + stream.gcount(), head.end());
  const auto has = [&](std::string_view text) { return head.find(text) != std::string::npos; };
  return has("<VTKFile") && ((has("Name=\"Units\"") && has("Name=\"Provenance\"")) ||
                             has(fmt::format("<!--{}-->", provenance_of_list)));
}

std::string digest_of(const fs::path& file) {
  if (!is_plain_file(file))
    return {};
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 1 << 14> part{};
  std::uint64_t sum = 0xcbf29ce484222325, size = 0; // FNV-1a
  while (stream.read(part.data(), part.size()) || stream.gcount() > 0)
    for (std::streamsize i = 0; i < stream.gcount(); ++i, ++size)
      sum = (sum ^ static_cast<unsigned char>(part[static_cast<unsigned>(i)])) * 0x100000001b3;
  return stream.bad() || size == 0 ? "" : fmt::format("{:016x}-{}", sum, size);
}

void remove_result(const fs::path& file) {
  std::error_code ignored; // what cannot be removed harms no result
  fs::remove(file, ignored);
  if (file.extension() != ".pvtu" || file.stem().string().find_first_not_of('.') == std::string::npos)
    return;
  const fs::path folder = file.parent_path() / file.stem();
  remove_pieces(folder);
  if (!fs::is_symlink(folder, ignored) && fs::is_directory(folder, ignored))
    fs::remove(folder, ignored); // only if it is empty
}

void make_folder_of_pieces(const fs::path& folder) {
  remove_pieces(folder);
  if (!fs::is_symlink(folder))
    fs::create_directory(folder);
  bool has_link = fs::is_symlink(folder);
  for (const auto& entry : fs::directory_iterator(folder))
    has_link = has_link || entry.is_symlink();
  if (has_link)
    throw fs::filesystem_error("cannot write: a symbolic link", folder, std::error_code());
}

} // namespace maille::studies
