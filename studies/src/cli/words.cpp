/// Normalisation of a command line for the parser.
///
/// Commands of version 0.2 are replaced by the present ones, with a hint that names these; old_commands is
/// the complete list. A command of two words (`study trade`) is one word of the parser (`study-trade`). Only
/// words are examined; no file is opened.

#include "cli/help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace maille::studies {

namespace {

/// Commands of version 0.2 and their replacements.
struct OldCommand {
  std::string_view old, now;
};
constexpr std::array<OldCommand, 8> old_commands{{{"explain", "check --why"},
                                                  {"materials", "check TISSUE"},
                                                  {"export", "run --write FILE.inp"},
                                                  {"identify", "fit --measured FILE"},
                                                  {"probe", "play"},
                                                  {"merge", "study merge"},
                                                  {"trade", "study trade"},
                                                  {"choose", "study choose"}}};

/// Rewrites `export SCENE --format ccx --out FILE` as `run SCENE --write FILE`.
void make_run_of_export(std::vector<std::string>& words) {
  words[0] = "run";
  if (const auto format = std::ranges::find(words, "--format");
      format != words.end() && format + 1 != words.end() && format[1] == "ccx")
    words.erase(format, format + 2);
  if (std::ranges::any_of(words, [](const std::string& word) { return word == "--help" || word == "-h"; }))
    return;
  if (const auto out = std::ranges::find(words, "--out"); out != words.end())
    *out = "--write";
  else
    words.insert(words.end(), {"--write", "-"});
}

void replace_old_command(std::vector<std::string>& words, std::string* hint) {
  const auto* const old = std::ranges::find(old_commands, words[0], &OldCommand::old);
  if (old == old_commands.end())
    return;
  if (hint != nullptr)
    *hint = fmt::format("maille {} is now maille {}", old->old, old->now);
  if (words[0] == "export")
    return make_run_of_export(words);
  const bool is_of_library = words[0] == "materials" && (words.size() == 1 || words[1].starts_with('-'));
  if (words[0] == "explain")
    words.insert(words.begin() + 1, "--why");
  if (is_of_library)
    words.insert(words.begin() + 1, "library");
  words[0] = old->now.starts_with("study ") ? "study-" + words[0] : old->now.substr(0, old->now.find(' '));
}

} // namespace

std::vector<std::string> in_parsers_words(std::vector<std::string> words, std::string* hint) {
  if (!words.empty() && (words[0] == "version" || words[0] == "-v"))
    words[0] = "--version";
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    words.resize(std::min<std::size_t>(words.size(), words.empty() || words[0] != "study" ? 1 : 2));
    words.emplace_back("--help");
  }
  const std::size_t at = !words.empty() && words[0] == "--sandbox" ? 1 : 0;
  if (words.size() > at) {
    std::vector<std::string> own(words.begin() + static_cast<std::ptrdiff_t>(at), words.end());
    replace_old_command(own, hint);
    if (own.size() > 1 && own[0] == "study" &&
        (own[1] == "trade" || own[1] == "choose" || own[1] == "merge")) {
      own[0] += "-" + own[1];
      own.erase(own.begin() + 1);
    }
    words.resize(at);
    words.insert(words.end(), own.begin(), own.end());
  }
  constexpr std::array<std::string_view, 8> lists{"--methods",    "--unknown", "--method", "--spacings",
                                                  "--tolerances", "--table",   "--also",   "--surface"};
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    if (std::find(lists.begin(), lists.end(), words[i]) == lists.end())
      continue;
    std::string& list = words[i + 1];
    while (list.ends_with(',') && i + 2 < words.size() && !words[i + 2].starts_with('-')) {
      list += words[i + 2];
      words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) + 2);
    }
    if (words[i] != "--table" &&
        words[i] != "--unknown") // blanks are letters of a file's name, or stand between words
      std::erase(words[i + 1], ' ');
  }
  return words;
}

} // namespace maille::studies
