#include "export/answer_fields.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "page_parts.hpp"
#include "picture/comparison_picture.hpp"
#include "picture/question_picture.hpp"
#include "text.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

/// The rows of all methods: of a run in steps each method's last.
std::vector<PageData> rows_of(const PageData& results) {
  std::vector<PageData> rows;
  for (const PageData& comparison : at(results, "results"))
    for (const PageData& row : at(comparison, "results")) {
      const auto same =
          std::ranges::find_if(rows, [&](const PageData& r) { return r.at("method") == row.at("method"); });
      if (same == rows.end())
        rows.push_back(row);
      else
        *same = row;
    }
  return rows;
}

PageData first_comparison(const PageData& results) {
  const PageData list = at(results, "results");
  return list.is_array() && !list.empty() ? list.front() : PageData();
}

bool any_has(const std::vector<PageData>& rows, const std::string& key) {
  return std::ranges::any_of(rows, [&](const PageData& row) { return row.contains(key); });
}

constexpr std::array<std::pair<const char*, const char*>, 5> mechanics_errors{
    {{"force", "force error"},
     {"strain_energy", "energy error"},
     {"strain", "strain error"},
     {"stress", "stress error"},
     {"recovered_stress", "recovered stress error"}}};

bool any_has_error(const std::vector<PageData>& rows, const std::string& key) {
  return std::ranges::any_of(rows, [&](const PageData& row) { return at(row, "error", key).is_number(); });
}

PageData table_of(const std::vector<PageData>& rows, const std::string& reference, const std::string& id) {
  const bool has_error = any_has(rows, "error"), has_estimate = any_has(rows, "estimated_error");
  PageData table{{"id", id},
                 {"caption", "All methods; a click on a header sorts"},
                 {"columns", PageData::array()},
                 {"rows", PageData::array()}};
  PageData& columns = table["columns"];
  columns = {column("method", false),
             column("status", false),
             column("set-up", true),
             column("solve", true),
             column("total", true),
             column("iterations", true),
             column("memory", true),
             column("violation", true, "by how much a link is outside its limits, in spacings")};
  if (has_error) {
    columns.push_back(column("L2 error", true, "relative, against " + reference));
    columns.push_back(column("max error", true, "relative, against " + reference));
    for (const auto& [key, name] : mechanics_errors)
      if (any_has_error(rows, key))
        columns.push_back(column(name, true, "relative, against " + reference));
  }
  if (has_estimate)
    columns.push_back(
        column("estimated L2", true, "relative L2 error against elasticity, without finite elements"));
  for (const PageData& row : rows) {
    PageData cells{text_cell(row.at("method")), text_cell(row.at("status"))};
    for (const char* part : {"setup", "solve", "total"})
      cells.push_back(number_cell(seconds(at(row, "seconds", part)), at(row, "seconds", part)));
    cells.push_back(number_cell(plain(at(row, "iterations")), at(row, "iterations")));
    cells.push_back(number_cell(bytes(at(row, "bytes")), at(row, "bytes")));
    const PageData violation = at(row, "limit_violation");
    cells.push_back(
        number_cell(violation.is_number() ? fmt::format("{:.2g}", violation.get<double>()) : "–", violation));
    if (has_error)
      for (const char* norm : {"relative_l2", "relative_max"})
        cells.push_back(number_cell(percent(at(row, "error", norm)), at(row, "error", norm)));
    for (const auto& [key, name] : mechanics_errors)
      if (has_error && any_has_error(rows, key))
        cells.push_back(number_cell(percent(at(row, "error", key)), at(row, "error", key)));
    if (has_estimate)
      cells.push_back(number_cell(percent(at(row, "estimated_error", "relative_l2")),
                                  at(row, "estimated_error", "relative_l2")));
    table["rows"].push_back({{"is_reference", row.at("method") == reference}, {"cells", std::move(cells)}});
  }
  return table;
}

void add_figure(PageData& figures, const char* name, std::string value) {
  if (value != "–")
    figures.push_back({{"name", name}, {"value", std::move(value)}});
}

