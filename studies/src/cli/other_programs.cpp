/// Which of two programs answers a command line.
///
/// `maille` starts in 20 ms because it links few libraries: it has run, compare and check. Every other
/// command, and those three where they need worlds, films or pictures by looks, stands in
/// maille-studies, which has all commands. Both are built from the same command line (help.cpp): a command
/// that a program is not linked with has a null function, and the program then replaces itself by
/// maille-studies with execv, before it reads a file or starts a thread.
///
/// The choice looks at words alone. It may open a scene file to see whether that is a world, so it comes
/// before files are noted as inputs (main.cpp).

#include "cli/help.hpp"
#include "cli/worlds.hpp"
#include "maille/plugins/open_plugin.hpp"
#include "maille/scene/look.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <sys/resource.h>
#include <unistd.h>

namespace maille::studies {
namespace {

/// The one that has all commands; what only some users ask for makes it large.
constexpr const char* whole_program = "maille-studies";

} // namespace

std::optional<Command> asked_command(const std::vector<std::string>& words) {
  const auto word = std::ranges::find_if(words, [](const std::string& one) { return one != "--sandbox"; });
  if (word == words.end())
    return std::nullopt;
  for (Command& command : all_commands())
    if (command.name == *word)
      return std::move(command);
  return std::nullopt;
}

bool is_word_of_tissue(const std::string& word) {
  return !word.empty() && word.front() != '-' && word.find('.') == std::string::npos && word != "check" &&
         !std::filesystem::exists(word);
}

bool is_of_this_program(const Command& command, const std::vector<std::string>& words) {
  if (!command.add)
    return false;
  if (placed != nullptr)
    return true;
  if (command.name == "run")
    return std::ranges::none_of(words, [](const std::string& word) {
      return word.starts_with("--warp") || word.starts_with("--film") || word.starts_with("--write");
    });
  if (command.name == "compare")
    return std::ranges::none_of(words,
                                [](const std::string& word) { return word.starts_with("--picture"); }) ||
           std::ranges::none_of(words, has_look);
  return command.name != "check" || std::ranges::none_of(words, [](const std::string& word) {
           return is_world_scene(word) || is_word_of_tissue(word);
         });
}

void become_program_of(const Command& command, char** argv) {
  const std::string file = find_plugin(whole_program, command.name + " needs the program",
                                       "; of the sources, scripts/build --target maille_programs makes it");
  std::error_code none;
  if (std::filesystem::equivalent(file, "/proc/self/exe", none))
    throw std::runtime_error(fmt::format("{} is in no program of this build", command.name));
  // Under a smaller limit than the program's size the system ends this process by a signal.
  rlimit most{};
  if (getrlimit(RLIMIT_AS, &most) != 0 || most.rlim_cur > 2 * std::filesystem::file_size(file))
    execv(file.c_str(), argv);
  else
    errno = ENOMEM;
  throw std::runtime_error(fmt::format("{} needs the program {}, which cannot be started: {}", command.name,
                                       file, std::strerror(errno)));
}

} // namespace maille::studies
