#pragma once
/// The command `maille live`: separate from the others, because its library is built separately.

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

struct LiveOptions {
  std::optional<std::filesystem::path> scene;  ///< nothing: the menu of prototypes
  std::optional<std::string> record;           ///< trajectory of the hand (CSV)
  std::optional<std::filesystem::path> script; ///< events (CSV)
  std::string device = "mouse";
  std::string method; ///< method for a scene of one body; empty: its limits
  std::string size = "1280x800", stereo = "none";
  double text = 0; ///< text scale; 0: from the screen
  std::optional<std::string> budget;
  std::filesystem::path shots = ".";
  bool headless = false, full_screen = false;
  std::optional<std::string> json;
  int threads = 1;
};

void add_live(CLI::App* command, LiveOptions& options);
int live_command(const LiveOptions& options);

} // namespace maille::studies
