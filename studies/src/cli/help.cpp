/// Table of commands, and the texts of --help derived from it. A command is one line of all_commands(): its
/// name, an example, its page, and the reader of its options.

#include "cli/help.hpp"

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/live_options.hpp"
#include "compare/comparison_columns.hpp"
#include "compare/force_curve.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/version.hpp"
#include "mechanics/mechanics_report.hpp"
#include "study/table_files.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace maille::studies {

namespace {

std::string line_of(const std::string& csv, const std::string& json, const std::string& unit,
                    const std::string& meaning) {
  const auto shown = [](const std::string& text) { return text.empty() ? "-" : text; };
  return fmt::format("  {:<23} {:<29} {:<9} {}\n", shown(csv), shown(json), shown(unit), meaning);
}

/// One line per column, followed by the columns of a nested table.
/// @param group prefix of their keys, such as `results[].`
std::string lines_of(const Columns& columns, const std::string& group) {
  std::string text;
  for (const Column& column : columns.list()) {
    if (column.csv.empty() && column.json.empty())
      continue;
    const std::string key = column.json.empty() ? "" : group + column.json;
    text += line_of(column.is_open ? "(one each)" : column.csv, key, column.unit, column.meaning);
    if (column.within != nullptr)
      text += lines_of(*column.within, key + (column.is_list ? "[]." : "."));
  }
  return text;
}

std::string dictionary_of(const char* title, const Columns& columns) {
  return fmt::format("{}\n{}{}", title, line_of("CSV", "JSON", "unit", "meaning"), lines_of(columns, ""));
}

/// The columns of `run`, `compare`, `study` and `trade`: names in CSV and JSON, units, meanings.
std::string columns_in_words() {
  return dictionary_of("compare, a row a method:", columns_of_comparison()) + "\n" +
         dictionary_of("mechanics of run and compare, a row a label, a material or the body:",
                       columns_of_parts()) +
         "\n" + dictionary_of("mechanics, a row a hold, a move or a load:", columns_of_resultants()) + "\n" +
         dictionary_of("run --steps, a row a step:", columns_of_curve()) + "\n" +
         dictionary_of("study, a row a case and a method:", columns_of_study()) + "\n" +
         dictionary_of("trade, a row a method, a lattice and a tolerance:", columns_of_trade());
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names{"help", "version"};
  for (const CLI::App* command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames())
      names.push_back("--" + name);
  return names;
}

/// Words that the parser lists after "The following arguments were not expected: "; none for other messages.
std::vector<std::string> unexpected_words(const std::string& message) {
  const std::size_t colon = message.find(" not expected: ");
  std::vector<std::string> words;
  if (colon == std::string::npos)
    return words;
  std::istringstream list(message.substr(colon + 15));
  for (std::string word; list >> word;)
    words.push_back(word);
  return words;
}

} // namespace

std::string methods_in_words() {
  return std::string(methods_txt());
}

std::string words_of_results() {
  return std::string(results_txt());
}

std::optional<std::string> help_topic(const std::string& topic) {
  if (topic == "methods")
    return methods_in_words();
  if (topic == "results")
    return words_of_results();
  if (topic == "mechanics")
    return std::string(mechanics_conventions());
  if (topic == "columns")
    return columns_in_words();
  return std::nullopt;
}

std::optional<std::string> unknown_topic(const CLI::App& app, const std::string& topic) {
  std::vector<std::string> topics = commands_of(app);
  topics.insert(topics.end(), {"methods", "results", "mechanics", "columns"});
  if (topic.starts_with('-') || std::find(topics.begin(), topics.end(), topic) != topics.end())
    return std::nullopt;
  return fmt::format("expected a command, methods, results, mechanics or columns, found \"{}\"{}", topic,
                     did_you_mean(topic, topics));
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string_view meant =
      nearest_spelling(word, std::vector<std::string_view>(candidates.begin(), candidates.end()));
  return meant.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", meant);
}

