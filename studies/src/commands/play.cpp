#include "play/play.hpp"

#include "cli/commands.hpp"
#include "cli/inputs.hpp"
#include "cli/worlds.hpp"
#include "commands/camera_options.hpp"
#include "json_parts.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "picture/world_picture.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace maille::studies {

namespace {

constexpr int overview_moments = 4;

std::string provenance(const WorldScene& scene, const Trajectory& trajectory, const PlayOptions& options) {
  return provenance_with({{"scene", scene.name},
                          {"title", scene.title},
                          {"trajectory", trajectory.name},
                          {"method", scene.method},
                          {"threads", options.threads}});
}

/// Output of a play: files for ParaView, pictures, a film in the folder, and the overview picture at its own
/// path.
class Recording {
public:
  /// @param folder  null: no files except the overview
  /// @param world  its present state is used when a moment is added
  Recording(const deform::World& world, const Trajectory& trajectory, const PlayOptions& options,
            ResultsFolder* folder)
      : world_(world), scene_(world.scene()), renderer_(options.threads),
        background_(background_of(options.camera)), crop_(crop_of(options.camera)), options_(options),
        folder_(folder), n_moments_(trajectory.n_frames + 1), frame_seconds_(trajectory.frame_seconds),
        n_digits_(std::max(4, static_cast<int>(fmt::formatted_size("{}", trajectory.n_frames)))),
        stem_(folder ? folder->file("") : std::filesystem::path()) {
    if (folder)
      series_.emplace(scene_, stem_, static_cast<std::size_t>(n_moments_),
                      provenance(scene_, trajectory, options), length_unit(options.unit));
    if (folder && options.pictures && options.render == "volume")
      seen_ = seen_world(scene_, options.scene);
  }

  void add(const WorldMoment& moment, std::int64_t number) {
    if (series_) {
      series_->add(moment);
      // Not after every frame, because the list grows.
      if (const auto now = Clock::now(); now - last_list_ > std::chrono::seconds(1)) {
        series_->write();
        last_list_ = now;
      }
    }
    if (is_in_overview(number))
      overview_.push_back({number, moment});
    if (series_ && options_.pictures && why_no_picture_.empty()) {
      const auto png = std::filesystem::path(fmt::format("{}_{:0{}}.png", stem_.string(), number, n_digits_));
      if (seen_) {
        render_volumes(png);
      } else if (const auto why =
                     render_world(scene_, {{fmt::format("{:.3f} s", moment.time), &moment}}, png))
        why_no_picture_ = *why;
      else
        keep_picture(png);
    }
  }

  /// Writes the final files. @return a line for each created or missing output
  std::vector<std::string> finish(bool is_whole) {
    std::vector<std::string> lines;
    if (series_) {
      const auto list = series_->write();
      folder_->add(series_->files());
      folder_->add(list);
      lines.push_back(fmt::format("wrote {}, {} files", list.string(), series_->n_files()));
    }
    if (n_pictures_ > 0) {
      lines.push_back(fmt::format("wrote {}_*.png, {} pictures", stem_.string(), n_pictures_));
      const std::filesystem::path mp4 = stem_.string() + ".mp4";
      const auto why = make_film(stem_, n_digits_, n_pictures_, frame_seconds_, mp4);
      if (!why)
        folder_->add(mp4);
      lines.push_back(why ? *why : "wrote " + mp4.string());
    }
    if (options_.picture)
      draw_overview(lines);
    if (!why_no_picture_.empty())
      lines.push_back(why_no_picture_);
    if (folder_ && !is_whole)
      folder_->keep_earlier();
    if (folder_)
      folder_->finish({{"title", scene_.title}, {"method", scene_.method}, {"moments", n_moments_}});
    return lines;
  }

private:
  using Clock = std::chrono::steady_clock;

  void keep_picture(const std::filesystem::path& png) {
    ++n_pictures_;
    folder_->add(png);
  }

  /// Objects unmoved since the last frame are not rendered again; the camera is fixed.
  void render_volumes(const std::filesystem::path& png) {
    follow(world_, *seen_);
    for (render::SceneObject& object : seen_->objects)
      object.crop = crop_;
    if (!view_) {
      view_ = view_of(options_.camera, seen_->objects);
      check_eye(*view_, seen_->objects);
    }
    if (options_.stereo == "none") {
      write(renderer_.eye(0).render(seen_->objects, *view_), png);
    } else {
      const auto eyes = renderer_.render(seen_->objects, *view_);
      write(for_two_eyes(options_.stereo, *eyes[0], *eyes[1], background_), png);
    }
  }

  void write(const render::Picture& picture, const std::filesystem::path& png) {
    write_png(picture.rgb8(background_), picture.width, picture.height, png);
    keep_picture(png);
  }

