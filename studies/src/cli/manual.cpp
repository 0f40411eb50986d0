/// `maille manual`: manual pages and shell completions, generated from the options of `--help`.

#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>

#include <sstream>
#include <vector>

namespace maille::studies {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

/// Escapes text for roff: hyphens stay hyphens, and no line becomes a request.
std::string roff(const std::string& text) {
  std::istringstream lines(replaced(replaced(text, "\\", "\\e"), "-", "\\-"));
  std::string out;
  for (std::string line; std::getline(lines, line); out += line + "\n")
    if (line.starts_with('.') || line.starts_with('\''))
      line.insert(0, "\\&");
  if (!text.ends_with('\n') && !out.empty())
    out.pop_back();
  return out;
}

std::string head(const std::string& name, const std::string& description) {
  std::string upper = name;
  for (char& c : upper)
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(".TH {} 1 \"\" \"maille {}\" \"Maille\"\n.SH NAME\n{} \\- {}\n", roff(upper), version,
                     roff(name), roff(description));
}

/// Preformatted text, line by line.
std::string as_it_stands(const std::string& title, const std::string& text) {
  std::string body = text;
  while (body.starts_with('\n'))
    body.erase(0, 1);
  if (!body.ends_with('\n'))
    body += '\n';
  return fmt::format(".SH {}\n.nf\n{}.fi\n", title, replaced(roff(body), "\n\n", "\n.sp\n"));
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  std::vector<const CLI::Option*> list;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_positional() && option->get_group() != "")
      list.push_back(option);
  return list;
}

/// `--json [FILE]`: names and values of an option. The default number of threads is omitted, because it
/// depends on the machine.
std::string signature(const CLI::Option& option) {
  const HelpFormat format;
  std::string text = format.make_option_name(&option, false) + format.make_option_opts(&option);
  if (option.get_name() == "--threads")
    text = "--threads NUMBER";
  return text;
}

std::string roff_options(const CLI::App& app) {
  std::string text = ".SH OPTIONS\n";
  const HelpFormat format;
  for (const CLI::Option* option : app.get_options())
    text += fmt::format(
        ".TP\n.B {}\n{}\n",
        roff(option->get_positional() ? format.make_option_name(option, true) : signature(*option)),
        roff(option->get_description()));
  return text;
}

/// Allowed values of an option, if its type lists them: `TEXT:{displacement,strain,stress}`.
std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t first = type.find('{'), last = type.find('}');
  if (const auto& name = option.get_name();
      name.find("--method") != std::string::npos || name == "--reference") {
    std::vector<std::string> names = all_methods();
    if (name == "--reference")
      names.push_back("best");
    return names;
  }
  std::vector<std::string> words;
  if (first == std::string::npos || last == std::string::npos)
    return words;
  std::istringstream list(type.substr(first + 1, last - first - 1));
  for (std::string word; std::getline(list, word, ',');)
    words.push_back(word);
  return words;
}

bool takes_value(const CLI::Option& option) {
  return option.get_expected_max() > 0 && option.get_type_size_max() > 0;
}

/// Names on the command line: `--method` and `--methods`.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_lnames())
    names.push_back("--" + name);
  for (const std::string& name : option.get_snames())
    names.push_back("-" + name);
  return names;
}

/// Commands in the manual: all except those of older versions, and this one.
std::vector<const CLI::App*> described(const CLI::App& app) {
  std::vector<const CLI::App*> list;
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_group().empty() || command->get_name().starts_with("study-"))
      list.push_back(command);
  return list;
}

std::vector<std::string> topics_of(const CLI::App& app) {
  std::vector<std::string> topics{"methods", "results", "mechanics", "columns"};
  for (const CLI::App* command : described(app))
    topics.push_back(command->get_name());
  return topics;
}

/// Escapes text for single quotes in zsh's _arguments, where colons and brackets are special.
std::string in_zsh(std::string text) {
  for (const auto& [what, by] : {std::pair{"'", "'\\''"}, {"[", "\\["}, {"]", "\\]"}, {":", "\\:"}})
    text = replaced(text, what, by);
  return text;
}

