#pragma once
/// Command-line options of the commands.

#include "cli/commands.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace maille::studies {

/// Adds the common options of commands that read a scene or world.
void add_common(CLI::App* command, CommonOptions& options);
/// Each adds the options of one command.
void add_compare(CLI::App* command, CompareOptions& options);
void add_run(CLI::App* command, RunOptions& options);
void add_warp(CLI::App* command, WarpCommandOptions& options);
void add_play(CLI::App* command, PlayOptions& options);
void add_render(CLI::App* command, RenderOptions& options);
/// Adds camera and stereo options for volume pictures. Weak symbols, like the commands that use them.
void add_camera(CLI::App* command, CameraOptions& camera);
void add_stereo(CLI::App* command, std::string& stereo);
/// Adds options for a recorded hand. Weak too. @return the options
std::vector<CLI::Option*> add_feeling(CLI::App* command, FeelOptions& options);
void add_fit(CLI::App* command, FitOptions& options);
void add_trade(CLI::App* command, TradeOptions& options);
void add_choose(CLI::App* command, ChooseOptions& options);
void add_study(CLI::App* command, StudyCommandOptions& options);
void add_merge(CLI::App* command, MergeOptions& options);
void add_check(CLI::App* command, CheckOptions& options);
void add_new(CLI::App* command, NewOptions& options);
void add_report(CLI::App* command, ReportOptions& options);
void add_manual(CLI::App* command, ManualOptions& options);

} // namespace maille::studies