PageData method_of(const PageData& row) {
  PageData method{{"method", row.at("method")},
                  {"status", row.at("status")},
                  {"algorithm", at(row, "algorithm")},
                  {"figures", PageData::array()}};
  if (row.contains("message"))
    method["message"] = row.at("message");
  PageData& figures = method["figures"];
  add_figure(figures, "set-up", seconds(at(row, "seconds", "setup")));
  add_figure(figures, "solve", seconds(at(row, "seconds", "solve")));
  add_figure(figures, "memory", bytes(at(row, "bytes")));
  add_figure(figures, "iterations", plain(at(row, "iterations")));
  add_figure(figures, "error of the algebra", percent(at(row, "residual")));
  add_figure(figures, "strain energy",
             row.contains("strain_energy") ? plain(row.at("strain_energy")) + " J" : "–");
  add_figure(figures, "L2 error", percent(at(row, "error", "relative_l2")));
  add_figure(figures, "largest error", percent(at(row, "error", "relative_max")));
  add_figure(figures, "estimated L2 error", percent(at(row, "estimated_error", "relative_l2")));
  if (row.contains("estimated_error_message"))
    add_figure(figures, "no estimate", row.at("estimated_error_message"));
  add_figure(figures, "the estimate took", seconds(at(row, "estimated_error", "seconds")));
  return method;
}

/// Error over time and over memory; estimated errors where there are no true ones.
void add_plots(const std::vector<PageData>& rows, const std::string& reference, PageData& run,
               PageDraft& draft) {
  const bool is_estimated = !any_has(rows, "error");
  const std::string key = is_estimated ? "estimated_error" : "error";
  const std::string label = is_estimated ? "estimated relative L2 error [%]" : "relative L2 error [%]";
  SeriesByMethod over_time, over_memory;
  for (const PageData& row : rows) {
    const PageData error = at(row, key, "relative_l2"), time = at(row, "seconds", "total"),
                   memory = at(row, "bytes");
    if (!error.is_number() || error.get<double>() <= 0)
      continue;
    if (time.is_number() && time.get<double>() > 0)
      over_time.add(row.at("method"), 1e3 * time.get<double>(), 100 * error.get<double>());
    if (memory.is_number() && memory.get<double>() > 0)
      over_memory.add(row.at("method"), memory.get<double>() / 1048576, 100 * error.get<double>());
  }
  if (over_time.series.size() < 2)
    return;
  const std::string against = is_estimated ? "" : " against " + reference;
  run["plots"] = PageData::array();
  if (auto figure =
          plot({"time, set-up and solve [ms]", label, true, true, false, over_time.series},
               "Plot of the error of every method" + against + " over its time; the table has the figures",
               "What accuracy costs in time" + (against.empty() ? "" : ", errors" + against), draft))
    run["plots"].push_back(*figure);
  if (auto figure =
          plot({"memory [MiB]", label, true, true, false, over_memory.series},
               "Plot of the error of every method" + against + " over its memory; the table has the figures",
               "What accuracy costs in memory" + (against.empty() ? "" : ", errors" + against), draft))
    run["plots"].push_back(*figure);
}

/// Draws, in a folder that goes again, the bodies that the files for ParaView hold.
class Pictures {
public:
  Pictures(const PageData& results, const fs::path& folder, PageDraft& draft);

  /// The question in words, and the body with what is done to it.
  void add_question(PageData& run);
  /// Strain inside.
  void add_slice(const std::vector<PageData>& rows, PageData& run);
  /// All answers beside each other.
  void add_overview(const std::vector<PageData>& rows, const std::string& reference, PageData& run);
  /// Where the error of one method sits.
  void add_map(const PageData& row, const std::string& reference, PageData& method);

private:
  const AnswerFields* fields_of(const std::string& method) const {
    const auto found = std::ranges::find(fields_, method, &std::pair<std::string, AnswerFields>::first);
    return found == fields_.end() ? nullptr : &found->second;
  }
  std::optional<std::string> draw(const std::vector<PicturePanel>& panels, const PictureSettings& settings);
  /// The picture that was asked for, or nothing and a note why.
  std::optional<std::string> drawn(const std::optional<std::string>& why_not) {
    if (why_not)
      note("no pictures: " + *why_not);
    return why_not ? std::nullopt : std::optional(bytes_of_file(png_));
  }
  /// Nothing where the scene has no look of grey values, or is no longer where it was asked.
  DrawBody draw_body() {
    try {
      return fs::exists(scene_file_) ? draw_grey_values(*scene_, scene_file_, 1) : DrawBody();
    } catch (const std::exception& error) {
      note(std::string("no picture of grey values: ") + error.what());
      return {};
    }
  }
  void note(const std::string& text) {
    if (std::ranges::find(draft_.notes, text) == draft_.notes.end())
      draft_.notes.push_back(text);
  }

