#include "reader.hpp"

#include <cstdlib>

namespace maille::reader {

std::optional<std::filesystem::path> resolve_path(const std::string& text,
                                                  const std::filesystem::path& folder,
                                                  const std::string& path, int line, FaultList& faults) {
  if (text.empty() || text[0] != '$')
    return folder / text;
  const std::string name = text.substr(1, text.find('/') - 1);
  const char* value = std::getenv(name.c_str());
  if (!value || !*value) {
    faults.add(line, path, "the environment variable " + name + " to be set", "\"" + text + "\" without it");
    return std::nullopt;
  }
  const auto slash = text.find('/');
  return std::filesystem::path(value) / (slash == std::string::npos ? "" : text.substr(slash + 1));
}

void adopt(const InputError& error, const std::string& path, int line, FaultList& faults) {
  for (const Fault& fault : error.faults())
    faults.add(line, path, fault.expected,
               fault.file + (fault.line > 0 ? ":" + std::to_string(fault.line) : "") + ": " +
                   (fault.key.empty() ? "" : fault.key + ": ") + fault.found);
}

} // namespace maille::reader
