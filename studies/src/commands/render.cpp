#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/outputs.hpp"
#include "commands/camera_options.hpp"
#include "compare/plots.hpp"
#include "export/answer_fields.hpp"
#include "maille/deform/solve.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/render/shared.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <type_traits>
#include <utility>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Files of `run` or `compare` in a folder for a method of a scene, sorted by name.
std::vector<fs::path> files_of(const fs::path& folder, const std::string& scene, std::string_view method) {
  std::vector<fs::path> files;
  const std::string start = fmt::format("{}_{}", scene, method);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string(), ending = entry.path().extension().string();
    const bool is_of_method =
        name.starts_with(start) && (name[start.size()] == '_' || name[start.size()] == '.');
    if (is_of_method && (ending == ".vti" || ending == ".vtu" || ending == ".pvtu"))
      files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// Last file of the requested method, or of the first method with files.
fs::path answer_in(const fs::path& folder, const Scene& scene, const std::string& method) {
  for (const Method m : every_method)
    if (method.empty() || method == to_string(m))
      if (const auto files = files_of(folder, scene.name, to_string(m)); !files.empty())
        return files.back();
  throw UsageError(fmt::format("--answer: expected a folder with an answer of {}{}, found none in {}",
                               scene.name, method.empty() ? "" : " by " + method, folder.string()));
}

/// The body's displacement, from a folder or from a method run now; nothing: at rest.
std::optional<Displacement> displacement_of(const RenderOptions& options, const Scene& scene,
                                            const Control& control, std::optional<Displacement>& error) {
  if (options.answer) {
    AnswerFields fields = read_answer_fields(scene, answer_in(*options.answer, scene, options.method));
    error = std::move(fields.error ? fields.error : fields.estimate);
    return std::move(fields.displacement);
  }
  if (options.method.empty())
    return std::nullopt;
  check_methods({options.method}, "--method");
  Answer answer = deform::solve(scene, options.method, control);
  fail_where_inside_out(scene, answer);
  if (!has_displacement(answer.status))
    throw std::runtime_error(
        fmt::format("{}: {} ({})", options.method, to_string(answer.status), answer.message));
  return std::move(answer.displacement);
}

/// @param caption  receives title, label, largest value and colours of a field with a scale
SeenScene seen_by(const RenderOptions& options, const Control& control, nlohmann::ordered_json& caption,
                  std::string& legend) {
  if (is_world_scene(options.scene)) {
    if (options.answer || !options.method.empty() || !options.field.empty())
      throw UsageError(
          "--answer, --method and --field are of a scene with a [specimen]; a world is shown as it "
          "begins: maille play --render volume shows what becomes of it");
    const WorldScene world = read_world_scene(options.scene);
    SeenScene seen = seen_world(world, options.scene);
    follow(deform::World(world), seen);
    return seen;
  }
  const Scene scene = read_scene(options.scene);
  std::optional<Displacement> error;
  const auto displacement = displacement_of(options, scene, control, error);
  SeenScene seen = seen_scene(scene, options.scene, displacement.has_value());
  if (displacement)
    follow(scene, *displacement, seen);
  if (options.field.empty())
    return seen;
  const Displacement* shown = options.field == "error" ? (error ? &*error : nullptr)
                              : displacement           ? &*displacement
                                                       : nullptr;
  double largest = 0;
  seen.objects[0].paint = paint_of_field(scene, shown, options.field, largest);
  if (!seen.objects[0].paint)
    throw UsageError(fmt::format(
        "--field {}: expected an answer that has it (--answer, or --method), found none", options.field));
  if (largest > 0) {
    const PictureSettings of = settings_of_field(scene.title, options.field);
    const std::string unit = of.unit ? of.unit_name : "mm",
                      quantity = options.field == "strain" ? "equivalent strain" : of.quantity;
    const double end = largest / of.unit.value_or(1e-3);
    caption = {{"title", scene.title},
               {"label", fmt::format("{} [{}]", quantity, unit)},
               {"largest", end},
               {"colours", render::field_colours()}};
    legend = fmt::format("{}: colours from 0 to {:.4g} {}", quantity, end, unit);
  }
  return seen;
}

/// Cost of pictures.
struct Work {
  render::Counters counters;
  std::int64_t bytes_sent = 0; ///< from one process to another
};

/// Renders views in turn, by this process or by all ranks.
class Painter {
public:
  explicit Painter(int threads)
      : alone_(threads), together_(fem_ref::ranks().rank, fem_ref::ranks().size, threads) {}

  /// @return the picture on the first rank, an empty one on all others
  const render::Picture& picture(const SeenScene& seen, const render::View& view) {
    const fem_ref::Ranks ranks = fem_ref::ranks();
    if (ranks.size < 2)
      return alone_.render(seen.objects, view);
    auto cast = together_.cast(seen.objects, view);
    for (std::size_t to = 0; to < cast.size(); ++to)
      bytes_sent_ += to == static_cast<std::size_t>(ranks.rank) ? 0 : std::ssize(cast[to]);
    const auto runs = fem_ref::exchange(std::move(cast));
    std::vector<render::SharedRenderer::Bytes> pixels(ranks.size);
    pixels.front() = together_.compose(runs);
    bytes_sent_ += ranks.is_first() ? 0 : std::ssize(pixels.front());
    const auto received = fem_ref::exchange(std::move(pixels));
    picture_ = ranks.is_first() ? together_.assemble(received) : render::Picture{};
    return picture_;
  }
  /// Total cost of all ranks, on the first rank.
  Work work() const {
    const fem_ref::Ranks ranks = fem_ref::ranks();
    if (ranks.size < 2)
      return {alone_.counters(), 0};
    static_assert(std::is_trivially_copyable_v<Work>);
    const Work of_this{together_.counters(), bytes_sent_};
    const auto bytes = std::as_bytes(std::span(&of_this, 1));
    std::vector<render::SharedRenderer::Bytes> own(ranks.size);
    own.front().assign(bytes.begin(), bytes.end());
    Work sum;
    for (const auto& of : fem_ref::exchange(std::move(own))) {
      Work one;
      std::memcpy(&one, of.data(), std::min(of.size(), sizeof one));
      sum.counters.rays += one.counters.rays;
      sum.counters.rays_again += one.counters.rays_again;
      sum.bytes_sent += one.bytes_sent;
    }
    return sum;
  }

private:
  render::Renderer alone_;
  render::SharedRenderer together_;
  render::Picture picture_;
  std::int64_t bytes_sent_ = 0; ///< by this process
};

/// Picture file of one view of a ring, or of the only view.
fs::path picture_of(const RenderOptions& options, int view) {
  fs::path file = options.out;
  if (options.ring > 0)
    file.replace_filename(fmt::format("{}_{:03}.png", options.out.stem().string(), view));
  return file;
}

std::vector<std::string> draw(const RenderOptions& options, const SeenScene& seen, const render::View& view,
                              const Rgb& background, nlohmann::ordered_json& caption, Work& work) {
  Painter painter(options.threads);
  std::vector<std::string> files;
  const auto keep = [&](const render::Picture& picture, const fs::path& file) {
    files.push_back(file.string());
    if (!fem_ref::ranks().is_first())
      return;
    write_png(picture.rgb8(background), picture.width, picture.height, file);
    if (caption.empty())
      return;
    caption["picture"] = file.string();
    if (const auto why_not = draw_curves(caption, file); why_not && files.size() == 1)
      fmt::print(stderr, "maille render: no title and no scale: {}\n", *why_not);
  };
  const auto draw_view = [&](const render::View& from, const fs::path& file) {
    if (options.stereo == "none")
      return keep(painter.picture(seen, from), file);
    const auto views = render::stereo_views(from);
    const render::Picture left = painter.picture(seen, views[0]);
    keep(for_two_eyes(options.stereo, left, painter.picture(seen, views[1]), background), file);
  };
  if (options.ring > 0) {
    for (int i = 0; i < options.ring; ++i)
      draw_view(render::view_of_ring(view, i, options.ring), picture_of(options, i));
  } else {
    draw_view(view, options.out);
  }
  work = painter.work();
  return files;
}

} // namespace

