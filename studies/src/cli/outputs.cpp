#include "cli/outputs.hpp"

#include "export/whole_file.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/studies/version.hpp"
#include "play/play.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <functional>

#include <unistd.h>

namespace maille::studies {

namespace fs = std::filesystem;

std::string json_text(nlohmann::ordered_json json) {
  // is_own_result() recognises the file by this key.
  if (json.is_object())
    json.emplace("maille", version);
  for (std::size_t row = 0; json.is_array() && row < json.size() && json[row].is_object(); ++row)
    json[row].emplace("maille", version);
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string for_terminal(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool is_control = (byte < ' ' && byte != '\n' && byte != '\t' && byte != '\r') || byte == 0x7f;
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0U;
    if (is_control)
      text[i] = '?';
    else if (byte == 0xc2 && next >= 0x80 && next < 0xa0) // control characters above ASCII
      text.replace(i, 2, "?");
  }
  return text;
}

void deliver(const std::string& text, const std::optional<std::string>& file) {
  if (file && *file != "-") {
    write_whole(*file, text);
    return;
  }
  fmt::print("{}", for_terminal(text));
  if (std::fflush(stdout) != 0)
    throw std::runtime_error("cannot write to standard output");
}

bool tell_of_picture(const std::optional<std::string>& why_not, const fs::path& file, bool says_so) {
  constexpr std::string_view prefix = "no picture: ";
  if (!why_not) {
    if (says_so)
      fmt::print("wrote {}\n", file.string());
    return true;
  }
  fmt::print(stderr, "{}{}\n", why_not->starts_with(prefix) ? "" : prefix, *why_not);
  // Delete an earlier picture, which shows other results; after a signal it stays, like all earlier files.
  std::error_code error;
  if (stop_signal() == 0 && is_own_result(file) && !is_kept_input(file))
    fs::remove(file, error);
  return false;
}

void prepare_folder(const fs::path& folder) {
  if (folder.empty())
    throw UsageError("--out: expected a folder, found \"\"");
  try {
    fs::create_directories(folder);
    remove_unfinished_files(folder);
  } catch (const std::exception& error) {
    throw UsageError(fmt::format("--out {}: expected a folder that can be written: {}", folder.string(),
                                 message_of(error)));
  }
  // The name is unpredictable; the path follows no link.
  std::string probe = (folder / ".maille-write-test-XXXXXX").string();
  const int descriptor = mkstemp(probe.data());
  if (descriptor < 0)
    throw UsageError(fmt::format("--out {}: expected a folder that can be written: {}", folder.string(),
                                 std::error_code(errno, std::generic_category()).message()));
  close(descriptor);
  unlink(probe.c_str());
}

bool& may_overwrite() {
  static bool is_asked = false;
  return is_asked;
}

void prepare_file(const std::string& option, const std::optional<std::string>& file,
                  const std::optional<ResultsFolder>& results, std::string_view ending,
                  std::string_view head) {
  if (!file || *file == "-")
    return;
  const fs::path path(*file);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const char* found = nullptr;
  std::error_code error;
  if (path.empty() || fs::is_directory(path, error))
    found = "a folder";
  else if (!fs::is_directory(folder, error))
    found = "no such folder";
  else if (access(folder.c_str(), W_OK) != 0 || (fs::exists(path, error) && access(path.c_str(), W_OK) != 0))
    found = "no permission to write";
  else if (is_kept_input(path))
    found = "one that this command reads";
  else if (fs::is_regular_file(path, error) && !may_overwrite() &&
           (!is_own_result(path, head) || (path.extension() == ".toml" && ending != ".toml") ||
            !file->ends_with(ending)))
    throw UsageError(fmt::format("{} {}: expected a new file, or a {} that Maille wrote, found another file; "
                                 "--overwrite replaces it",
                                 option, *file, ending.empty() ? "result" : ending));
  if (found)
    throw UsageError(
        fmt::format("{} {}: expected a file that can be written, found {}", option, *file, found));
  if (results)
    refuse_name_of_result(option, file, results->path(),
                          [&](const std::string& name) { return results->is_planned(name); });
  reserve_output(option, path);
}

void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files) {
  for (const MeasureRow& row : rows)
    if (!row.value.line.empty()) {
      files.push_back(folder.file(fmt::format("_{}_{}.csv", method, row.value.name)));
      write_whole(files.back(), line_csv(row.value));
    }
}

