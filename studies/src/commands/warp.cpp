#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"
#include "compare/methods.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace maille::studies {

WarpRequest warp_request(const WarpOptions& options) {
  for (const std::string& ending : options.also)
    if (ending != "mha" && ending != "nrrd")
      throw UsageError(fmt::format("--also: expected some of mha, nrrd, found \"{}\"", ending));
  for (const auto& file : {options.image, options.labels})
    if (file)
      keep_input(*file);
  for (const std::string& ending : options.surfaces)
    if (ending != "stl" && ending != "ply" && ending != "vtp")
      throw UsageError(fmt::format("--surface: expected some of stl, ply, vtp, found \"{}\"", ending));
  return {options.image,      options.labels,   options.also,
          options.background, options.surfaces, length_unit(options.unit)};
}

int warp_command(const WarpCommandOptions& options) {
  auto names = check_methods(options.methods);
  if (names.empty())
    names = {default_run_method};
  const WarpRequest request = warp_request(options.warp);
  const Scene scene = read_scene(options.scene);
  if (!options.out)
    throw UsageError("--out: expected a folder for the images, found none");
  if (const std::string why_not = why_no_warp(scene, request); !why_not.empty())
    throw UsageError("expected " + why_not);
  keep_inputs({options.scene});
  prepare_folder(*options.out);
  const FolderLock lock(*options.out, "", FolderLock::Sharing::none);
  prepare_file("--json", options.json);
  const Control control = terminal_control(options.threads);
  Methods methods(check_fem_solver(options.fem_solver));
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  bool has_failed = false;
  for (const std::string& method : names) {
    Answer answer = methods.answer(scene, method, control);
    fail_where_inside_out(scene, answer);
    end_progress();
    nlohmann::ordered_json row{{"method", method}, {"status", to_string(answer.status)}};
    std::string text;
    if (is_converged(answer.status)) {
      const WarpedFiles made =
          write_warp(scene, answer, request, *options.out / (names.size() == 1 ? "" : method + "_"));
      row.update(json(made));
      text = fmt::format("{}\n{}", method, in_words(made));
      for (const auto& file : made.files)
        text += fmt::format("wrote {}\n", file.string());
    } else {
      has_failed = true;
      row["message"] = answer.message;
      text = fmt::format("{}: {}, no images: {}\n", method, to_string(answer.status), answer.message);
    }
    results.push_back(std::move(row));
    if (options.json != "-")
      deliver(text, std::nullopt);
    if (control.should_stop())
      break;
  }
  if (options.json)
    deliver(json_text({{"scene", scene.name}, {"results", std::move(results)}}), options.json);
  return has_failed || control.should_stop() ? exit_run_failed : exit_done;
}

} // namespace maille::studies
