#include "cli/commands.hpp"
#include "cli/inputs.hpp"

#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "trade/measure.hpp"
#include "trade/trade.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace maille::studies {

namespace {

/// 4 is two doublings, 0.5 one halving.
int halvings_of(double factor) {
  const double halvings = -std::log2(factor);
  if (!(factor > 0) || std::abs(halvings - std::round(halvings)) > 1e-9 || std::abs(halvings) > 10)
    throw UsageError(fmt::format("--spacings: expected powers of 2, such as 0.5,1,2,4, found {}", factor));
  return static_cast<int>(std::round(halvings));
}

TradeSettings settings_of(const TradeOptions& options) {
  TradeSettings settings;
  if (options.json == "-" && options.csv == "-")
    throw UsageError("--json and --csv: expected at most one of them on stdout, found both");
  settings.methods = check_methods(options.methods);
  settings.reference = options.reference;
  if (options.reference != "best")
    check_methods({options.reference}, "--reference");
  settings.reference_seconds = options.reference_seconds;
  settings.row_seconds = options.row_seconds;
  settings.repetitions = options.repetitions;
  if (!options.tolerances.empty())
    settings.tolerances = options.tolerances;
  for (const double tolerance : settings.tolerances)
    if (!(tolerance > 0 && tolerance < 1))
      throw UsageError(fmt::format("--tolerances: expected numbers between 0 and 1, found {}", tolerance));
  if (!options.spacings.empty())
    settings.halvings.clear();
  for (const double factor : options.spacings)
    settings.halvings.push_back(halvings_of(factor));
  return settings;
}

} // namespace

int trade_command(const TradeOptions& options) {
  keep_inputs({options.scene});
  const TradeSettings settings = settings_of(options);
  Lattices lattices(options.scene);
  std::optional<FolderLock> lock;
  if (options.out) {
    prepare_folder(*options.out);
    lock.emplace(*options.out, lattices.scene().name, FolderLock::Sharing::none,
                 std::vector<std::string>{"_trade.json", "_trade.svg", "_trade.png"});
    const std::string table = csv(lattices.scene(), Trade{}); // its header is that of every trade
    check_replaced(*options.out / (lattices.scene().name + "_trade.csv"), table.substr(0, table.find('\n')));
  }
  for (const auto& [option, file] : {std::pair("--json", options.json), {"--csv", options.csv}}) {
    prepare_file(option, file, {}, "", columns_of_trade().csv_head());
    if (options.out)
      refuse_name_of_result(option, file, *options.out, [&](const std::string& name) {
        return is_name_of_result(name, lattices.scene().name + "_trade");
      });
  }
  const Trade trade = measure_trade(lattices, settings, terminal_control(options.threads));
  end_progress();
  const Scene& scene = lattices.scene();
  const nlohmann::ordered_json request{
      {"kind", "trade"},
      {"document", json(scene, trade)},
      {"csv_text", csv(scene, trade)},
      {"head", head_in_words(scene, trade)},
      {"notes", notes_in_words(trade)},
      {"about", asked_about(options.scene, explanation(scene))},
      {"all", options.all},
      {"json", options.json.value_or("")},
      {"csv", options.csv.value_or("")},
      {"stem", options.out ? (std::filesystem::path(*options.out) / (scene.name + "_trade")).string() : ""},
      {"exit_code", trade.any_failed() ? exit_run_failed : exit_done}};
  lock.reset(); // deletes its file before this process is replaced
  return become_python_program("statistics", request);
}

} // namespace maille::studies