int render_command(const RenderOptions& options) {
  if (options.out.extension() != ".png")
    throw UsageError("--out: expected a file that ends in .png, found " + options.out.string());
  keep_inputs({options.scene});
  for (int i = 0; i < std::max(1, options.ring); ++i)
    prepare_file("--out", picture_of(options, i).string());
  prepare_file("--json", options.json);
  const Rgb background = background_of(options.camera);
  const auto crop = crop_of(options.camera);
  const Control control = terminal_control(options.threads);
  nlohmann::ordered_json caption;
  std::string legend;
  SeenScene seen = seen_by(options, control, caption, legend);
  end_progress();
  std::string words = command_line(); // scene names may differ between ranks
  if (const std::size_t at = words.find(options.scene.string()); at != std::string::npos)
    words.erase(at, options.scene.string().size());
  if (!ranks_agree_on(nullptr, words))
    return exit_faulty_input;
  for (render::SceneObject& object : seen.objects)
    object.crop = crop;
  const render::View view = view_of(options.camera, seen.objects);
  check_eye(view, seen.objects);
  const auto start = std::chrono::steady_clock::now();
  Work work;
  if (control.progress)
    control.progress(0, "casting");
  const auto files = draw(options, seen, view, background, caption, work);
  end_progress();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!fem_ref::ranks().is_first())
    return exit_done;
  if (options.json) {
    deliver(json_text({{"scene", seen.name},
                       {"objects", seen.objects.size()},
                       {"bytes", seen.bytes()},
                       {"rays", work.counters.rays},
                       {"rays_again", work.counters.rays_again},
                       {"bytes_sent", work.bytes_sent},
                       {"seconds", seconds},
                       {"legend", legend},
                       {"files", files}}),
            options.json);
  }
  if (options.json != "-") {
    if (!legend.empty())
      fmt::print("{}\n", legend);
    for (const std::string& file : files)
      fmt::print("wrote {}\n", file);
  }
  return exit_done;
}

} // namespace maille::studies
