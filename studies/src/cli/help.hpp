#pragma once
/// Table of the commands of `maille`; texts of `--help` and of messages about unknown words.

#include <CLI/CLI.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Adds the options of a command. The returned function runs the command and returns its exit code.
using AddCommand = std::function<std::function<int()>(CLI::App* command)>;

/// Heading of a command in the help.
inline constexpr const char *to_model = "Model", *to_solve = "Solve", *to_vary = "Vary", *to_see = "See",
                            *not_listed = "";

struct Command {
  const char* group;
  std::string name, description; ///< `study-trade` is displayed as `study trade`
  std::string example, page;     ///< in the footer of its help; the page is in docs/
  AddCommand add;
  bool reads_scenes = true; ///< --sandbox keeps their files together
};

/// Parser of the whole command line. @param code  receives the exit code of the command
std::unique_ptr<CLI::App> whole_command_line(int& code);

/// All commands, in the order of the help.
std::vector<Command> all_commands();

/// The methods, one per line, with the default methods of commands.
std::string methods_in_words();
/// Names of result columns in tables, CSV and JSON, one per line.
std::string words_of_results();
/// Text of `maille help TOPIC` for topics that are no commands: methods, results, columns.
std::optional<std::string> help_topic(const std::string& topic);

/// Error message for the TOPIC of `maille help TOPIC`; nothing if that command or list exists.
std::optional<std::string> unknown_topic(const CLI::App& app, const std::string& topic);

/// ` (did you mean "WORD"?)`, or empty without a similar candidate.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);
/// Error message for a command line, in the style of all other messages.
std::string wrong_words(const CLI::App& app, const CLI::Error& error);

/// Prints an option without internal markers of the library.
class HelpFormat : public CLI::Formatter {
public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_usage(const CLI::Option* option) const override;
  std::string make_usage(const CLI::App* app, std::string name) const override;
};

/// Footer of a command's help: an example and the page of the docs.
std::string footer_of(const Command& command);
/// Footer of the help of `maille` itself: next steps.
std::string footer_of_all();

/// Normalises a command line for the parser: `help COMMAND` becomes `COMMAND --help`, `version` becomes
/// `--version`, `study trade` becomes `study-trade`, and a list may continue after a comma and a blank.
/// Commands of version 0.2 become the present ones.
/// @param hint receives a sentence with the new words if old ones were used
std::vector<std::string> in_parsers_words(std::vector<std::string> words, std::string* hint = nullptr);
/// Displayed name: `study trade` for `study-trade`.
std::string shown_name(std::string name);

/// The files of cli/texts, compiled in (cmake/embed_texts.cmake): a program needs no path at run time.
std::string_view bash_txt(), zsh_txt(), methods_txt(), results_txt();
std::string_view calf_toml(), landmarks_fcsv(), path_toml(), strip_toml(), world_toml();

} // namespace maille::studies
