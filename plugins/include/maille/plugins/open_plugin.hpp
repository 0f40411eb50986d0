#pragma once
/// Parts of Maille that are separate shared objects, because their dependencies load slowly: they are opened
/// at first use.

#include <cstddef>
#include <string>
#include <vector>

namespace maille {

/// A number that differs between builds if the size of a type differs; for open_plugin.
template<class... Types>
constexpr std::size_t layout_of() {
  std::size_t number = sizeof...(Types);
  ((number = number * 1'000'003 + sizeof(Types)), ...);
  return number;
}

/// @brief Opens a plugin, which stays open until the process ends, and returns the table of its functions.
///
/// It is searched for in the library path of the program or the shared object that contains this function:
/// LD_LIBRARY_PATH, then the RUNPATH. The plugin exports one function, `const void* maille_plugin(std::size_t
/// layout, const void* host)`, which returns nullptr if `layout` is not its own.
///
/// @param file    "maille-fem.so"
/// @param what    the feature that needs it, for the message: "finite elements (deal.II)"
/// @param layout  layout_of() the types of its function table and of their arguments
/// @param host    functions that the plugin may call, of a type that both define
/// @throws std::runtime_error if it, or a library that it needs, is missing, or it is from another build
const void* open_plugin(const char* file, const char* what, std::size_t layout, const void* host = nullptr);

/// Folders that open_plugin searches, in order.
std::vector<std::string> plugin_folders();

/// True if one of these folders has the file.
bool has_plugin(const char* file);

/// The path of a plugin or a program whose length matches its ELF headers: a truncated one, from an
/// interrupted copy, would kill the process by a signal.
/// @param needs  the beginning of the message: "finite elements need"
/// @throws std::runtime_error if it is missing
std::string find_plugin(const char* file, const std::string& needs, const char* advice = "");

} // namespace maille
