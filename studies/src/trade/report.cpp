#include "json_parts.hpp"
#include "text.hpp"
#include "trade/measure.hpp"
#include "trade/trade.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace maille::studies {

std::string table(const Scene& scene, const Trade& trade, bool all) {
  const Specimen& body = scene.specimen;
  std::string text =
      fmt::format("{}\n{}D, {} cells, {} nodes, {} thread{}, errors against {}: {}\n", scene.title,
                  scene.dimension(), body.n_matter_cells(), body.n_matter_nodes(), trade.threads,
                  trade.threads == 1 ? "" : "s", trade.settings.reference,
                  is_converged(trade.reference_status) ? trade.reference_algorithm : trade.reference_message);
  if (trade.reference_error)
    text += fmt::format("the reference itself: some {} (L2) off at most, {}\n",
                        in_percent(trade.reference_error->relative_l2),
                        in_seconds(trade.reference_seconds.total()));
  const auto is_on_front = [](const TradeRow& row) { return row.on_time_front || row.on_memory_front; };
  const auto n_on_front = std::ranges::count_if(trade.rows, is_on_front);
  std::vector<TradeRecord> records = records_of(scene, trade);
  if (!all && n_on_front > 0)
    std::erase_if(records, [&](const TradeRecord& record) { return !is_on_front(record.row); });
  text += "\n" + columns_of_trade().text(records);
  if (!all && n_on_front > 0)
    text += fmt::format("{} more rows, on no front: --all, or the files of --out\n",
                        static_cast<std::ptrdiff_t>(trade.rows.size()) - n_on_front);
  std::vector<MeasureLine> lines;
  for (const TradeRecord& record : records) {
    const Way& way = record.row.way;
    const std::string tolerance = way.tolerance ? fmt::format(" to {:g}", *way.tolerance) : "";
    std::ranges::move(lines_of(fmt::format("{} {}{}", way.method, spacing_in_words(way.halvings), tolerance),
                               record.row.measures),
                      std::back_inserter(lines));
  }
  if (const std::string measures = measures_in_words(lines); !measures.empty())
    text += "\n" + measures;
  text += "\nspacing: of the lattice over the scene's; front: nothing is both nearer and quicker (t), or "
          "both nearer and smaller "
          "(m)\n";
  for (const TradeRow& row : trade.rows)
    if (!row.message.empty() && !is_converged(row.status))
      text += fmt::format("{} at {} times the spacing{}: {}\n", row.way.method,
                          spacing_in_words(row.way.halvings),
                          row.way.tolerance ? fmt::format(" to {:g}", *row.way.tolerance) : "", row.message);
  if (!trade.is_whole)
    text += is_converged(trade.reference_status) ? "interrupted: rows are missing\n"
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
  out["rows"] = columns_of_trade().json_rows(records_of(scene, trade));
  return out;
}

std::string csv(const Scene& scene, const Trade& trade) {
  const auto& columns = columns_of_trade();
  const std::vector<TradeRecord> records = records_of(scene, trade);
  std::string text = records.empty() ? columns.csv(records) : columns.csv_header(records.front());
  for (const TradeRecord& record : records)
    text += columns.csv_line(record);
  return text;
}

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error))
      order.push_back(i);
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(points[i].cost, points[i].error); });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity(); // error of what costs no more
  for (const std::size_t i : order) {
    const bool is_alike = !front.empty() && points[front.back()].cost == points[i].cost &&
                          points[front.back()].error == points[i].error;
    if (points[i].error < best || is_alike)
      front.push_back(i);
    best = std::min(best, points[i].error);
  }
  return front;
}

} // namespace maille::studies
