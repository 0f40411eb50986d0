#pragma once
/// Every command that writes files, small enough to be run often, and what its files have to be like
/// afterwards.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::test {

struct WritingCommand {
  std::string name;
  std::string arguments; ///< OUT stands for the folder of its files, IN for that of scenes
  int exit_code = 0;     ///< where nothing fails
};

inline void PrintTo(const WritingCommand& command, std::ostream* stream) {
  *stream << command.name;
}

inline const std::vector<WritingCommand>& writing_commands() {
  static const std::vector<WritingCommand> list{
      {"run", "run IN/box.toml --methods limits --steps 2 --out OUT --json OUT/r.json"},
      {"compare",
       "compare IN/box.toml --methods limits,relaxed --reference relaxed --out OUT --csv OUT/c.csv "
       "--json OUT/c.json"},
      {"picture", "compare IN/box.toml --methods limits --reference limits --picture OUT/c.png"},
      {"study", "study IN/study.toml --threads 1 --resume --out OUT --json OUT/s.json"},
      {"merge", "study merge IN/parts --out OUT"},
      {"trade",
       "study trade IN/box.toml --methods limits,relaxed --spacings 1 --tolerances 0.1 --reference relaxed "
       "--repetitions 1 --out OUT --json OUT/t.json --csv OUT/t.csv"},
      {"choose", "study choose IN/box.toml --error 90% --time 60s --json OUT/c.json"},
      {"report", "report IN/results --out OUT/page.html"},
      // 1: the trials are used up
      {"fit",
       "fit IN/box.toml --test IN/bent.toml --reference relaxed --trials 30 --out OUT/m.toml --json "
       "OUT/f.json",
       1},
      {"tissues", "check library --json OUT/m.json"},
      {"export", "run IN/box.toml --write OUT/box.inp"}};
  return list;
}

using Files = std::map<std::string, std::string>; ///< content by name

/// Those that a user sees, and with `hidden` the others.
inline Files files_in(const std::filesystem::path& folder, bool hidden = false) {
  Files files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename().string().starts_with('.') == hidden)
      files.emplace(entry.path().filename().string(), test::text_of(entry.path()));
  return files;
}

/// Whether a file is all there. @param example of the same name, which is
inline bool is_whole(const std::string& name, const std::string& text, const std::string& example) {
  const std::string ending = std::filesystem::path(name).extension().string();
  if (text.empty()) // a table that has no rows yet
    return example.empty();
  if (ending == ".svg")
    return text.ends_with("</svg>\n<!-- maille -->\n");
  if (ending == ".json")
    return nlohmann::json::accept(text);
  if (ending == ".jsonl") {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      if (!nlohmann::json::accept(line))
        return false;
    return text.ends_with('\n');
  }
  for (const auto& [of, end] : {std::pair{".vti", "</VTKFile>\n"}, std::pair{".vtu", "</VTKFile>\n"},
                                std::pair{".pvd", "</VTKFile>\n"}, std::pair{".vtm", "</VTKFile>\n"},
                                std::pair{".html", "</html>\n"}, std::pair{".png", "IEND\xae\x42\x60\x82"}})
    if (ending == of)
      return text.ends_with(end);
  const auto lines = std::count(text.begin(), text.end(), '\n'),
             wanted = std::count(example.begin(), example.end(), '\n');
  // The force curve of an interrupted run has the steps that were solved.
  const bool may_be_shorter = name.ends_with("_force.csv") && lines > 1;
  return text.ends_with('\n') && (lines == wanted || (may_be_shorter && lines < wanted)) &&
         text.substr(0, text.find('\n')) == example.substr(0, example.find('\n'));
}

/// Scenes, a study, its table and results to make a page of, and a folder for output.
class CommandFolder : public TemporaryFolder {
public:
  CommandFolder() {
    std::filesystem::create_directories(out());
    write("in/box.toml", box("[\"0.6 mm\", 0, 0]"));
    write("in/bent.toml", box("[0, 0, \"0.5 mm\"]"));
    write("in/study.toml", "scene = \"box.toml\"\nmethods = [\"limits\", \"relaxed\"]\nreference = \"none\"\n"
                           "[[parameter]]\nkey = \"move.0.by.0\"\nvalues = [\"0.1 mm\", \"0.2 mm\"]\n");
  }
  std::filesystem::path in() const { return path() / "in"; }
  std::filesystem::path out() const { return path() / "out"; }

  static std::string box(const std::string& by, const std::string& cells = "[6, 3, 3]") {
    return pulled_box_text(cells, by);
  }

  /// What only some commands read.
  void prepare(const WritingCommand& command) const {
    if (command.name == "report")
      run("compare IN/box.toml --methods limits --reference limits --out IN/results");
    if (command.name == "merge")
      run("study IN/study.toml --threads 1 --out IN/parts");
  }

  /// @param before what stands before the program: variables, `env` words
  Outcome run(const std::string& arguments, const std::string& before = "") const {
    return shell("timeout 120 env " + before + " " + MAILLE_COMMAND + " " +
                 with_paths(arguments, {{"OUT", out().string()}, {"IN/", in().string() + "/"}}));
  }

  /// With calls on files going wrong: `write:3:ENOSPC`, see tests/support/faulty_files.cpp.
  Outcome run_with_fault(const std::string& arguments, const std::string& fault,
                         const std::filesystem::path& under) const {
    return run(arguments,
               fmt::format("ASAN_OPTIONS=verify_asan_link_order=0 MAILLE_FAULT={} MAILLE_FAULT_UNDER={} "
                           "MAILLE_FAULT_COUNT={} LD_PRELOAD={}",
                           fault, under.string(), (path() / "count").string(), MAILLE_FAULTY_FILES));
  }
  /// How many calls of a kind there were in the last run with a fault.
  long n_calls(const std::string& call) const {
    std::istringstream lines(test::text_of(path() / "count"));
    std::string name;
    for (long n = 0; lines >> name >> n;)
      if (name == call)
        return n;
    return 0;
  }
};

/// The first call, one in the middle and the last: of 1 ... n.
inline std::set<long> some_of(long n) {
  std::set<long> places;
  for (const long at : {1L, n / 2, n})
    if (at >= 1)
      places.insert(at);
  return places;
}

} // namespace maille::test
