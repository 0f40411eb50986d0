#pragma once
/// Worlds for hands, and hands that are made of events.

#include "maille/live/device.hpp"
#include "maille/live/live.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "support/kit.hpp"

#include <cstring>

namespace maille::live::test {

using maille::test::has;

inline const std::filesystem::path world_folder = std::filesystem::path(MAILLE_SCENES) / "world";
inline constexpr double mm = 1e-3;

/// A block of 9 x 9 x 9 nodes, held at the bottom, with limits of its own.
inline Scene block(int cells = 8) {
  return parse_scene(maille::test::box_text(fmt::format("[{0}, {0}, {0}]", cells)) +
                         maille::test::hold_text("z-") +
                         "[limits]\nfrom = \"given\"\nstretch = 1.25\ncompress = 0.75\nshear = 0.25\n",
                     "block.toml");
}

inline WorldScene block_world(const std::string& method, int cells = 8) {
  std::vector<std::string> left_out;
  return world_of_body(block(cells), method, left_out);
}

inline std::int64_t top_middle(const WorldScene& world) {
  const Grid& grid = world.objects[0].scene.specimen.grid;
  return grid.node({grid.cells()[0] / 2, grid.cells()[1] / 2, grid.cells()[2]});
}

inline LiveTools tools() {
  LiveTools tools;
  tools.load = [](const std::filesystem::path& file) {
    Loaded loaded;
    loaded.scene = is_world_scene(file) ? read_world_scene(file)
                                        : world_of_body(read_scene(file), "limits", loaded.notes);
    return loaded;
  };
  return tools;
}

/// The packet as device.hpp states it, for devices that tests play.
inline void write_hand_packet(const HandPacket& packet, std::span<std::byte, hand_packet_size> bytes) {
  const Eigen::Vector3d& x = packet.pose.position;
  const Eigen::Quaterniond q(packet.pose.rotation);
  const std::array<double, 7> numbers{x[0], x[1], x[2], q.w(), q.x(), q.y(), q.z()};
  const std::array<std::uint32_t, 2> ends{packet.buttons, 0};
  std::memcpy(bytes.data(), "MLH1", 4);
  std::memcpy(bytes.data() + 4, &packet.number, 4);
  std::memcpy(bytes.data() + 8, numbers.data(), sizeof numbers);
  std::memcpy(bytes.data() + 64, ends.data(), sizeof ends);
}

/// At once. @param name  of a key or a widget
inline ScriptedEvent event(EventKind kind, const std::string& name = "", double value = 0) {
  Event event;
  event.kind = kind;
  event.name = name;
  event.value = value;
  return {0, event};
}

inline ScriptedEvent key(const std::string& name, bool control = false) {
  ScriptedEvent pressed = event(EventKind::key_down, name);
  pressed.event.control = control;
  return pressed;
}

/// The first button. @param x, y  [pixels]
inline ScriptedEvent pointer(EventKind kind, double x, double y, bool shift = false) {
  ScriptedEvent moved = event(kind);
  moved.event.button = 1;
  moved.event.x = x;
  moved.event.y = y;
  moved.event.shift = shift;
  return moved;
}

/// Where a place of a 2D world is in a window without a panel.
inline Event at(EventKind kind, const WorldScene& scene, double x, double y, int width = 640,
                int height = 480) {
  const Looking looking = first_looking(scene, width, height);
  const auto place = flat_place(looking, static_cast<double>(width) / height, {x, y, 0});
  return pointer(kind, place[0] * width, place[1] * height).event;
}

/// A drag of what lies at a place through others, in steps of at most two millimetres.
inline std::vector<ScriptedEvent> dragged(const WorldScene& scene, std::array<double, 2> from,
                                          const std::vector<std::array<double, 2>>& shifts) {
  std::vector<ScriptedEvent> script{{0, at(EventKind::pointer_down, scene, from[0], from[1])}};
  std::array<double, 2> now{0, 0};
  for (const auto& to : shifts) {
    const int n = std::max(1, static_cast<int>(std::hypot(to[0] - now[0], to[1] - now[1]) / (2 * mm)));
    for (int i = 1; i <= n; ++i)
      script.push_back({0, at(EventKind::pointer_move, scene, from[0] + now[0] + (to[0] - now[0]) * i / n,
                              from[1] + now[1] + (to[1] - now[1]) * i / n)});
    now = to;
  }
  script.push_back({0, at(EventKind::pointer_up, scene, from[0] + now[0], from[1] + now[1])});
  return script;
}

inline LiveReport played(const std::filesystem::path& scene, std::vector<ScriptedEvent> script,
                         HeadlessWindow& window, LiveSettings settings = {},
                         const LiveTools& with = tools()) {
  settings.scene = scene;
  settings.script = std::move(script);
  settings.in_step = true;
  return run_live(window, settings, with);
}

} // namespace maille::live::test