std::string wrong_words(const CLI::App& app, const CLI::Error& error) {
  const auto asked = app.get_subcommands();
  const std::vector<std::string> words = asked.empty() ? app.remaining() : unexpected_words(error.what());
  if (asked.empty()) { // the word in the place of a command
    if (words.empty())
      return "maille: expected a command; maille --help lists them";
    const bool is_option = words.front().starts_with('-');
    return fmt::format("maille: expected a command, found \"{}\"{}", words.front(),
                       did_you_mean(words.front(), is_option ? options_of(app) : commands_of(app)));
  }
  const CLI::App& command = *asked.front();
  const std::string asked_name = shown_name(command.get_name());
  const auto option =
      std::find_if(words.begin(), words.end(), [](const std::string& word) { return word.starts_with("-"); });
  if (option != words.end()) {
    const std::string name = option->substr(0, option->find('='));
    return fmt::format("maille {}: expected an option that it has, found \"{}\"{}", asked_name, name,
                       did_you_mean(name, options_of(command)));
  }
  if (!words.empty())
    return fmt::format("maille {}: expected nothing more, found \"{}\"", asked_name, words.front());
  return fmt::format("maille {}: {}", asked_name, error.what());
}

std::string HelpFormat::make_option_name(const CLI::Option* option, bool is_positional) const {
  std::string name = CLI::Formatter::make_option_name(option, is_positional);
  for (std::size_t at = name.find("{false}"); at != std::string::npos; at = name.find("{false}"))
    name.erase(at, 7); // a negated flag
  return name;
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  if (option->get_name() == "--json")
    return " [FILE]";
  std::string text = CLI::Formatter::make_option_opts(option);
  for (const std::string_view noise : {" ...", " REQUIRED"})
    if (const std::size_t at = text.find(noise); at != std::string::npos && !option->get_positional())
      text.erase(at, noise.size());
  return text;
}

std::string HelpFormat::make_option_usage(const CLI::Option* option) const {
  const bool takes_many = option->get_expected_max() > 1;
  const bool may_be_left_out = option->get_name(true) == "NAME" || option->get_name(true) == "TRAJECTORY" ||
                               option->get_name(true) == "LABELS";
  const std::string name = option->get_name(true) + (takes_many ? " ..." : "");
  return may_be_left_out && !option->get_required() ? "[" + name + "]" : name;
}

std::string HelpFormat::make_usage(const CLI::App* app, std::string name) const {
  return CLI::Formatter::make_usage(app, shown_name(std::move(name)));
}

std::string shown_name(std::string name) {
  if (const std::size_t at = name.find("study-"); at != std::string::npos)
    name[at + 5] = ' ';
  return name;
}

std::string footer_of(const Command& command) {
  const std::string text = fmt::format("Example: {}\nMore:    docs/{}", command.example, command.page);
  const bool takes_methods = command.name == "run" || command.name == "compare";
  return "\n" + (takes_methods
                     ? methods_in_words() + "\n" + text + ", maille help results, maille help mechanics"
                     : text);
}

std::string footer_of_all() {
  return "\nmaille help COMMAND, maille help methods, maille help results. Start: maille run SCENE.toml\n"
         "Documents: docs/ of the sources; share/doc/maille/docs of what is installed";
}

namespace {

void add_sandbox(CLI::App& app) {
  app.add_flag_callback(
      "--sandbox", [] { set_file_scope(FileScope::sandbox); },
      "files that the scene names must lie in its folder or below, or in that of a variable: for scenes "
      "of others");
}

void add_overwrite(CLI::App& app) {
  app.add_flag_callback(
      "--overwrite", [] { may_overwrite() = true; }, "replace files and results of others");
}

/// Creates options that live as long as the function that runs the command with them.
template<class Options>
AddCommand taking(void (*add)(CLI::App*, Options&), int (*run)(const Options&)) {
  return [add, run](CLI::App* command) {
    const auto options = std::make_shared<Options>();
    add(command, *options);
    return [options, run] { return run(*options); };
  };
}

} // namespace