  PageDraft& draft_;
  std::optional<Scene> scene_;
  fs::path scene_file_;
  std::vector<std::pair<std::string, AnswerFields>> fields_;
  WorkFolder work_{"maille_report"};
  fs::path png_ = work_ / "picture.png";
  bool is_anatomical_ = false;
};

Pictures::Pictures(const PageData& results, const fs::path& folder, PageDraft& draft) : draft_(draft) {
  try {
    const std::string text = results.at("scene_text").get<std::string>();
    is_anatomical_ = is_scene_of_a_patient(text);
    scene_file_ = results.at("scene_file").get<std::string>();
    scene_ = parse_scene(text, scene_file_.string());
    for (const PageData& entry : at(results, "files"))
      fields_.emplace_back(
          entry.at("method"),
          read_answer_fields(*scene_, folder / fs::path(entry.at("file").get<std::string>()).filename()));
  } catch (const std::exception& error) {
    note(fmt::format("no pictures of {}: {}", plain(at(results, "scene")), error.what()));
    fields_.clear();
  }
}

std::optional<std::string> Pictures::draw(const std::vector<PicturePanel>& panels,
                                          const PictureSettings& settings) {
  PictureSettings placed = settings;
  placed.is_anatomical = is_anatomical_;
  return drawn(render_comparison(*scene_, panels, png_, placed));
}

void Pictures::add_question(PageData& run) {
  if (!scene_)
    return;
  run["question"] = question_of(*scene_);
  QuestionPictureSettings settings;
  settings.is_anatomical = is_anatomical_;
  settings.largest_height = 760;
  if (const auto png = drawn(render_question(*scene_, png_, settings)))
    run["body"].push_back(picture(
        *png, "The body at rest, coloured by label or material, with its fibres and what is done to it",
        "The body at rest: its parts, fibres, and what holds, moves and loads it"));
}

void Pictures::add_slice(const std::vector<PageData>& rows, PageData& run) {
  if (!scene_ || scene_->dimension() < 2)
    return;
  std::vector<SlicePanel> panels;
  for (const PageData& row : rows)
    if (const AnswerFields* fields = fields_of(row.at("method"))) {
      SlicePanel& panel = panels.emplace_back(SlicePanel{row.at("method"), &fields->displacement, {}});
      for (const auto& strain : cell_fields(*scene_, fields->displacement).strain)
        panel.values.push_back(principal_values(strain)[0]);
    }
  if (panels.empty())
    return;
  QuestionPictureSettings settings;
  settings.is_anatomical = is_anatomical_;
  settings.largest_height = 700;
  if (const auto png =
          drawn(render_slice(*scene_, panels, "largest principal strain in %", 0.01, png_, settings)))
    run["body"].push_back(
        picture(*png, "A layer of cells through the deformed body, coloured by the largest principal strain",
                scene_->dimension() == 3 ? "Strain in a layer through the middle of the body"
                                         : "Strain in the body"));
}

void Pictures::add_overview(const std::vector<PageData>& rows, const std::string& reference, PageData& run) {
  std::vector<PicturePanel> panels;
  std::string names;
  for (const PageData& row : rows) {
    const std::string method = row.at("method");
    const AnswerFields* fields = fields_of(method);
    if (fields == nullptr)
      continue;
    panels.push_back(
        {method, &fields->displacement, number_in(at(row, "error", "relative_l2")), method == reference});
    names += (names.empty() ? "" : ", ") + method;
  }
  if (panels.empty())
    return;
  if (const auto png = draw(panels, {}))
    run["pictures"] = {picture(
        *png, "The deformed body as answered by " + names + ", coloured by the length of the displacement",
        "The answers beside each other, in one view and one scale of colours")};
  PictureSettings by_grey_values;
  by_grey_values.draw_body = draw_body();
  if (!by_grey_values.draw_body)
    return;
  if (const auto png = draw(panels, by_grey_values))
    run["pictures"].push_back(picture(*png,
                                      "The deformed body as answered by " + names + ", by its grey values",
                                      "The same answers with the grey values of the image inside"));
}

