#pragma once
/// The commands of `maille` as a table.

#include <CLI/CLI.hpp>

#include <functional>
#include <string>
#include <vector>

namespace maille::studies {

struct Command {
  std::string name, description;
  std::string example, page; ///< at the end of its help; the page is in docs/
  /// Adds its options. What it returns runs the command with them, and answers with an exit code.
  std::function<std::function<int()>(CLI::App* command)> add;
  bool reads_scenes = true; ///< --sandbox keeps their files together
};

/// All of them, in the order of the help.
std::vector<Command> all_commands();

} // namespace maille::studies