/// The page `maille-COMMAND.1`.
std::string page_of(const CLI::App& command) {
  const HelpFormat format;
  std::string usage = format.make_usage(&command, "maille " + command.get_name());
  usage = replaced(usage, "Usage: ", "");
  while (usage.ends_with('\n'))
    usage.pop_back();
  return head("maille-" + command.get_name(), command.get_description()) + ".SH SYNOPSIS\n.B " + roff(usage) +
         "\n" + roff_options(command) + as_it_stands("EXAMPLE AND MORE", command.get_footer()) +
         ".SH SEE ALSO\n.BR maille (1)\n";
}

/// The page `maille.1`: all commands, the methods, the result columns.
std::string page_of_all(const CLI::App& app) {
  std::string text = head("maille", app.get_description()) +
                     ".SH SYNOPSIS\n.B maille\n.I COMMAND\n.RI [ OPTIONS ]\n" + roff_options(app) +
                     ".SH COMMANDS\n";
  for (const CLI::App* command : described(app))
    text += fmt::format(".TP\n.BR maille\\-{} (1)\n{}\n", roff(command->get_name()),
                        roff(command->get_description()));
  return text + as_it_stands("METHODS", methods_in_words()) + as_it_stands("RESULTS", words_of_results()) +
         as_it_stands("MORE", app.get_footer());
}

/// Completes options of the present command, their values, method names, or files.
std::string bash_completion(const CLI::App& app) {
  std::string options, values;
  std::vector<std::string> commands{"help"};
  for (const CLI::App* command : described(app)) {
    commands.push_back(command->get_name());
    std::vector<std::string> names;
    for (const CLI::Option* option : options_of(*command)) {
      const auto own = names_of(*option);
      names.insert(names.end(), own.begin(), own.end());
      if (const auto choices = choices_of(*option); takes_value(*option) && !choices.empty())
        for (const std::string& name : own)
          values +=
              fmt::format("    {}:{}) words='{}' ;;\n", command->get_name(), name, fmt::join(choices, " "));
    }
    options += fmt::format("    {}) options='{}' ;;\n", command->get_name(), fmt::join(names, " "));
    for (const CLI::Option* option : command->get_options())
      if (const auto choices = choices_of(*option); option->get_positional() && !choices.empty())
        values += fmt::format("    {0}:{0}) words='{1}' ;;\n", command->get_name(), fmt::join(choices, " "));
  }
  return fmt::format(fmt::runtime(bash_txt()), fmt::join(commands, " "), fmt::join(topics_of(app), " "),
                     options, values);
}

/// Completion for zsh, with the meanings of options.
std::string zsh_completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : described(app)) {
    commands += fmt::format("    '{}:{}'\n", command->get_name(), in_zsh(command->get_description()));
    std::string arguments;
    for (const CLI::Option* option : options_of(*command))
      for (const std::string& name : names_of(*option)) {
        const auto choices = choices_of(*option);
        const std::string value = !takes_value(*option) ? ""
                                  : choices.empty()     ? ":value:_files"
                                  : option->get_delimiter() == ','
                                      ? fmt::format(":value:_sequence compadd - {}", fmt::join(choices, " "))
                                      : fmt::format(":value:({})", fmt::join(choices, " "));
        arguments += fmt::format(" \\\n        '{}[{}]{}'", name, in_zsh(option->get_description()), value);
      }
    // The command itself is the first word that is not an option.
    for (const CLI::Option* option : command->get_options())
      if (const auto choices = choices_of(*option); option->get_positional() && !choices.empty())
        arguments += fmt::format(" \\\n        '1: : ' \\\n        '2:{}:({})'", command->get_name(),
                                 fmt::join(choices, " "));
    cases += fmt::format("      {})\n      _arguments{} \\\n        '*:file:_files' ;;\n",
                         command->get_name(), arguments);
  }
  return fmt::format(fmt::runtime(zsh_txt()), commands, fmt::join(topics_of(app), " "), cases);
}

} // namespace

int manual_command(const ManualOptions& options) {
  prepare_folder(options.out);
  int ignored = exit_done;
  const auto app = whole_command_line(ignored);
  const auto write = [&](const std::filesystem::path& file, const std::string& text) {
    std::filesystem::create_directories((options.out / file).parent_path());
    write_whole(options.out / file, text);
  };
  write("man/man1/maille.1", page_of_all(*app));
  for (const CLI::App* command : described(*app))
    write("man/man1/maille-" + command->get_name() + ".1", page_of(*command));
  write("bash-completion/completions/maille", bash_completion(*app));
  write("zsh/vendor-completions/_maille", zsh_completion(*app));
  return exit_done;
}

} // namespace maille::studies
