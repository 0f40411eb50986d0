#pragma once
/// The commands of `maille` as a table, and what `--help` and messages about wrong words say of them.

#include <CLI/CLI.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Adds a command's options. What it returns runs the command with them, and answers with an exit code.
using AddCommand = std::function<std::function<int()>(CLI::App* command)>;

/// What a user wants of a command: the heading that it stands under in the help.
inline constexpr const char *to_model = "Model", *to_solve = "Solve", *to_vary = "Vary", *to_see = "See",
                            *not_listed = "";

struct Command {
  const char* group;
  std::string name, description; ///< `study-trade` is shown as `study trade`
  std::string example, page;     ///< at the end of its help; the page is in docs/
  AddCommand add;
  bool reads_scenes = true; ///< --sandbox keeps their files together
};

/// The parser of the whole command line. @param code  what the command that was asked for answers with
std::unique_ptr<CLI::App> whole_command_line(int& code);

/// All of them, in the order of the help.
std::vector<Command> all_commands();

/// The methods, a line each, with what commands ask where nothing is said.
std::string methods_in_words();
/// The words that results have in tables, CSV and JSON, a line each.
std::string words_of_results();
/// The text of `maille help TOPIC` where that is no command: methods, results, columns.
std::optional<std::string> help_topic(const std::string& topic);

/// What is wrong with the TOPIC of `maille help TOPIC`; nothing where there is such a command, or list.
std::optional<std::string> unknown_topic(const CLI::App& app, const std::string& topic);

/// ` (did you mean "WORD"?)`, or nothing where no candidate is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);
/// What is wrong with a command line, in the words of every other message.
std::string wrong_words(const CLI::App& app, const CLI::Error& error);

/// Prints an option without the marks of the library's insides.
class HelpFormat : public CLI::Formatter {
public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_usage(const CLI::Option* option) const override;
  std::string make_usage(const CLI::App* app, std::string name) const override;
};

/// An example and the page of the docs, below a command's help.
std::string footer_of(const Command& command);
/// Where to go on, below the help on `maille` itself.
std::string footer_of_all();

/// The words of a command line as the parser takes them: `help COMMAND` is `COMMAND --help`, `version` is
/// `--version`, `study trade` is `study-trade`, and a list goes on behind a comma and a blank. Commands of
/// version 0.2 become what they are now.
/// @param hint becomes the sentence that names the new words, where old ones were used
std::vector<std::string> in_parsers_words(std::vector<std::string> words, std::string* hint = nullptr);
/// `study trade` of `study-trade`.
std::string shown_name(std::string name);

/// The files of cli/texts, compiled in (cmake/embed_texts.cmake): a program needs no path at run time.
std::string_view bash_txt(), zsh_txt(), methods_txt(), results_txt();
std::string_view calf_toml(), landmarks_fcsv(), path_toml(), strip_toml(), world_toml();

} // namespace maille::studies
