#pragma once
/// Reads a scene file to a Scene, or reports all its faults at once; and resolves the names of files in it.
///
/// A scene may name files (images, surfaces, materials). named_file resolves such a name relative to the
/// scene's folder. In a sandbox no name leads out of that folder, so that an untrusted scene cannot read
/// other files.

#include "maille/scene/scene.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

struct KeyTable; // maille/materials/toml_reader.hpp

/// Reads a scene file; paths of images are relative to it.
/// @throws InputError with every fault (file, line, key, expected, found)
Scene read_scene(const std::filesystem::path& file);

/// The same from text; `file` gives the name for messages and the folder for images.
Scene parse_scene(std::string_view text, const std::filesystem::path& file = "scene.toml");

/// The file of a name, or the reason for its absence.
struct NamedFile {
  std::filesystem::path file;  ///< empty: none
  std::string expected, found; ///< the reason if `file` is empty
};

/// Folders that names may refer to.
enum class FileScope {
  anywhere, ///< a user's own files
  /// Untrusted files: only the folder of the naming file and below, and that of an environment variable.
  sandbox,
};

/// Sets the scope of all file names of this process; the default is `anywhere`. For programs with untrusted
/// input.
void set_file_scope(FileScope scope);

/// Resolves a name in a scene or study: relative to its folder, absolute, `~/...` in the user's home, or
/// `$NAME/...` in the folder of an environment variable. In a sandbox, absolute paths, `~` and `..` are
/// refused, so that a foreign scene reads only files below its folder and below folders that the user has set
/// variables to. Symbolic links are followed everywhere: the owner of the folder made them, not the text of
/// the scene.
NamedFile named_file(const std::string& name, const std::filesystem::path& folder);

/// The nodes of a region, for programs that move a body interactively.
/// @param where  as in scene files: `x-`, `superior`, or a table in TOML, `{ label = 17, touching = 30 }`;
/// numbers without a unit in SI
/// @return nodes of the body, ascending; may be empty
/// @throws InputError  if `where` is not a region
std::vector<std::int64_t> nodes_in(const Scene& scene, std::string_view where);
/// The same for a table with the key `where`.
std::vector<std::int64_t> nodes_in(const Scene& scene, const KeyTable& table);

} // namespace maille
