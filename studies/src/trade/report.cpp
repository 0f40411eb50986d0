#include "json_parts.hpp"
#include "text.hpp"
#include "trade/measure.hpp"

namespace maille::studies {

std::string head_in_words(const Scene& scene, const Trade& trade) {
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
  return text;
}

std::string notes_in_words(const Trade& trade) {
  if (trade.is_whole)
    return "";
  return is_converged(trade.reference_status) ? "interrupted: rows are missing\n"
                                              : "no errors: the reference has no answer\n";
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
  return columns_of_trade().csv(records_of(scene, trade));
}

} // namespace maille::studies
