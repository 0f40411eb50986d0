#include "commands.hpp"

#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/studies/comparison.hpp"
#include "maille/studies/export/vtk_files.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/methods.hpp"
#include "maille/studies/picture/comparison_picture.hpp"
#include "maille/studies/reference_warnings.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace maille::studies {

namespace {

/// One grid file a method, the table as JSON and CSV, and a .pvd over the methods.
std::vector<std::filesystem::path> write_files(const Scene& scene, const Comparison& comparison,
                                               const CompareOptions& options) {
  const std::filesystem::path& folder = options.out;
  std::vector<std::filesystem::path> files;
  std::vector<PvdEntry> parts;
  std::vector<AnswerFile> answers;
  const ComparisonRow* reference = comparison.reference_row();
  for (const ComparisonRow& row : comparison.rows) {
    if (!is_under_way(row.answer))
      continue;
    ExportFields fields;
    fields.show(row.answer);
    if (row.estimation && row.estimation->estimate)
      fields.error_estimate = &row.estimation->estimate->error;
    fields.reference = row.error ? &reference->answer.displacement : nullptr;
    fields.provenance = provenance(scene, row.answer, options.threads);
    files.push_back(write_vtk(scene, fields, folder / fmt::format("{}_{}", scene.name, row.answer.method)));
    parts.push_back({static_cast<double>(parts.size()), files.back()});
    answers.push_back({row.answer.method, files.back().filename().string()});
  }
  files.push_back(folder / (scene.name + ".pvd"));
  write_pvd(parts, files.back());
  files.push_back(folder / (scene.name + "_compare.json"));
  write_whole(files.back(), json(scene, comparison).dump(2) + "\n");
  files.push_back(folder / (scene.name + "_compare.csv"));
  write_whole(files.back(), csv(scene, comparison));
  Scene known = scene;
  if (comparison.taut_scale > 0 && scene.limit_source() == LimitSource::taut)
    known.limits.taut_scale = comparison.taut_scale; // not to be searched again
  files.push_back(write_results(known, options, "compare", answers,
                                nlohmann::ordered_json::array({json(scene, comparison)})));
  return files;
}

/// Fast methods first, then the reference; says on stderr why there is no picture where there is none.
bool draw(const Scene& scene, const Comparison& comparison, const std::filesystem::path& file) {
  std::vector<PicturePanel> panels;
  for (const ComparisonRow& row : comparison.rows)
    if (is_under_way(row.answer))
      panels.push_back({row.answer.method, &row.answer.displacement,
                        row.error ? std::optional(row.error->relative_l2) : std::nullopt,
                        row.answer.method == comparison.reference});
  PictureSettings settings;
  settings.title = scene.title;
  const auto why_not = panels.empty() ? std::optional<std::string>("no method has an answer")
                                      : render_comparison(scene, panels, file, settings);
  if (why_not)
    fmt::print(stderr, "no picture: {}\n", *why_not);
  return !why_not;
}

/// What a command line can get wrong by itself.
void check_options(const CompareOptions& options) {
  if (!options.reference.empty() && options.reference != "best")
    check_methods({options.reference});
  if (options.json == "-" && options.csv == "-")
    throw UsageError("--json and --csv: expected at most one of them on stdout, found both");
  if (options.picture && !options.picture->ends_with(".png"))
    throw UsageError(
        fmt::format("--picture: expected a name that ends in .png, found \"{}\"", *options.picture));
}

/// The folder first: files may be asked for in it.
void prepare_outputs(const CompareOptions& options) {
  if (!options.out.empty())
    prepare_folder(options.out);
  prepare_file("--json", options.json);
  prepare_file("--csv", options.csv);
  prepare_file("--picture", options.picture);
}

} // namespace

int compare_command(const CompareOptions& options) {
  auto names = check_methods(options.methods);
  if (names.empty())
    names = {"limits", "sweep", "fem_q1"};
  check_options(options);
  Methods methods(check_fem_solver(options.fem_solver), !options.out.empty());
  const Scene scene = read_scene(options.scene);
  if (fem_ref::ranks().is_first())
    prepare_outputs(options);
  const auto reference = options.reference.empty() ? default_reference(names) : options.reference;
  const Control control = terminal_control(options.threads);
  Comparison comparison =
      compare_methods(scene, names, reference, control, methods, options.reference_seconds);
  end_progress();
  if (!fem_ref::ranks().is_first())
    return exit_done; // the first rank speaks for all
  if (options.estimate)
    add_estimates(scene, comparison, control);
  comparison.warnings = reference_warnings(scene, comparison, control);
  end_progress();

  const bool quiet = options.json == "-" || options.csv == "-";
  if (!quiet)
    deliver(table(scene, comparison), std::nullopt);
  if (options.json)
    deliver(json(scene, comparison).dump(2) + "\n", options.json);
  if (options.csv)
    deliver(csv(scene, comparison), options.csv);
  if (!options.out.empty())
    for (const auto& file : write_files(scene, comparison, options))
      if (!quiet)
        fmt::print("wrote {}\n", file.string());
  if (options.picture && draw(scene, comparison, *options.picture) && !quiet)
    fmt::print("wrote {}\n", *options.picture);
  return comparison.any_failed() ? exit_run_failed : exit_done;
}

} // namespace maille::studies
