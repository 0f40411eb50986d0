#pragma once
/// From a scene file to a Scene, or to every fault in it at once; and where the files that it names lie.
///
/// A scene may name files (images, surfaces, materials). named_file resolves such a name relative to the
/// scene's folder. In a sandbox no name leads out of that folder, so that a stranger's scene reads nothing
/// else.

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

/// Where a name leads, or why it leads nowhere.
struct NamedFile {
  std::filesystem::path file;  ///< empty: nowhere
  std::string expected, found; ///< then
};

/// Where names may lead.
enum class FileScope {
  anywhere, ///< a user's own files
  /// A stranger's files: only the folder of the file that names them and below, and that of a variable.
  sandbox,
};

/// Sets the scope of all file names of this process; the default is `anywhere`. For programs that read the
/// files of others.
void set_file_scope(FileScope scope);

/// A name as scenes and studies have them: relative to their folder, absolute, `~/...` in the user's home, or
/// in the folder that an environment variable holds (`$NAME/...`). In a sandbox, absolute paths, `~` and `..`
/// are refused, so that a scene from elsewhere reads what lies beside it, and what its user set a variable
/// to, and nothing else. Symbolic links are followed wherever they lead: who put them there is the owner of
/// the folder, not the text of the scene.
NamedFile named_file(const std::string& name, const std::filesystem::path& folder);

/// The nodes of a region, for programs that drive a body by hand.
/// @param where  as scene files have it: `x-`, `superior`, or a table in TOML, `{ label = 17, touching = 30
///         }`; numbers without a unit in SI
/// @return nodes of the body, ascending; empty where none is in it
/// @throws InputError  what is no region
std::vector<std::int64_t> nodes_in(const Scene& scene, std::string_view where);
/// The same of a table that has the key `where`.
std::vector<std::int64_t> nodes_in(const Scene& scene, const KeyTable& table);

} // namespace maille