std::unique_ptr<CLI::App> whole_command_line(int& code) {
  auto app = std::make_unique<CLI::App>(
      "Deforms voxel models by neighbour limits and checks them against finite elements.", "maille");
  app->set_version_flag("-v,--version",
                        fmt::format("maille {}{}", version, *commit() ? fmt::format(" ({})", commit()) : ""));
  add_sandbox(*app);
  app->formatter(std::make_shared<HelpFormat>());
  app->require_subcommand(1);
  app->failure_message([](const CLI::App* asked, const CLI::Error& error) {
    return wrong_words(*asked, error) + "\nRun with --help for more information.\n";
  });
  for (const Command& command : all_commands()) {
    CLI::App* const added = app->add_subcommand(command.name, command.description);
    added->group(command.group);
    added->final_callback([run = command.add(added), &code] { code = run(); });
    added->footer(footer_of(command));
    if (command.name != "study-merge" && command.name != "manual")
      add_overwrite(*added);
    if (command.reads_scenes)
      add_sandbox(*added);
  }
  app->footer(footer_of_all());
  return app;
}

std::vector<Command> all_commands() {
  return {
      {to_model, "new",
       "Write a commented scene, ready to run: a strip, a sample calf, the labels of an image, or a world",
       "maille new image labels.nii.gz", "scene.md", taking(add_new, new_command), false},
      {to_model, "check",
       "Report every fault of a scene, a world, a study, a trajectory or a material; show a tissue of the "
       "library",
       "maille check strip.toml --why", "scene.md", taking(add_check, check_any_command)},
      {to_solve, "run", "Answer a scene by one or more methods, at once or in steps",
       "maille run strip.toml --steps 10 --out out/strip", "command.md", taking(add_run, run_command)},
      {to_solve, "compare", "Answer a scene by several methods and measure them against FEM",
       "maille compare strip.toml --methods limits,coupled,fem_q1 --out out/strip", "files.md",
       taking(add_compare, compare_command)},
      {to_vary, "study",
       "Run methods over a family of scenes into one table; study trade, study choose, study merge",
       "maille study pennation.toml --out out/pennation", "study.md", taking(add_study, study_command)},
      {not_listed, "study-trade",
       "Measure what accuracy costs: every method, lattice and tolerance, and the Pareto front",
       "maille study trade strip.toml --out out/trade", "trade.md", taking(add_trade, trade_command)},
      {not_listed, "study-choose",
       "Find the cheapest method, lattice and tolerance within an error and a time",
       "maille study choose strip.toml --error 5% --time 16ms", "trade.md",
       taking(add_choose, choose_command)},
      {not_listed, "study-merge", "Put the tables of a study's parts together",
       "maille study merge part1 part2 --out whole", "study.md", taking(add_merge, merge_command), false},
      {to_vary, "fit",
       "Find the limits, or the weights of relaxed, that come nearest to finite elements; or constants from "
       "what was measured",
       "maille fit pull.toml bend.toml --out fitted.toml", "fit.md", taking(add_fit, fit_command)},
      {to_see, "report", "Make one page (HTML) of a folder of results", "maille report out/strip",
       "report.md", taking(add_report, report_command), false},
      {to_see, "render", "Draw a scene as its looks say: grey values, colours, fields of an answer",
       "maille render head.toml --direction 0,1,0 --out head.png", "render.md",
       taking(add_render, render_command)},
      {to_see, "play",
       "Play recorded input against a world of several objects, or feel a scene by a recorded hand",
       "maille play world.toml press.toml --out out/press", "world.md", taking(add_play, play_command)},
      {to_see, "live", "Take a scene into the hand, in a window", "maille live world.toml --record hand.csv",
       "live.md", taking(add_live, live_command)},
      {not_listed, "warp", "Carry an image and its labels along with an answer: now run --warp",
       "maille warp calf.toml --image scan.nii.gz --out out/calf", "images.md",
       taking(add_warp, warp_command)},
      {not_listed, "manual", "Write pages of the manual and completions for bash and zsh",
       "maille manual --out out/manual", "command.md", taking(add_manual, manual_command), false},
  };
}

} // namespace maille::studies
