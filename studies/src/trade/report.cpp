#include "json_parts.hpp"
#include "maille/scene/memory.hpp"
#include "maille/studies/trade.hpp"
#include "text.hpp"

namespace maille::studies {

namespace {

std::string fronts_of(const TradeRow& row) {
  return std::string(row.on_time_front ? "t" : "") + (row.on_memory_front ? "m" : "");
}

std::string spacing_in_words(int halvings) {
  return halvings > 0 ? fmt::format("1/{}", 1 << halvings) : fmt::format("{}", 1 << -halvings);
}

std::string table_row(const TradeRow& row) {
  return fmt::format("{:<8} {:>7} {:>9} {:>7} {:<14} {:>9} {:>9} {:>9} {:>10} {:>6} {:>9} {:>9} {:>6}\n",
                     row.way.method, spacing_in_words(row.way.halvings),
                     row.nodes > 0 ? fmt::format("{}", row.nodes) : "-",
                     row.way.tolerance ? fmt::format("{:g}", *row.way.tolerance) : "-", to_string(row.status),
                     row.repetitions > 0 ? in_seconds(row.seconds.setup) : "-",
                     row.repetitions > 0 ? in_seconds(row.seconds.solve) : "-",
                     row.repetitions > 0 ? in_seconds(row.seconds.total()) : "-",
                     row.bytes > 0 ? bytes_in_words(static_cast<double>(row.bytes)) : "-", row.iterations,
                     row.error ? in_percent(row.error->relative_l2) : "-",
                     row.error ? in_percent(row.error->relative_max) : "-", fronts_of(row));
}

nlohmann::ordered_json row_json(const Scene& scene, const TradeRow& row) {
  nlohmann::ordered_json out{{"method", row.way.method},
                             {"spacing_factor", std::exp2(-row.way.halvings)},
                             {"tolerance", json_number(row.way.tolerance)},
                             {"status", to_string(row.status)}};
  if (!row.message.empty())
    out["message"] = row.message;
  if (row.nodes > 0) {
    const auto d = static_cast<std::size_t>(scene.dimension());
    out["cells"] = std::vector<int>(row.cells.begin(), row.cells.begin() + static_cast<std::ptrdiff_t>(d));
    out["spacing"] =
        std::vector<double>(row.spacing.begin(), row.spacing.begin() + static_cast<std::ptrdiff_t>(d));
    out["nodes"] = row.nodes;
  }
  if (row.repetitions > 0) {
    out["algorithm"] = row.algorithm;
    out["seconds"] = seconds_json(row.seconds);
    out["wall_seconds"] = row.wall_seconds;
    out["repetitions"] = row.repetitions;
    out["bytes"] = row.bytes;
    out["iterations"] = row.iterations;
  }
  if (row.error)
    out["error"] = norms_json(*row.error);
  if (row.predicted.error && row.predicted.seconds)
    out["predicted"] = {{"error", json_number(row.predicted.error)},
                        {"seconds", json_number(row.predicted.seconds)}};
  out["on_front"] = {{"time", row.on_time_front}, {"memory", row.on_memory_front}};
  return out;
}

} // namespace

std::string table(const Scene& scene, const Trade& trade, bool all) {
  const Specimen& body = scene.specimen;
  std::string text =
      fmt::format("{}\n{}D, {} cells, {} nodes, {} thread{}, errors against {}: {}\n", scene.title,
                  scene.dimension(), body.n_matter_cells(), body.n_matter_nodes(), trade.threads,
                  trade.threads == 1 ? "" : "s", trade.settings.reference,
                  is_settled(trade.reference_status) ? trade.reference_algorithm : trade.reference_message);
  if (trade.reference_error)
    text += fmt::format("the reference itself: some {} (L2) off at most, {}\n",
                        in_percent(trade.reference_error->relative_l2),
                        in_seconds(trade.reference_seconds.total()));
  text += fmt::format("\n{:<8} {:>7} {:>9} {:>7} {:<14} {:>9} {:>9} {:>9} {:>10} {:>6} {:>9} {:>9} {:>6}\n",
                      "method", "spacing", "nodes", "tol.", "status", "set-up", "solve", "total", "memory",
                      "iter.", "L2 error", "max error", "front");
  const auto is_on_front = [](const TradeRow& row) { return row.on_time_front || row.on_memory_front; };
  const auto n_on_front = std::ranges::count_if(trade.rows, is_on_front);
  for (const TradeRow& row : trade.rows)
    if (all || n_on_front == 0 || is_on_front(row))
      text += table_row(row);
  if (!all && n_on_front > 0)
    text += fmt::format("{} more rows, on no front: --all, or the files of --out\n",
                        static_cast<std::ptrdiff_t>(trade.rows.size()) - n_on_front);
  text += "\nspacing: of the lattice over the scene's; front: nothing is both nearer and quicker (t), or "
          "both nearer and smaller "
          "(m)\n";
  for (const TradeRow& row : trade.rows)
    if (!row.message.empty() && !is_settled(row.status))
      text += fmt::format("{} at {} times the spacing{}: {}\n", row.way.method,
                          spacing_in_words(row.way.halvings),
                          row.way.tolerance ? fmt::format(" to {:g}", *row.way.tolerance) : "", row.message);
  if (!trade.is_whole)
    text += is_settled(trade.reference_status) ? "interrupted: rows are missing\n"
                                               : "no errors: the reference has no answer\n";
  return text;
}

nlohmann::ordered_json json(const Scene& scene, const Trade& trade) {
  nlohmann::ordered_json out = question_json(scene, trade.threads);
  out["whole"] = trade.is_whole;
  out["reference"] = trade.settings.reference;
  out["reference_status"] = to_string(trade.reference_status);
  out["reference_algorithm"] = trade.reference_algorithm;
  out["reference_seconds"] = trade.reference_seconds.total();
  out["reference_error"] = nullptr;
  if (trade.reference_error)
    out["reference_error"] = norms_json(*trade.reference_error);
  out["rows"] = nlohmann::ordered_json::array();
  for (const TradeRow& row : trade.rows)
    out["rows"].push_back(row_json(scene, row));
  return out;
}

std::string csv(const Scene& scene, const Trade& trade) {
  std::string text =
      "scene,method,halvings,nodes,tolerance,status,setup_s,solve_s,total_s,wall_s,repetitions,bytes,"
      "iterations,relative_l2,relative_max,rms_m,predicted_error,predicted_s,front,reference,"
      "reference_l2,probe_halvings,message\n";
  const auto norm = [](const TradeRow& row, double ErrorNorms::*which) {
    return row.error ? csv_number((*row.error).*which) : std::string();
  };
  for (const TradeRow& row : trade.rows) {
    const bool is_measured = row.repetitions > 0;
    const auto time = [&](double seconds) { return is_measured ? csv_number(seconds, 4) : std::string(); };
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(scene.name),
        row.way.method, row.way.halvings, row.nodes, csv_number(row.way.tolerance), to_string(row.status),
        time(row.seconds.setup), time(row.seconds.solve), time(row.seconds.total()), time(row.wall_seconds),
        row.repetitions, row.bytes, row.iterations, norm(row, &ErrorNorms::relative_l2),
        norm(row, &ErrorNorms::relative_max), norm(row, &ErrorNorms::rms), csv_number(row.predicted.error),
        csv_number(row.predicted.seconds), fronts_of(row), trade.settings.reference,
        trade.reference_error ? csv_number(trade.reference_error->relative_l2, 3) : "",
        row.predicted.error ? std::to_string(row.predicted.probe_halvings) : "", csv_text(row.message));
  }
  return text;
}

} // namespace maille::studies