std::optional<Displacement> shown_field(const Scene& scene, const Comparison& comparison,
                                        const ComparisonRow& row, const std::string& field) {
  Displacement shown = row.answer.displacement;
  const bool is_stress = field == "stress";
  if (is_stress && !has_stress(row.answer.method))
    return std::nullopt;
  if (is_stress || field == "strain") {
    const CellFields fields = cell_fields(scene, row.answer.displacement);
    const Specimen& body = scene.specimen;
    shown = Displacement(body.grid);
    for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
      double sum = 0;
      int n = 0;
      body.for_each_cell_at(body.grid.node_at(node), [&](std::int64_t cell) {
        const std::size_t c = cell;
        sum += is_stress ? fields.von_mises[c] : largest_principal(fields.strain[c]);
        ++n;
      });
      shown(0, node) = n > 0 ? sum / n : 0;
    }
  } else if (field == "error" && row.error) {
    std::ranges::transform(shown.values(), comparison.reference_row()->answer.displacement.values(),
                           shown.values().begin(), std::minus{});
  } else if (field == "error") {
    return row.estimation && row.estimation->estimate ? std::optional(row.estimation->estimate->error)
                                                      : std::nullopt;
  }
  return shown;
}

PictureSettings settings_of_field(const std::string& title, const std::string& field) {
  if (field == "strain")
    return {.title = title, .quantity = "largest principal strain", .unit = 1e-2, .unit_name = "%"};
  if (field == "stress")
    return {.title = title, .quantity = "von Mises stress", .unit = 1e3, .unit_name = "kPa"};
  return {.title = title, .quantity = field};
}

std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                      const std::vector<Comparison>& steps, const std::string& field,
                                      const std::filesystem::path& mp4) {
  constexpr double film_seconds = 4, longest_frame = 0.25; // few steps; upper bound per step
  constexpr int n_digits = 6;
  if (!has_ffmpeg())
    return "no film: there is no `ffmpeg` to run";
  const auto label = [&](std::size_t step) {
    return fmt::format("{}, {:.0f} %", method,
                       100.0 * static_cast<double>(step) / static_cast<double>(steps.size()));
  };
  const Displacement rest(scene.specimen.grid);
  std::deque<Displacement> shown;
  PictureSettings settings = settings_of_field(scene.title, field);
  std::vector<PicturePanel>& moments = settings.also_in_view;
  moments.push_back({label(0), &rest, {}, false, &rest});
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (const ComparisonRow& row : steps[i].rows)
      if (has_displacement(row.answer.status))
        if (auto of_row = shown_field(scene, steps[i], row, field))
          moments.push_back(
              {label(i + 1), &row.answer.displacement, {}, false, &shown.emplace_back(std::move(*of_row))});
  if (moments.size() < 2)
    return fmt::format("no film: no step has an answer with {}", field);
  settings.width = settings.largest_height = 1000;
  settings.warp = 1;
  settings.is_anatomical = scene.specimen.shape == "image";
  const WorkFolder frames("maille_film");
  const std::filesystem::path stem = frames / "step";
  std::int64_t n = 0;
  for (const PicturePanel& moment : moments) {
    const std::filesystem::path png = fmt::format("{}_{:0{}}.png", stem.string(), n++, n_digits);
    if (const auto why_not = render_comparison(scene, {moment}, png, settings))
      return "no film: " + *why_not;
  }
  const double frame_seconds = std::min(longest_frame, film_seconds / static_cast<double>(n));
  return make_film(stem, n_digits, n, frame_seconds, mp4);
}

} // namespace maille::studies
