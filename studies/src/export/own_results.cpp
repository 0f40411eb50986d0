/// Recognition of files written by Maille, which it may replace or delete.
///
/// One table (`forms`) for all commands: the endings of results, and the mark at a fixed place that Maille's
/// writers put into each format. A file without the mark belongs to another program. Data sets for viewers
/// store their provenance among their first arrays, lists of data sets in a comment. PNG, SVG and MP4 come
/// from other libraries: add_mark() appends the mark.
///
/// CSV has no place for a mark. A table is Maille's if it begins with the header of the table that replaces
/// it, which its columns give (Columns::csv_head()), or if a list of results has its digest. For an unknown
/// ending, the content determines whether a file is JSON or CSV of Maille.
///
/// Deletion requires more than replacement, since no new file follows: the provenance of a data set, or a
/// digest, so that files changed since, or named in a foreign list, are kept.

#include "export/whole_file.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <regex>

#include <zlib.h>

namespace maille::studies {

namespace fs = std::filesystem;

namespace {

bool is_plain_file(const fs::path& file) {
  std::error_code error;
  return fs::symlink_status(file, error).type() == fs::file_type::regular;
}

constexpr std::int64_t anywhere = std::int64_t{1} << 40; ///< in the first 64 KB

/// An ending of results, and the mark of Maille's files.
struct Form {
  std::string_view ending;
  std::int64_t at = 0;        ///< offset [bytes]; below zero: from the end
  std::string_view mark = {}; ///< empty: has_provenance()
  std::size_t place() const { return static_cast<std::size_t>(at < 0 ? -at : at); }
};

using namespace std::string_view_literals;
constexpr std::array forms{
    Form{".vti"}, Form{".vtu"}, Form{".pvtu"}, Form{".pvd"}, Form{".vtm"}, Form{".vtp"},
    Form{".csv"},  // none: see above
    Form{".json"}, // a key `maille`
    Form{".jsonl", 0, "{\"study\":"}, Form{".nii", 148, "maille\0"sv}, Form{".nii.gz", 148, "maille\0"sv},
    Form{".nrrd", 0, "NRRD0005\n# http://teem.sourceforge.net/nrrd/format.html\n# maille\n"},
    Form{".mha", 0, "ObjectType = Image\nComment = maille\n"}, Form{".stl", 0, "maille;"},
    Form{".ply", 0, "ply\nformat binary_little_endian 1.0\ncomment maille;"},
    Form{".html", anywhere, "<meta name=\"generator\" content=\"maille"},
    Form{".toml", 0, "# Made by maille "}, Form{".inp", 0, "*HEADING\n** scene "},
    // A chunk tEXt, `Software` and `maille`, before the last one, IEND (12 bytes).
    Form{".png", -39, "\0\0\0\x0ftEXtSoftware\0maille\x32\x57\x26\x53"sv},
    Form{".svg", -16, "<!-- maille -->\n"},
    Form{".mp4", -14,
         "\0\0\0\x0e"
         "freemaille"sv}, // a box `free`
};

/// The first 64 KB of a file, decompressed.
std::string beginning(const fs::path& file) {
  std::string head(std::size_t{1} << 16, '\0');
  gzFile stream = gzopen(file.c_str(), "rb"); // which reads plain files, too
  head.resize(stream == nullptr ? 0
                                : static_cast<unsigned>(std::max(0, gzread(stream, head.data(), 1U << 16))));
  if (stream != nullptr)
    gzclose(stream);
  return head;
}

bool is_own_json(const fs::path& file) {
  constexpr std::int64_t largest = std::int64_t{1} << 30; ///< [bytes]
  try {
    auto json = parse_json(read_own_text_file(file, "a result", largest), file);
    if (json.is_array() && !json.empty()) // one row per tissue
      json = nlohmann::ordered_json(json[0]);
    const auto is_text = [&](const char* key) { return json.contains(key) && json[key].is_string(); };
    return json.is_object() && (is_text("maille") || (is_text("study") && is_text("scene_text")));
  } catch (const InputError&) {
    return false;
  }
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
  static const std::regex of_warp(
      R"((.+_)?((labels_)?warped|labels|pull|push|jacobian|surface(_.*)?)\.[a-z.]+)");
  if (stem.empty())
    return std::regex_match(name.begin(), name.end(), of_warp);
  return !name.starts_with('.') && name.find('/') == std::string_view::npos && name.starts_with(stem) &&
         name.size() > stem.size() + 3 && (name[stem.size()] == '_' || name[stem.size()] == '.') &&
         std::ranges::any_of(forms, [&](const Form& form) { return name.ends_with(form.ending); });
}

bool has_provenance(const fs::path& file) {
  if (!is_plain_file(file))
    return false;
  const std::string head = beginning(file); // field data is stored first
  const auto has = [&](std::string_view text) { return head.find(text) != std::string::npos; };
  return has("<VTKFile") && ((has("Name=\"Units\"") && has("Name=\"Provenance\"")) ||
                             has(fmt::format("<!--{}-->", provenance_of_list)));
}

bool is_own_result(const fs::path& file, std::string_view head_of_table) {
  if (!is_plain_file(file))
    return false;
  const auto size = static_cast<std::int64_t>(fs::file_size(file));
  const auto is_of = [&](const Form& form) { return file.filename().string().ends_with(form.ending); };
  const bool has_form = std::ranges::any_of(forms, is_of);
  const auto holds = [&](const Form& form) {
    if (has_form ? !is_of(form) : form.ending != ".json" && form.ending != ".csv")
      return false;
    if (form.ending == ".json")
      return is_own_json(file);
    if (form.mark.empty())
      return form.ending != ".csv" ? has_provenance(file)
                                   : !head_of_table.empty() && beginning(file).starts_with(head_of_table);
    if (form.at >= 0) {
      const std::size_t found = beginning(file).find(form.mark, form.at == anywhere ? 0 : form.place());
      return found != std::string::npos && (form.at == anywhere || found == form.place());
    }
    std::string tail(form.mark.size(), '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.seekg(size + form.at);
    stream.read(tail.data(), static_cast<std::streamsize>(tail.size()));
    return stream.good() && tail == form.mark;
  };
  return size == 0 || std::ranges::any_of(forms, holds);
}

void add_mark(const fs::path& file) {
  const std::string ending = file.extension().string();
  const auto* const form =
      std::ranges::find_if(forms, [&](const Form& one) { return one.ending == ending && one.at < 0; });
  if (form == forms.end())
    return;
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  const std::size_t behind = form->place() - form->mark.size(); // final bytes of the format
  const bool is_whole = ending == ".png"   ? text.size() > behind && text.substr(text.size() - 8, 4) == "IEND"
                        : ending == ".svg" ? text.find("</svg>") != std::string::npos
                                           : !text.empty();
  if (is_whole)
    text.insert(text.size() - behind, form->mark);
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!is_whole || !out)
    throw fs::filesystem_error("cannot write", file, std::make_error_code(std::errc::io_error));
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
