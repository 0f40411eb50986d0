#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/studies/version.hpp"
#include "median.hpp"
#include "play/play.hpp"
#include "results/scene_tables.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace maille::studies {

namespace {

/// An item about one or two objects, with the world for their names.
template<class Of>
struct InWorld {
  const WorldScene* scene;
  const Of* of;
};

template<class Of>
std::vector<InWorld<Of>> in_world(const WorldScene* scene, const std::vector<Of>& list) {
  std::vector<InWorld<Of>> rows;
  for (const Of& of : list)
    rows.push_back({scene, &of});
  return rows;
}

std::string name_of(const WorldScene& scene, int object) {
  return object < 0 ? "border" : scene.objects[object].name;
}

/// Adds the name of an object of a row. @param number member with its number
template<class Of>
void add_name(ResultTable<InWorld<Of>>& columns, const char* key, const char* meaning, int Of::*number) {
  columns.add({"", key, "", meaning},
              [number](const InWorld<Of>& row) { return name_of(*row.scene, row.of->*number); });
}

const ResultTable<InWorld<PlayedDrive>>& columns_of_drives() {
  using Row = InWorld<PlayedDrive>;
  static const ResultTable<Row> table([](ResultTable<Row>& columns) {
    add_name(columns, "object", "that is driven", &PlayedDrive::object);
    columns.add({"", "fraction", "", "of the frame's motion that was done"}, &Row::of,
                &PlayedDrive::fraction);
    columns.add({"", "force", "N", "that the hand needs"}, &Row::of, &PlayedDrive::force, array);
  });
  return table;
}

const ResultTable<InWorld<PlayedContact>>& columns_of_contacts() {
  using Row = InWorld<PlayedContact>;
  static const ResultTable<Row> table([](ResultTable<Row>& columns) {
    add_name(columns, "object", "that presses", &PlayedContact::object);
    add_name(columns, "other", "what it presses against; border: of the world", &PlayedContact::other);
    columns.add({"", "voxels", "", "of the first that press"}, &Row::of, &PlayedContact::voxels);
    columns.add({"", "force", "N", "on the first"}, &Row::of, &PlayedContact::force, array);
  });
  return table;
}

const ResultTable<InWorld<PlayedFrame>>& columns_of_frames() {
  using Row = InWorld<PlayedFrame>;
  static const ResultTable<Row> table([](ResultTable<Row>& columns) {
    constexpr auto of = &Row::of;
    columns.add({"", "frame", "", "from 1"}, of, &PlayedFrame::number);
    columns.add({"", "status", "", "how it ended"}, of, &PlayedFrame::status);
    columns.add({"", "seconds", "s", "that it took"}, of, &PlayedFrame::seconds);
    columns.add({"", "rounds", "", "of objects that moved each other"}, of, &PlayedFrame::rounds);
    columns
        .add({"", "motion_left", "m", "how far anything would still go until all has settled, estimated"},
             [](const Row& row) { return row.of->motion_left.value_or(0); })
        .json_where([](const Row& row) { return row.of->motion_left.has_value(); });
    columns
        .add({"", "force_left", "N", "by which the force on any object would still change, estimated"},
             [](const Row& row) { return row.of->force_left.value_or(0); })
        .json_where([](const Row& row) { return row.of->force_left.has_value(); });
    columns.add({"", "handed_on", "", "movements from one voxel to another"}, of, &PlayedFrame::handed_on);
    columns.add({"", "moved_on", "m", "by their receivers, all together"}, of, &PlayedFrame::moved_on);
    columns.add_rows({"", "drives", "", "a row each"}, columns_of_drives(),
                     [](const Row& row) { return in_world(row.scene, row.of->drives); });
    columns.add_rows({"", "contacts", "", "a row a pair of objects"}, columns_of_contacts(),
                     [](const Row& row) { return in_world(row.scene, row.of->contacts); });
    columns.add({"", "message", "", "why the method ended"}, of, &PlayedFrame::message)
        .json_where([](const Row& row) { return !row.of->message.empty(); });
  });
  return table;
}

/// State of an object after the last frame.
struct PlayedObject {
  const WorldObject* object;
  deform::Pose frame;
};

const ResultTable<PlayedObject>& columns_of_objects() {
  static const ResultTable<PlayedObject> table([](ResultTable<PlayedObject>& columns) {
    constexpr auto object = &PlayedObject::object;
    constexpr auto pose = &PlayedObject::frame;
    columns.add({"", "name", "", "of the object"}, object, &WorldObject::name);
    columns.add({"", "kind", "", "fixed, rigid or deformable"}, object, &WorldObject::kind,
                [](ObjectKind kind) { return studies::name_of(kind); });
    columns.add({"", "cells", "", "of matter"}, object, &WorldObject::scene, &Scene::specimen,
                &Specimen::n_matter_cells);
    columns.add({"", "position", "m", "of its frame at the end"}, pose, &deform::Pose::position, array);
    columns.add({"", "rotation", "", "of its frame, a list a row"}, pose, [](const deform::Pose& of) {
      return std::array{array(of.rotation.row(0)), array(of.rotation.row(1)), array(of.rotation.row(2))};
    });
  });
  return table;
}

struct Play {
  const Player* player;
  const std::vector<PlayedFrame>* frames;
};

std::vector<PlayedObject> objects_of(const deform::World& world) {
  std::vector<PlayedObject> rows;
  for (std::size_t i = 0; i < world.scene().objects.size(); ++i)
    rows.push_back({&world.scene().objects[i], deform::frame_of(world, i)});
  return rows;
}

const ResultTable<Play>& columns_of_play() {
  static const ResultTable<Play> table([](ResultTable<Play>& columns) {
    constexpr auto player = &Play::player;
    constexpr auto world = &Player::world;
    constexpr auto scene = &deform::World::scene;
    constexpr auto trajectory = &Player::trajectory;
    columns.add({"", "scene", "", "its name"}, player, world, scene, &WorldScene::name);
    columns.add({"", "trajectory", "", "its name"}, player, trajectory, &Trajectory::name);
    columns.add({"", "maille", "", "version"}, [](const Play&) { return version; });
    columns.add({"", "dimension", "", "of the world"}, player, world, scene, &WorldScene::dimension);
    columns.add({"", "cells", "", "along x, y and z"}, player, world, scene, &WorldScene::cells);
    columns.add({"", "method", "", "that moves deformable objects"}, player, world, scene,
                &WorldScene::method);
    columns.add({"", "frames_asked", "", "by the trajectory"}, player, trajectory, &Trajectory::n_frames);
    columns.add({"", "frame_seconds", "s", "that a frame stands for"}, player, trajectory,
                &Trajectory::frame_seconds);
    columns.add({"", "penetrations", "", "voxels in the matter of another object"}, player, world,
                penetrations_of);
    columns.add({"", "limit_violation", "spacings", "largest excess of a link over its limits"}, player,
                world, &deform::World::largest_violation);
    columns.add({"", "bytes", "B", "held by the world"}, player, world, &deform::World::bytes);
    columns.add_rows({"", "objects", "", "a row each"}, columns_of_objects(), player, world, objects_of);
    columns.add_rows({"", "frames", "", "a row each"}, columns_of_frames(),
                     [](const Play& play) { return in_world(&play.player->world().scene(), *play.frames); });
  });
  return table;
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

std::int64_t penetrations_of(const deform::World& world) {
  // With surface contact, two objects may share a cell.
  return world.n_penetrations() +
         (world.scene().contact != ContactLaw::surfaces ? world.n_shared_cells() : std::int64_t{0});
}

nlohmann::ordered_json json(const Player& player, const std::vector<PlayedFrame>& frames) {
  return columns_of_play().json({&player, &frames});
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
  text += fmt::format("{:<16}{}\n", "penetrations", penetrations_of(player.world()));
  return text;
}

} // namespace maille::studies
