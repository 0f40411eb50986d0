#pragma once
/// Runs the `maille` command as outside scripts do.

#include "support/kit.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include <sys/wait.h>

namespace maille::test {

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs a command with its standard output and error caught apart.
inline Outcome shell(const std::string& command) {
  const TemporaryFolder folder;
  const std::string err_file = (folder / "err").string();
  const std::string line = command + " 2>" + err_file;
  FILE* pipe = popen(line.c_str(), "r");
  Outcome outcome;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe))
    outcome.out.append(buffer.data(), n);
  outcome.code = WEXITSTATUS(pclose(pipe));
  outcome.err = text_of(err_file);
  return outcome;
}

inline Outcome maille_command(const std::string& arguments) {
  return shell(std::string(MAILLE_COMMAND) + " " + arguments);
}

/// A command line with words replaced by paths. One pass: a temporary path may contain one of the words.
inline std::string with_paths(const std::string& line,
                              const std::vector<std::pair<std::string, std::string>>& paths) {
  std::string filled;
  for (std::size_t at = 0; at < line.size();) {
    const auto word = std::ranges::find_if(
        paths, [&](const auto& pair) { return line.compare(at, pair.first.size(), pair.first) == 0; });
    filled += word == paths.end() ? line.substr(at, 1) : word->second;
    at += word == paths.end() ? 1 : word->first.size();
  }
  return filled;
}

/// A command that has to end with an exit code: 0, or 2 for faulty input or use.
inline Outcome done(const std::string& arguments, int code = 0) {
  Outcome run = maille_command(arguments);
  EXPECT_EQ(run.code, code) << arguments << '\n' << run.err;
  return run;
}
/// What a command that has to succeed prints.
inline nlohmann::json json_of(const std::string& arguments) {
  return nlohmann::json::parse(done(arguments).out);
}
inline Outcome refused(const std::string& arguments) {
  return done(arguments, 2);
}

/// Uses that are refused, each with a part of what is said.
inline void expect_refused(const std::vector<std::pair<std::string, std::string>>& uses) {
  for (const auto& [arguments, part] : uses)
    EXPECT_TRUE(has(refused(arguments).err, part)) << arguments;
}

} // namespace maille::test
