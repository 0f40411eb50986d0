#pragma once
/// Files that a scene or a study names.

#include <filesystem>
#include <string>

namespace maille {

/// Where a name leads, or why it leads nowhere.
struct NamedFile {
  std::filesystem::path file;  ///< empty: nowhere
  std::string expected, found; ///< then
};

/// A name as scenes and studies have them: relative to their folder, or to the folder that an environment variable holds
/// (`$NAME/...`). It stays in that folder or below: absolute paths and `..` are refused, so that a scene from elsewhere reads what lies
/// beside it, and what its user set a variable to, and nothing else. Symbolic links are followed wherever they lead: who put
/// them there is the owner of the folder, not the text of the scene.
NamedFile named_file(const std::string& name, const std::filesystem::path& folder);

} // namespace maille
