/// Worlds of many objects, of many free bodies, and of time that passes.

#include "stability/world_questions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace maille::lab {

namespace {

/// Boxes of 2 x 2 cells in rows, a cell apart, on the right of a plunger as high as the world.
/// @param one_soft_in every n-th object is deformable; 0: none
WorldScene crowd(int n, int one_soft_in, const std::string& method, ContactLaw contact) {
  const int columns = std::max(2, static_cast<int>(std::ceil(std::sqrt(n)))),
            rows = (n + columns - 1) / columns;
  WorldScene world = empty_world({3 * columns + 8, 3 * rows + 2}, method, contact);
  world.objects.push_back(box_in(world, ObjectKind::rigid, {2, 3 * rows}, 1, {1, 1, 0}));
  for (int i = 0; i < n; ++i) {
    const bool is_soft = one_soft_in > 0 && i % one_soft_in == 0;
    // Every other row is off by half a box, so that rows do not push in line.
    world.objects.push_back(
        box_in(world, is_soft ? ObjectKind::deformable : ObjectKind::rigid, {2, 2}, 1,
               {5.3 + 3.0 * (i % columns) + i / columns % 2, 1.5 + 3.0 * (i / columns), 0}));
  }
  return world;
}

WorldPlay pushed(WorldScene world, double by, int frames) {
  WorldPlay play;
  play.scene = std::move(world);
  repeat(play, shift_of(play.scene, 0, {by / frames, 0, 0}), frames);
  return play;
}

void add_crowds(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  for (const int n : {10, 100, 500}) {
    if (n > sizes.objects)
      continue;
    for (const int one_soft_in : {0, 5})
      add({.extreme = "worlds: many objects",
           .setting = fmt::format("{}, {}{}", n, one_soft_in > 0 ? "one in five soft" : "rigid",
                                  n == 10 && one_soft_in == 0 ? ", normal" : ""),
           .methods = one_soft_in > 0 ? std::vector<std::string>{"limits", "relaxed", "coupled"}
                                      : std::vector<std::string>{"coupled"},
           .play =
               [=](const std::string& method) {
                 return pushed(crowd(n, one_soft_in, method, ContactLaw::cells), 0.7 * std::sqrt(n) + 3, 8);
               },
           .is_normal = n == 10},
          list);
  }
  for (const int n : {4, 9, 25, 64}) {
    if (n > sizes.free_bodies)
      continue;
    for (const ContactLaw contact : {ContactLaw::cells, ContactLaw::surfaces}) {
      const bool is_normal = n == 4 && contact == ContactLaw::cells;
      add({.extreme = "worlds: free soft bodies",
           .setting = fmt::format("{}{}{}", n, contact == ContactLaw::surfaces ? ", surfaces" : "",
                                  is_normal ? ", normal" : ""),
           .methods = contact == ContactLaw::surfaces
                          ? std::vector<std::string>{"coupled"}
                          : std::vector<std::string>{"limits", "relaxed", "coupled"},
           .play =
               [=](const std::string& method) {
                 return pushed(crowd(n, 1, method, contact), 0.7 * std::sqrt(n) + 3, 6);
               },
           .is_normal = is_normal},
          list);
    }
  }
}

struct Time {
  double gravity, restitution, damping, speed;
};

/// Boxes that fly about and fall into a heap.
WorldPlay heap(int n, const Time& time, bool is_soft, int frames) {
  WorldPlay play;
  play.scene = crowd(n, is_soft ? 2 : 0, "coupled", ContactLaw::surfaces);
  play.frame_seconds = 0.005;
  WorldScene& world = play.scene;
  world.objects.erase(world.objects.begin()); // no plunger
  world.dynamics.emplace();
  world.dynamics->gravity = {0, -time.gravity, 0};
  world.dynamics->restitution = time.restitution;
  world.dynamics->damping = time.damping;
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    world.objects[i].name = fmt::format("box{}", i);
    world.objects[i].velocity = {time.speed * (i % 2 == 0 ? 1 : -1), time.speed * (i % 3 == 0 ? 0.5 : -0.5),
                                 0};
  }
  play.frames.resize(static_cast<std::size_t>(frames));
  return play;
}

void add_heaps(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  const auto add_heap = [&](const std::string& setting, int n, const Time& time, bool is_soft,
                            bool is_normal) {
    add({.extreme = "worlds: dynamics",
         .setting = setting,
         .methods = {"coupled"},
         .play = [=,
                  frames = sizes.world_frames](const std::string&) { return heap(n, time, is_soft, frames); },
         .is_normal = is_normal},
        list);
  };
  add_heap("9 rigid boxes, normal", 9, {9.81, 0.5, 0, 0.3}, false, true);
  for (const double restitution : {0.0, 1.0})
    add_heap(fmt::format("restitution {:g}", restitution), 9, {9.81, restitution, 0, 0.3}, false, false);
  add_heap("gravity 1000 m/s^2", 4, {1000, 0.5, 0, 0.3}, false, false);
  add_heap("no gravity, restitution 1", 9, {0, 1, 0, 0.3}, false, false);
  add_heap("damping 1e6/s", 9, {9.81, 0.5, 1e6, 0.3}, false, false);
  add_heap("speeds of 30 m/s", 4, {9.81, 0.5, 0, 30}, false, false);
  add_heap("4 boxes, two of them soft", 4, {9.81, 0, 0, 0.3}, true, false);
  add_heap("4 boxes, two of them soft, speeds of 30 m/s", 4, {9.81, 0, 0, 30}, true, false);
  add_heap("20 rigid boxes", 20, {9.81, 0.5, 0, 0.3}, false, false);
}

} // namespace

void add_extremes_of_crowds(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  add_crowds(list, sizes);
  add_heaps(list, sizes);
}

} // namespace maille::lab
