// Several processes in one: what they send each other goes from list to list.

#include "maille/render/shared.hpp"
#include "shapes.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace maille::render::test {
namespace {

/// Interlocked and deformed objects, and one that is hidden.
std::vector<SceneObject> objects_of_all_kinds() {
  std::vector<SceneObject> objects{cube(28, ring(8e-3, 2.5e-3), half_clear({0.9f, 0.4f, 0.2f}, 0.4)),
                                   cube(28, ring(8e-3, 2.5e-3), half_clear({0.2f, 0.5f, 0.9f}, 0.9)),
                                   cube(28, ring(6e-3, 3e-3), half_clear({0.2f, 0.8f, 0.3f}, 0.5)),
                                   cube(28, ring(6e-3, 3e-3), half_clear({0.2f, 0.8f, 0.3f}, 0.5))};
  objects[1].pose = turned({8e-3, 0, 0}, 1.5707963);
  objects[2].deformation = bent(objects[2], 0.6);
  objects[2].pose = turned({-4e-3, 3e-3, 2e-3}, 0.9, 0.4);
  objects[3].hidden = true;
  return objects;
}

using Bytes = SharedRenderer::Bytes;

Picture by_processes(int size, const std::vector<SceneObject>& objects, const View& view, Counters& sum) {
  std::vector<std::unique_ptr<SharedRenderer>> all;
  std::vector<std::vector<Bytes>> sent;
  for (int rank = 0; rank < size; ++rank) {
    all.push_back(std::make_unique<SharedRenderer>(rank, size, 1 + rank % 2));
    sent.push_back(all.back()->cast(objects, view));
  }
  std::vector<Bytes> pixels;
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    std::vector<Bytes> received;
    for (const auto& of : sent)
      received.push_back(of[rank]);
    pixels.push_back(all[rank]->compose(received));
    sum.rays += all[rank]->counters().rays;
    sum.rays_again += all[rank]->counters().rays_again;
    sum.objects += all[rank]->counters().objects;
  }
  return all.front()->assemble(pixels);
}

TEST(SharedContract, SameBitsByAnyNumberOfProcesses) {
  const auto objects = objects_of_all_kinds();
  const View view = view_from({0.03, 0.05, 0.09}, 75); // tiles that the picture's edge cuts
  Renderer alone;
  const Picture& expected = alone.render(objects, view);
  EXPECT_GT(alone.counters().rays_again, 0);
  for (const int size : {1, 2, 3, 7}) {
    Counters sum;
    const Picture picture = by_processes(size, objects, view, sum);
    EXPECT_EQ(picture.rgba, expected.rgba) << size;
    EXPECT_EQ(picture.depth, expected.depth) << size;
    EXPECT_EQ(picture.object, expected.object) << size;
    EXPECT_EQ(sum.rays, alone.counters().rays) << size; // no ray is cast twice
    EXPECT_EQ(sum.objects, alone.counters().objects) << size;
  }
}

TEST(SharedContract, WhatBreaksOffIsRefused) {
  const auto objects = objects_of_all_kinds();
  SharedRenderer renderer(0, 1);
  auto sent = renderer.cast(objects, view_from({0.03, 0.05, 0.09}, 40));
  sent[0].pop_back();
  EXPECT_THROW(renderer.compose(sent), std::invalid_argument);
  EXPECT_THROW(SharedRenderer(2, 2), std::invalid_argument);
}

} // namespace
} // namespace maille::render::test
