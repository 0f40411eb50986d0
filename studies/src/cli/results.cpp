#include "cli/commands.hpp"
#include "inputs.hpp"
#include "json_parts.hpp"

#include "maille/materials/fault.hpp"
#include "program.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

namespace maille::studies {

namespace {

std::vector<std::string> words_of_caller;

} // namespace

std::string in_shell(const std::string& word) {
  const bool is_plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) ||
           std::string_view("-_./,=:+@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  return is_plain ? word : shell_word(word);
}

void keep_command_line(int argc, char** argv) {
  words_of_caller.assign(argv, argv + argc);
  words_of_caller.front() = "maille";
}

std::string command_line() {
  std::string line;
  for (const std::string& word : words_of_caller)
    line += (line.empty() ? "" : " ") + in_shell(word);
  return line;
}

nlohmann::ordered_json asked_about(const std::filesystem::path& file, const std::string& explanation) {
  nlohmann::ordered_json about = made_by();
  about.update({{"command", command_line()},
                {"scene_file", std::filesystem::absolute(file).string()},
                {"scene_text", scene_text_of(file)},
                {"explanation", explanation}});
  return about;
}

std::filesystem::path finish(ResultsFolder& folder, const Scene& scene, const std::vector<AnswerFile>& files,
                             nlohmann::ordered_json results) {
  nlohmann::ordered_json all{{"title", scene.title},
                             {"explanation", explanation(scene)},
                             {"files", nlohmann::ordered_json::array()},
                             {"results", std::move(results)}};
  for (const AnswerFile& file : files)
    all["files"].push_back({{"method", file.method}, {"file", file.file}});
  return folder.finish(std::move(all));
}

bool is_cut_short(const Control& control, bool has_answers, bool has_files) {
  if (has_answers || !control.should_stop())
    return false;
  if (has_files)
    fmt::print(stderr, "interrupted before there was an answer: earlier files stay as they are\n");
  return true;
}

} // namespace maille::studies
