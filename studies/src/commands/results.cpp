#include "commands.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/version.hpp"
#include "program.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

namespace maille::studies {

namespace {

std::vector<std::string> words_of_caller;

/// Nothing where the file can no longer be read: part of it would be another scene.
std::string text_of(const std::filesystem::path& file) {
  try {
    return read_text_file(file, "a scene file");
  } catch (const InputError&) {
    return {};
  }
}

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
  return {{"command", command_line()},
          {"scene_file", std::filesystem::absolute(file).string()},
          {"scene_text", text_of(file)},
          {"explanation", explanation}};
}

std::filesystem::path write_results(const Scene& scene, const CommonOptions& options, const std::string& kind,
                                    const std::vector<AnswerFile>& files,
                                    const nlohmann::ordered_json& results) {
  nlohmann::ordered_json all{{"kind", kind},
                             {"maille", version},
                             {"command", command_line()},
                             {"scene", scene.name},
                             {"title", scene.title},
                             {"scene_file", std::filesystem::absolute(options.scene).string()},
                             {"scene_text", text_of(options.scene)},
                             {"explanation", explanation(scene)},
                             {"files", nlohmann::ordered_json::array()},
                             {"results", results}};
  for (const AnswerFile& file : files)
    all["files"].push_back({{"method", file.method}, {"file", file.file}});
  const auto path = options.out / fmt::format("{}_{}_results.json", scene.name, kind);
  write_whole(path, all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  return path;
}

} // namespace maille::studies
