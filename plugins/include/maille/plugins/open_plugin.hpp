#pragma once
/// Parts of Maille that are shared objects of their own, because what they stand on takes long to load: they
/// are opened when they are first needed.

#include <cstddef>
#include <string>
#include <vector>

namespace maille {

/// A number that differs between builds where one of the types does; for open_plugin.
template<class... Types>
constexpr std::size_t layout_of() {
  std::size_t number = sizeof...(Types);
  ((number = number * 1'000'003 + sizeof(Types)), ...);
  return number;
}

/// @brief Opens a plugin, which stays open until the process ends, and returns the table of its functions.
///
/// It is looked for where the program, or the shared object that holds this function, looks for its own
/// libraries: LD_LIBRARY_PATH, then the RUNPATH that it was linked with. The plugin exports one function,
/// `const void* maille_plugin(std::size_t layout, const void* host)`, which answers nullptr where `layout` is
/// not its own.
///
/// @param file    "maille-fem.so"
/// @param what    what needs it, for the message: "finite elements (deal.II)"
/// @param layout  layout_of() what is passed to its functions, and of their table
/// @param host    what it may call here, of a type that both know
/// @throws std::runtime_error where it is not there, a library of it is not, or it is of another build
const void* open_plugin(const char* file, const char* what, std::size_t layout, const void* host = nullptr);

/// Folders in which open_plugin looks, in that order.
std::vector<std::string> plugin_folders();

/// Whether one of these folders has the file.
bool has_plugin(const char* file);

/// The path there of a plugin or a program that is as long as its ELF headers say: a shorter one, of an
/// interrupted copy, would end the process by a signal.
/// @param needs  the beginning of the message: "finite elements need"
/// @throws std::runtime_error where it is missing
std::string find_plugin(const char* file, const std::string& needs, const char* advice = "");

} // namespace maille
