#include "compare/plots.hpp"

#include "export/whole_file.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/plugins/open_plugin.hpp"
#include "program.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>

namespace maille::studies {

namespace {

/// A failure to plot, with its reason.
struct NoPlot {
  std::string why;
};

void run_curves(const nlohmann::ordered_json& request) {
  const WorkFolder folder("maille_plot");
  const auto input = folder / "request", log = folder / "log";
  constexpr auto replace = nlohmann::ordered_json::error_handler_t::replace; // titles that are not UTF-8
  if (!(std::ofstream(input) << request.dump(-1, ' ', false, replace) << std::flush))
    throw NoPlot{"cannot write " + input.string()};
  const std::string program = find_plugin("maille-curves", "plots need the program");
  if (run_program(fmt::format("{} < {} > {} 2>&1", shell_word(program), shell_word(input.string()),
                              shell_word(log.string()))) == 0)
    return;
  std::ifstream words(log);
  throw NoPlot{{std::istreambuf_iterator<char>(words), std::istreambuf_iterator<char>()}};
}

} // namespace

std::optional<std::string> draw_curves(nlohmann::ordered_json request, const std::filesystem::path& file) {
  try {
    write_whole(file, [&](const std::filesystem::path& part) {
      request["out"] = part.string();
      run_curves(request);
    });
    return std::nullopt;
  } catch (const NoPlot& no) {
    return std::string(trimmed(no.why, " \n"));
  } catch (const std::filesystem::filesystem_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

} // namespace maille::studies
