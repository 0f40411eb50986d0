#include "choose/choose.hpp"
#include "maille/base/arena.hpp"
#include "maille/studies/version.hpp"
#include "results/result_table.hpp"
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
        "{} (`maille study trade`), or a lower --level\n",
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

double spacing_factor(int halvings) {
  return std::exp2(-halvings);
}

const ResultTable<Expected>& columns_of_expected() {
  static const ResultTable<Expected> table([](ResultTable<Expected>& columns) {
    columns.add({"", "expected", "", "as likely more as less"}, &Expected::median);
    columns.add({"", "low", "", "as often less as the level leaves"}, &Expected::low);
    columns.add({"", "high", "", "as often more as the level leaves"}, &Expected::high);
  });
  return table;
}

/// A way to answer a scene, with the scene's dimension.
struct CandidateOf {
  int dimension = 3;
  Candidate candidate;

  template<class List>
  Value along_axes(const List& list) const {
    return std::vector(list.begin(), list.begin() + dimension);
  }
};

const ResultTable<CandidateOf>& columns_of_candidates() {
  static const ResultTable<CandidateOf> table([](ResultTable<CandidateOf>& columns) {
    constexpr auto of = &CandidateOf::candidate;
    columns.add({"", "method", "", "that answers"}, of, &Candidate::way, &Way::method);
    columns.add({"", "spacing_factor", "", "of the lattice over the scene's"}, of, &Candidate::way,
                &Way::halvings, spacing_factor);
    columns.add({"", "tolerance", "", "of methods that have one"}, of, &Candidate::way, &Way::tolerance);
    columns.add({"", "cells", "", "along every axis"},
                [](const CandidateOf& row) { return row.along_axes(row.candidate.cells); });
    columns.add({"", "spacing", "m", "along every axis"},
                [](const CandidateOf& row) { return row.along_axes(row.candidate.spacing); });
    columns.add({"", "nodes", "", "of matter"}, of, &Candidate::nodes);
    columns.add_row({"", "error", "", "relative L2"}, columns_of_expected(), of, &Candidate::error);
    columns.add_row({"", "seconds", "s", "set-up and solve"}, columns_of_expected(), of, &Candidate::seconds);
    columns.add({"", "bytes", "B", "that it needs at most"}, of, &Candidate::bytes);
  });
  return table;
}

const ResultTable<Probes::OfMethod>& columns_of_probed() {
  static const ResultTable<Probes::OfMethod> table([](ResultTable<Probes::OfMethod>& columns) {
    using Probed = Probes::OfMethod;
    const auto answers = [](const Probed& of) { return of.why_not.empty(); };
    columns.add({"", "model_error", "", "relative L2 distance from coupled"}, &Probed::model_error)
        .json_where(answers);
    columns.add({"", "seconds", "s", "of an answer"}, &Probed::seconds).json_where(answers);
    columns.add({"", "message", "", "why the method has no answer"}, &Probed::why_not)
        .json_where([=](const Probed& of) { return !answers(of); });
  });
  return table;
}

Value methods_of(const Probes& probes) {
  Value methods = Value::object();
  for (const auto& [method, probed] : probes.of)
    methods[method] = columns_of_probed().json(probed);
  return methods;
}

const ResultTable<Probes>& columns_of_probes() {
  static const ResultTable<Probes> table([](ResultTable<Probes>& columns) {
    columns.add({"", "seconds", "s", "of all probes"}, &Probes::seconds);
    columns.add({"", "spacing_factor", "", "of the finer lattice over the scene's"}, &Probes::halvings,
                spacing_factor);
    columns.add({"", "nodes", "", "of the finer lattice"}, &Probes::nodes);
    columns.add({"", "difference", "", "relative L2, between the two lattices"}, &Probes::difference);
    columns.add({"", "unlike_the_table", "", "in what the scene is"}, &Probes::unlike)
        .json_where([](const Probes& of) { return !of.unlike.empty(); });
    columns.add({"", "growth", "", "of that difference with the spacing"}, &Probes::growth).omitted();
    columns.add({"", "methods", "", "model_error and seconds, or message, of each"}, methods_of)
        .json_where([](const Probes& of) { return !of.of.empty(); });
  });
  return table;
}

struct ChoiceOf {
  const Scene* scene;
  const Choice* choice;

  std::optional<CandidateOf> row(const std::optional<Candidate>& candidate) const {
    return candidate ? std::optional(CandidateOf{scene->dimension(), *candidate}) : std::nullopt;
  }
  std::vector<CandidateOf> rows() const {
    std::vector<CandidateOf> all;
    for (const Candidate& candidate : choice->candidates)
      all.push_back({scene->dimension(), candidate});
    return all;
  }
};

const ResultTable<ChoiceOf>& columns_of_choice() {
  static const ResultTable<ChoiceOf> table([](ResultTable<ChoiceOf>& columns) {
    constexpr auto choice = &ChoiceOf::choice;
    columns.add({"", "scene", "", "its name"}, &ChoiceOf::scene, &Scene::name);
    columns.add({"", "maille", "", "version"}, [](const ChoiceOf&) { return version; });
    columns.add({"", "wish.error", "", "relative L2, at most"}, choice, &Choice::wish, &Wish::error);
    columns.add({"", "wish.seconds", "s", "at most"}, choice, &Choice::wish, &Wish::seconds);
    columns.add({"", "wish.bytes", "B", "at most"}, choice, &Choice::wish, &Wish::bytes).omitted(false);
    columns.add({"", "wish.level", "", "how often both are kept"}, choice, &Choice::wish, &Wish::level);
    columns.add({"", "wish.of", "", "what the error is of"}, choice, &Choice::wish, &Wish::of,
                &Quantity::name);
    columns.add({"", "scenes_in_table", "", "different ones"}, choice, &Choice::scenes);
    columns.add({"", "rests_on", "", "three lattices, or the table"}, choice, &Choice::probes,
                [](const Probes& probes) { return probes.growth ? "three lattices" : "table"; });
    columns.add_row({"", "probes", "", "on coarser lattices"}, columns_of_probes(), choice, &Choice::probes);
    columns.add({"", "message", "", "why nothing can be promised"}, choice, &Choice::probes, &Probes::why_not)
        .json_where([](const ChoiceOf& of) { return !of.choice->probes.why_not.empty(); });
    const auto add = [&](const char* key, const char* meaning, std::optional<Candidate> Choice::*candidate) {
      columns.add_row({"", key, "", meaning}, columns_of_candidates(),
                      [candidate](const ChoiceOf& of) { return of.row(of.choice->*candidate); });
    };
    add("chosen", "the cheapest that meets the wish", &Choice::chosen);
    add("most_exact_in_time", "where none does", &Choice::most_exact_in_time);
    add("quickest_to_error", "where none does", &Choice::quickest_to_error);
    columns.add_rows({"", "candidates", "", "by expected time"}, columns_of_candidates(), &ChoiceOf::rows);
    columns.add({"", "left_out", "", "ways about which nothing is said, and why"}, choice, &Choice::left_out);
  });
  return table;
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
  return columns_of_choice().json({&scene, &choice});
}

} // namespace maille::studies
