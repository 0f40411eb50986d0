#include "gnuplot.hpp"

#include "maille/materials/text_file.hpp"
#include "program.hpp"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace maille::studies {

std::string gnuplot_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text)
    if (c == '\'')
      result += "''";
    else if (!std::iscntrl(static_cast<unsigned char>(c))) // SVG has no other
      result += c;
  return result + "'";
}

std::optional<std::string> why_no_gnuplot() {
  if (!has_program("gnuplot"))
    return "there is no `gnuplot` to run: install the package gnuplot-nox";
  return std::nullopt;
}

void run_gnuplot(const std::string& commands) {
  const WorkFolder folder("maille_plot");
  const auto script = folder / "commands.gp", log = folder / "log";
  if (!(std::ofstream(script) << commands << std::flush))
    throw std::runtime_error("cannot write gnuplot's commands to " + script.string());
  if (run_program(
          fmt::format("gnuplot -d {} > {} 2>&1", shell_word(script.string()), shell_word(log.string()))) == 0)
    return;
  std::ifstream words(log);
  throw std::runtime_error("gnuplot failed: " + std::string(std::istreambuf_iterator<char>(words),
                                                            std::istreambuf_iterator<char>()));
}

} // namespace maille::studies