void Pictures::add_map(const PageData& row, const std::string& reference, PageData& method) {
  const std::string name = row.at("method");
  const AnswerFields* fields = fields_of(name);
  if (fields == nullptr || (!fields->error && !fields->estimate))
    return;
  std::vector<PicturePanel> panels;
  if (fields->error)
    panels.push_back({"against " + reference, &fields->displacement,
                      number_in(at(row, "error", "relative_l2")), false, &*fields->error});
  if (fields->estimate)
    panels.push_back({"estimated", &fields->displacement,
                      number_in(at(row, "estimated_error", "relative_l2")), false, &*fields->estimate});
  PictureSettings settings;
  settings.quantity = "error";
  settings.width = 1100;
  settings.largest_height = 520;
  if (const auto png = draw(panels, settings))
    method["maps"] = {
        picture(*png, "The deformed body as answered by " + name + ", coloured by the length of the error",
                fields->error && fields->estimate
                    ? "Where the error sits: the true one, and the estimate without finite elements"
                : fields->error ? "Where the error sits"
                                : "Where the error sits, as estimated without finite elements")};
}

void add_words(const PageData& results, const std::vector<PageData>& rows, const std::string& reference,
               PageData& run) {
  const PageData comparison = first_comparison(results);
  run["summary"] = fmt::format("{}D, {} cells, {} nodes, {} thread{}{}.", plain(at(comparison, "dimension")),
                               plain(at(comparison, "cells")), plain(at(comparison, "nodes")),
                               plain(at(comparison, "threads")), at(comparison, "threads") == 1 ? "" : "s",
                               reference.empty() ? "" : ", errors against " + reference);
  run["notes"] = PageData::array();
  if (const PageData error = at(comparison, "reference_error"); error.is_object())
    run["notes"].push_back(
        fmt::format("The reference is itself some {} (L2) off at most: its difference from {}.",
                    percent(at(error, "relative_l2")), plain(at(error, "against"))));
  if (any_has(rows, "estimated_error"))
    run["notes"].push_back("Estimated errors are those against linear elasticity of the same cells, found "
                           "without finite elements by "
                           "a few multigrid cycles.");
  // Beside the tables of forces.
  for (const PageData& row : rows)
    for (const PageData& caveat : at(row, "mechanics", "caveats"))
      if (const PageData note = fmt::format("Forces by {}: {}.", plain(at(row, "method")), plain(caveat));
          std::ranges::find(run["notes"], note) == run["notes"].end())
        run["notes"].push_back(note);
  for (const PageData& piece : at(comparison, "left_out"))
    run["notes"].push_back("Left out: " + plain(at(piece, "name")));
}

} // namespace

void add_answers_section(const PageData& results, const fs::path& folder, PageDraft& draft) {
  const std::vector<PageData> rows = rows_of(results);
  const std::string reference = at(first_comparison(results), "reference").is_string()
                                    ? plain(at(first_comparison(results), "reference"))
                                    : "";
  const std::string kind = plain(at(results, "kind")), title = plain(at(results, "title")),
                    scene = plain(at(results, "scene"));
  PageData run{{"id", id_of(scene + "-" + kind)},
               {"heading",
                fmt::format("{}: {}", kind == "run" ? "Run" : "Comparison", title.empty() ? scene : title)}};
  add_words(results, rows, reference, run);
  Pictures pictures(results, folder, draft);
  run["body"] = PageData::array();
  pictures.add_question(run);
  pictures.add_slice(rows, run);
  const PageData dimension = at(first_comparison(results), "dimension");
  run["tables"] = mechanics_tables(rows, reference, dimension.is_number() ? dimension.get<int>() : 3,
                                   id_of(scene + "-" + kind));
  if (const auto measures = measures_table(rows, reference, id_of(scene + "-" + kind) + "-measures"))
    run["tables"].insert(run["tables"].begin(), *measures);
  run["tables?"] = !run["tables"].empty();
  for (const PageData& row : rows)
    if (const PageData words = at(row, "mechanics", "conventions"); words.is_string())
      run["conventions"] = words;
  run["table"] = table_of(rows, reference, id_of(scene + "-" + kind + "-table"));
  add_plots(rows, reference, run, draft);
  pictures.add_overview(rows, reference, run);
  run["pictures?"] = run.contains("pictures");
  run["methods"] = PageData::array();
  for (const PageData& row : rows) {
    run["methods"].push_back(method_of(row));
    pictures.add_map(row, reference, run["methods"].back());
  }
  run["methods?"] = !rows.empty();
  run["scene"] = {{"file", fs::path(plain(at(results, "scene_file"))).filename().string()},
                  {"text", plain(at(results, "scene_text"))},
                  {"explain", plain(at(results, "explanation"))}};
  run["command"] = plain(at(results, "command"));
  draft.runs.push_back(std::move(run));
}

} // namespace maille::studies
