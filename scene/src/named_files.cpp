#include "maille/scene/named_files.hpp"

#include "reader.hpp"

#include <algorithm>
#include <cstdlib>

namespace maille {

NamedFile named_file(const std::string& name, const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  const bool has_variable = name.starts_with('$');
  const std::size_t slash = std::min(name.find('/'), name.size());
  fs::path base = folder, rest = name;
  if (has_variable) {
    const std::string variable = name.substr(1, slash - 1);
    const char* value = variable.find('\0') == std::string::npos ? std::getenv(variable.c_str()) : nullptr;
    if (!value || !*value)
      return {{}, "the environment variable " + variable + " to be set", "\"" + name + "\" without it"};
    base = value;
    rest = name.substr(std::min(slash + 1, name.size()));
  }
  const bool climbs =
      std::any_of(rest.begin(), rest.end(), [](const fs::path& part) { return part == ".."; });
  if (rest.is_absolute() || climbs || name.find('\0') != std::string::npos)
    return {{},
            "a file in the scene's folder or below, or in that of a variable, \"$NAME/...\"",
            "\"" + name + "\""};
  return {base / rest, "", ""};
}

namespace reader {

std::optional<std::filesystem::path> resolve_path(const std::string& text,
                                                  const std::filesystem::path& folder,
                                                  const std::string& path, int line, FaultList& faults) {
  NamedFile named = named_file(text, folder);
  if (!named.file.empty())
    return std::move(named.file);
  faults.add(line, path, std::move(named.expected), std::move(named.found));
  return std::nullopt;
}

void adopt(const InputError& error, const std::string& path, int line, FaultList& faults) {
  for (const Fault& fault : error.faults())
    faults.add(line, path, fault.expected,
               fault.file + (fault.line > 0 ? ":" + std::to_string(fault.line) : "") + ": " +
                   (fault.key.empty() ? "" : fault.key + ": ") + fault.found);
}

} // namespace reader

} // namespace maille
