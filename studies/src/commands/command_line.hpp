#pragma once
/// What every command takes on its command line.

#include "commands/commands.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

/// `--json` alone prints to stdout, `--json FILE` writes a file. A following scene is not taken for that
/// file.
/// @param scene where the command has one: it must be there
void add_json(CLI::App* command, std::optional<std::string>& json, std::filesystem::path* scene);
void add_common(CLI::App* command, CommonOptions& options);
void add_solving(CLI::App* command, std::string& fem_solver, int& threads);
void add_running(CLI::App* command, AnswerOptions& options);
void add_fit(CLI::App* command, FitOptions& options);
void add_trade(CLI::App* command, TradeOptions& options);
void add_choose(CLI::App* command, ChooseOptions& options);
void add_study(CLI::App* command, StudyCommandOptions& options);
void add_stability(CLI::App* command, StabilityCommandOptions& options, int& code);
void add_play(CLI::App* command, PlayOptions& options);
void add_probe(CLI::App* command, ProbeCommandOptions& options);

} // namespace maille::studies