  bool is_in_overview(std::int64_t number) const {
    for (int i = 0; options_.picture && i < overview_moments; ++i)
      if (number == std::llround(static_cast<double>((n_moments_ - 1) * i) / (overview_moments - 1)))
        return true;
    return false;
  }

  void draw_overview(std::vector<std::string>& lines) {
    std::vector<WorldPanel> panels;
    for (const auto& [number, moment] : overview_)
      panels.push_back({fmt::format("frame {}", number), &moment});
    WorldPictureSettings settings;
    settings.title = scene_.title;
    settings.width = 1400;
    settings.largest_height = 1150;
    if (const auto why = render_world(scene_, panels, *options_.picture, settings))
      why_no_picture_ = *why;
    else
      lines.push_back("wrote " + *options_.picture);
  }

  const deform::World& world_;
  const WorldScene& scene_;
  std::optional<SeenScene> seen_; ///< for volume rendering
  std::optional<render::View> view_;
  render::StereoRenderer renderer_; ///< without stereo only its first eye
  Rgb background_;
  std::optional<render::CropBox> crop_;
  const PlayOptions& options_;
  ResultsFolder* folder_;
  std::int64_t n_moments_;
  double frame_seconds_;
  int n_digits_;
  std::filesystem::path stem_;
  std::optional<WorldSeries> series_;
  std::vector<std::pair<std::int64_t, WorldMoment>> overview_;
  std::string why_no_picture_;
  std::int64_t n_pictures_ = 0;
  Clock::time_point last_list_{};
};

void check(const PlayOptions& options, const WorldScene& scene, std::optional<ResultsFolder>& folder) {
  if (options.picture && !options.picture->ends_with(".png"))
    throw UsageError("--picture: expected a file that ends in .png, found " + *options.picture);
  std::vector<std::string> sure{".pvd"};
  if (options.pictures && has_ffmpeg())
    sure.emplace_back(".mp4");
  if (options.out)
    folder.emplace(*options.out, scene.name, options.scene, "play", sure);
  prepare_file("--json", options.json, folder); // may be asked for in that folder
  prepare_file("--picture", options.picture, folder);
}

} // namespace

int play_command(const PlayOptions& options) {
  if (is_recorded_hand(options.trajectory))
    return feel_command(options);
  keep_inputs({options.scene, options.trajectory});
  std::vector<std::string> left_out;
  WorldScene scene = is_world_scene(options.scene)
                         ? read_world_scene(options.scene)
                         : world_of_body(read_scene(options.scene), "limits", left_out);
  Trajectory trajectory = read_trajectory(options.trajectory, scene);
  apply_settings(trajectory.settings, scene);
  Player player(world_of(scene, options.scene), std::move(trajectory));
  std::optional<ResultsFolder> folder;
  check(options, scene, folder);
  const Control control = terminal_control(options.threads);
  Recording recording(player.world(), player.trajectory(), options, folder ? &*folder : nullptr);
  recording.add(player.moment(), 0);
  std::vector<PlayedFrame> frames;
  bool has_failed = false;
  std::int64_t n_inside = 0; // largest number in any frame
  while (!player.is_at_end() && !control.should_stop()) {
    PlayedFrame frame = player.next(control);
    if (frame.status == Status::interrupted)
      break; // feasible, but not a complete frame
    has_failed = has_failed || !has_displacement(frame.status);
    recording.add(player.moment(), frame.number);
    if (control.progress)
      control.progress(static_cast<double>(frame.number) / static_cast<double>(player.trajectory().n_frames),
                       fmt::format("frame {} of {}", frame.number, player.trajectory().n_frames));
    if (!frame.contacts.empty())
      n_inside = std::max(n_inside, penetrations_of(player.world()));
    frames.push_back(std::move(frame));
  }
  end_progress();
  const bool is_whole = static_cast<std::int64_t>(frames.size()) == player.trajectory().n_frames;
  n_inside = std::max(n_inside, penetrations_of(player.world()));
  if (n_inside > 0)
    fmt::print(stderr, "maille play: {} cells of matter lie in the matter of another object, or outside\n",
               n_inside);
  std::vector<std::string> lines = recording.finish(is_whole);
  for (const std::string& each : left_out)
    lines.push_back("not asked here: " + each);
  const std::vector<std::string> warnings = world_warnings(scene);
  if (options.json != "-") {
    deliver(in_words(player, frames), std::nullopt);
    for (const std::string& line : lines)
      fmt::print("{}\n", line);
    for (const std::string& warning : warnings)
      fmt::print("warning: {}\n", warning);
  }
  if (options.json) {
    auto out = json(player, frames);
    out["files"] = lines;
    out["warnings"] = warnings;
    deliver(json_text(out), options.json);
  }
  return is_whole && !has_failed && n_inside == 0 ? exit_done : exit_run_failed;
}

} // namespace maille::studies
