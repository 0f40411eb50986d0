#include "maille/studies/play.hpp"
#include "maille/studies/version.hpp"
#include "median.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <utility>

namespace maille::studies {

namespace {

const char* name_of(ObjectKind kind) {
  return kind == ObjectKind::fixed ? "fixed" : kind == ObjectKind::rigid ? "rigid" : "deformable";
}

std::string name_of(const WorldScene& scene, int object) {
  return object < 0 ? "border" : scene.objects[static_cast<std::size_t>(object)].name;
}

nlohmann::ordered_json in_json(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

nlohmann::ordered_json in_json(const WorldScene& scene, const PlayedFrame& frame) {
  nlohmann::ordered_json row{{"frame", frame.number},
                             {"status", to_string(frame.status)},
                             {"seconds", frame.seconds},
                             {"rounds", frame.rounds},
                             {"handed_on", frame.handed_on},
                             {"moved_on", frame.moved_on},
                             {"drives", nlohmann::ordered_json::array()},
                             {"contacts", nlohmann::ordered_json::array()}};
  if (!frame.message.empty())
    row["message"] = frame.message;
  for (const PlayedDrive& drive : frame.drives)
    row["drives"].push_back({{"object", name_of(scene, drive.object)},
                             {"fraction", drive.fraction},
                             {"force", in_json(drive.force)}});
  for (const PlayedContact& contact : frame.contacts)
    row["contacts"].push_back({{"object", name_of(scene, contact.object)},
                               {"other", name_of(scene, contact.other)},
                               {"voxels", contact.voxels},
                               {"force", in_json(contact.force)}});
  return row;
}

double longest(const std::vector<PlayedFrame>& frames) {
  double seconds = 0;
  for (const PlayedFrame& frame : frames)
    seconds = std::max(seconds, frame.seconds);
  return seconds;
}

double median(const std::vector<PlayedFrame>& frames) {
  std::vector<double> seconds;
  for (const PlayedFrame& frame : frames)
    seconds.push_back(frame.seconds);
  return upper_median(std::move(seconds));
}

} // namespace

nlohmann::ordered_json json(const Player& player, const std::vector<PlayedFrame>& frames) {
  const WorldScene& scene = player.world().scene();
  nlohmann::ordered_json out{
      {"scene", scene.name},
      {"trajectory", player.trajectory().name},
      {"maille", version},
      {"dimension", scene.dimension},
      {"cells", scene.cells},
      {"method", scene.method},
      {"frames_asked", player.trajectory().n_frames},
      {"frame_seconds", player.trajectory().frame_seconds},
      {"penetrations", player.world().n_penetrations() + player.world().n_shared_cells()},
      {"limit_violation", player.world().largest_violation()},
      {"bytes", player.world().bytes()},
      {"objects", nlohmann::ordered_json::array()},
      {"frames", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const deform::Pose& pose = player.world().pose(static_cast<int>(i));
    out["objects"].push_back(
        {{"name", scene.objects[i].name},
         {"kind", name_of(scene.objects[i].kind)},
         {"cells", scene.objects[i].scene.specimen.n_matter_cells()},
         {"position", in_json(pose.position)},
         {"rotation",
          {in_json(pose.rotation.row(0)), in_json(pose.rotation.row(1)), in_json(pose.rotation.row(2))}}});
  }
  for (const PlayedFrame& frame : frames)
    out["frames"].push_back(in_json(scene, frame));
  return out;
}

std::string in_words(const Player& player, const std::vector<PlayedFrame>& frames) {
  const WorldScene& scene = player.world().scene();
  std::string text = fmt::format("{}: {} of {} frames of {}\n", scene.title, frames.size(),
                                 player.trajectory().n_frames, player.trajectory().name);
  std::map<std::string_view, int> ended;
  std::map<std::pair<int, int>, std::int64_t> touched;
  for (const PlayedFrame& frame : frames) {
    ++ended[to_string(frame.status)];
    for (const PlayedContact& contact : frame.contacts)
      ++touched[{contact.object, contact.other}];
  }
  for (const auto& [status, n] : ended)
    text += fmt::format("{:<16}{} frame{}\n", status, n, n == 1 ? "" : "s");
  text += fmt::format("{:<16}median {:.3g} s, longest {:.3g} s\n", "a frame took", median(frames),
                      longest(frames));
  for (const auto& [pair, n] : touched)
    text += fmt::format("{:<16}{} against {} in {} frame{}\n", "contact", name_of(scene, pair.first),
                        name_of(scene, pair.second), n, n == 1 ? "" : "s");
  text += fmt::format("{:<16}{}\n", "penetrations",
                      player.world().n_penetrations() + player.world().n_shared_cells());
  return text;
}

} // namespace maille::studies
