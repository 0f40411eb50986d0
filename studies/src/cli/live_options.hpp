#pragma once
/// The command `maille live`: apart from the others, as the room behind it is built apart.

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

struct LiveOptions {
  std::optional<std::filesystem::path> scene;  ///< nothing: the menu of prototypes
  std::optional<std::string> record;           ///< trajectory of what the hand does (CSV)
  std::optional<std::filesystem::path> script; ///< events (CSV)
  std::string device = "mouse";
  std::string method; ///< of a scene of one body; empty: its limits
  std::string size = "1280x800", stereo = "none";
  double text = 0; ///< size of letters; 0: of the screen
  std::optional<std::string> budget;
  std::filesystem::path shots = ".";
  bool headless = false, full_screen = false;
  std::optional<std::string> json;
  int threads = 1;
};

void add_live(CLI::App* command, LiveOptions& options);
int live_command(const LiveOptions& options);

} // namespace maille::studies
