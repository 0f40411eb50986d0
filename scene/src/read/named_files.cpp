#include "maille/scene/read_scene.hpp"

#include "read/reader.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>

namespace maille {

namespace {

std::atomic<FileScope> file_scope{FileScope::anywhere};

/// The folder in an environment variable; null if it is unset or empty.
const char* folder_in(const std::string& variable) {
  const char* value = variable.find('\0') == std::string::npos ? std::getenv(variable.c_str()) : nullptr;
  return value && *value ? value : nullptr;
}

} // namespace

void set_file_scope(FileScope scope) {
  file_scope = scope;
}

NamedFile named_file(const std::string& name, const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  const bool has_variable = name.starts_with('$'), is_at_home = name == "~" || name.starts_with("~/");
  const std::size_t slash = std::min(name.find('/'), name.size());
  if (name.find('\0') != std::string::npos)
    return {{}, "the name of a file", "\"" + name + "\", with a zero in it"};
  fs::path base = folder, rest = name;
  if (has_variable || is_at_home) {
    const std::string variable = is_at_home ? "HOME" : name.substr(1, slash - 1);
    const char* value = folder_in(variable);
    if (!value)
      return {{}, "the environment variable " + variable + " to be set", "\"" + name + "\" without it"};
    base = value;
    rest = name.substr(std::min(slash + 1, name.size()));
  }
  const bool climbs =
      std::any_of(rest.begin(), rest.end(), [](const fs::path& part) { return part == ".."; });
  const bool leaves = rest.is_absolute() || climbs || is_at_home;
  if (leaves && file_scope == FileScope::sandbox)
    return {{},
            "a file in the folder of what names it or below, or in that of a variable, \"$NAME/...\": with "
            "--sandbox a scene "
            "reads nothing else, since its author may be unknown",
            "\"" + name + "\""};
  // After a variable, `/x` is relative to its folder.
  return {has_variable || is_at_home ? base / rest.relative_path() : base / rest, "", ""};
}

namespace reader {

std::optional<std::filesystem::path> resolve_path(const std::string& text, const std::string& path, int line,
                                                  FaultList& faults) {
  NamedFile named = named_file(text, std::filesystem::path(faults.file()).parent_path());
  if (!named.file.empty())
    return std::move(named.file);
  faults.add(line, path, std::move(named.expected), std::move(named.found));
  return std::nullopt;
}

std::optional<std::filesystem::path> read_file_name(TableReader& table, std::string_view key) {
  const auto name = table.text(key);
  return name ? resolve_path(*name, table.path_of(key), table.line_of_key(key), table.faults())
              : std::nullopt;
}

double read_unit(TableReader& table) {
  constexpr std::array metres{1e-3, 1e-2, 1.0};
  return metres.at(static_cast<unsigned>(table.word("unit").value_or(0)));
}

void adopt(const InputError& error, const std::string& path, int line, FaultList& faults) {
  for (const Fault& fault : error.faults())
    faults.add(line, path, fault.expected,
               fault.file + (fault.line > 0 ? ":" + std::to_string(fault.line) : "") + ": " +
                   (fault.key.empty() ? "" : fault.key + ": ") + fault.found);
}

} // namespace reader

} // namespace maille
