#include "maille/scene/memory.hpp"
#include "maille/studies/choose.hpp"
#include "maille/studies/version.hpp"
#include "text.hpp"

namespace maille::studies {

namespace {

std::string range(const Expected& value, std::string (*in_words)(double)) {
  return fmt::format("{} ({} to {})", in_words(value.median), in_words(value.low), in_words(value.high));
}

std::string cells_in_words(const Scene& scene, const Candidate& candidate) {
  std::string cells, spacing;
  for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimension()); ++a) {
    cells += fmt::format("{}{}", a > 0 ? " x " : "", candidate.cells[a]);
    spacing += fmt::format("{}{:.4g}", a > 0 ? " x " : "", 1e3 * candidate.spacing[a]);
  }
  return fmt::format("{} cells of {} mm", cells, spacing);
}

std::string way_in_words(const Way& way) {
  return fmt::format("{} at {:g} times the scene's spacing{}", way.method, std::exp2(-way.halvings),
                     way.tolerance ? fmt::format(", tolerance {:g}", *way.tolerance) : "");
}

std::string in_words(const Scene& scene, const Candidate& candidate) {
  return fmt::format("{}\n    {}, {} nodes\n    error  {}\n    time   {}\n    memory {} at most\n",
                     way_in_words(candidate.way), cells_in_words(scene, candidate), candidate.nodes,
                     range(candidate.error, in_percent), range(candidate.seconds, in_seconds),
                     bytes_in_words(static_cast<double>(candidate.bytes)));
}

std::string wish_in_words(const Wish& wish) {
  return fmt::format("an error of {}{} in {}{}", in_percent(wish.error),
                     wish.of.is_displacement() ? "" : " of " + wish.of.name, in_seconds(wish.seconds),
                     wish.bytes ? " and " + bytes_in_words(static_cast<double>(*wish.bytes)) : "");
}

std::string nearest_in_words(const Scene& scene, const Choice& choice) {
  std::string text;
  if (choice.most_exact_in_time)
    text += "the most exact in that time: " + in_words(scene, *choice.most_exact_in_time);
  if (choice.quickest_to_error)
    text += "the quickest to that error: " + in_words(scene, *choice.quickest_to_error);
  if (text.empty())
    text = "nothing is in that time alone, nor to that error alone\n";
  if (const std::size_t least = fewest_scenes(choice.wish.level);
      choice.scenes < least && !choice.probes.growth)
    text += fmt::format(
        "the table holds {} different scene{}: a promise that is kept in {} of scenes needs at least "
        "{} (`maille trade`), or a lower --level\n",
        choice.scenes, choice.scenes == 1 ? "" : "s", in_percent(choice.wish.level), least);
  return text;
}

std::string why_to_believe(const Choice& choice) {
  if (!choice.probes.growth)
    return fmt::format("    the upper ends are kept in {} of scenes like those of the table\n",
                       in_percent(choice.wish.level));
  if (!choice.probes.quantity.empty())
    return fmt::format(
        "    the table holds no errors of {}: three lattices speak for it, whose differences grow "
        "by {:.2g} with the spacing; the upper end is twice what they tell\n",
        choice.probes.quantity, *choice.probes.growth);
  return fmt::format("    the scene is unlike those of the table ({}): three lattices speak for its error, "
                     "whose differences "
                     "grow by {:.2g} with the spacing; the upper end is twice what they tell\n",
                     fmt::join(choice.probes.unlike, ", "), *choice.probes.growth);
}

nlohmann::ordered_json expected_json(const Expected& value) {
  return {{"expected", json_number(value.median)},
          {"low", json_number(value.low)},
          {"high", json_number(value.high)}};
}

nlohmann::ordered_json candidate_json(const Scene& scene, const std::optional<Candidate>& candidate) {
  if (!candidate)
    return nullptr;
  const auto d = static_cast<std::ptrdiff_t>(scene.dimension());
  return {{"method", candidate->way.method},
          {"spacing_factor", std::exp2(-candidate->way.halvings)},
          {"tolerance", json_number(candidate->way.tolerance)},
          {"cells", std::vector<int>(candidate->cells.begin(), candidate->cells.begin() + d)},
          {"spacing", std::vector<double>(candidate->spacing.begin(), candidate->spacing.begin() + d)},
          {"nodes", candidate->nodes},
          {"error", expected_json(candidate->error)},
          {"seconds", expected_json(candidate->seconds)},
          {"bytes", candidate->bytes}};
}

nlohmann::ordered_json probes_json(const Probes& probes) {
  nlohmann::ordered_json out{{"seconds", probes.seconds},
                             {"spacing_factor", std::exp2(-probes.halvings)},
                             {"nodes", probes.nodes},
                             {"difference", json_number(probes.difference)}};
  if (!probes.unlike.empty())
    out["unlike_the_table"] = probes.unlike;
  if (probes.growth)
    out["growth"] = json_number(*probes.growth);
  for (const auto& [method, probed] : probes.of) {
    out["methods"][method] = {{"model_error", json_number(probed.model_error)}, {"seconds", probed.seconds}};
    if (!probed.why_not.empty())
      out["methods"][method] = {{"message", probed.why_not}};
  }
  return out;
}

} // namespace

std::string table(const Scene& scene, const Choice& choice) {
  std::string text = fmt::format("{}\nwanted: {}\n", scene.title, wish_in_words(choice.wish));
  if (!choice.probes.why_not.empty())
    return text + "nothing can be promised: " + choice.probes.why_not + "\n";
  text += fmt::format("probes: {}; lattices of {} and {} times the spacing differ by {}{}\n",
                      in_seconds(choice.probes.seconds), std::exp2(-choice.probes.halvings),
                      std::exp2(1 - choice.probes.halvings), in_percent(choice.probes.difference),
                      choice.probes.quantity.empty() ? "" : " of " + choice.probes.quantity);
  if (choice.chosen)
    text += "\nchosen: " + in_words(scene, *choice.chosen) + why_to_believe(choice);
  else
    text += "\nnone is expected to meet that\n" + nearest_in_words(scene, choice);
  if (!choice.left_out.empty())
    text += "\nnot considered:\n";
  for (const std::string& line : choice.left_out)
    text += "    " + line + "\n";
  return text;
}

nlohmann::ordered_json json(const Scene& scene, const Choice& choice) {
  nlohmann::ordered_json out{{"scene", scene.name},
                             {"maille", version},
                             {"wish",
                              {{"error", choice.wish.error},
                               {"seconds", choice.wish.seconds},
                               {"bytes", nullptr},
                               {"level", choice.wish.level},
                               {"of", choice.wish.of.name}}},
                             {"scenes_in_table", choice.scenes},
                             {"rests_on", choice.probes.growth ? "three lattices" : "table"},
                             {"probes", probes_json(choice.probes)}};
  if (choice.wish.bytes)
    out["wish"]["bytes"] = *choice.wish.bytes;
  if (!choice.probes.why_not.empty())
    out["message"] = choice.probes.why_not;
  out["chosen"] = candidate_json(scene, choice.chosen);
  out["most_exact_in_time"] = candidate_json(scene, choice.most_exact_in_time);
  out["quickest_to_error"] = candidate_json(scene, choice.quickest_to_error);
  out["candidates"] = nlohmann::ordered_json::array();
  for (const Candidate& candidate : choice.candidates)
    out["candidates"].push_back(candidate_json(scene, candidate));
  out["left_out"] = choice.left_out;
  return out;
}

} // namespace maille::studies
