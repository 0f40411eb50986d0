// Bodies of comparisons, seen by their grey values.

#include "view/seen_scene.hpp"

#include <memory>
#include <utility>

namespace maille::studies {

namespace {

render::View view_of_panel(const PanelView& of) {
  render::View view;
  view.width = of.width;
  view.height = of.height;
  view.samples_per_voxel = 2;
  view.light = {-0.4, 0.6, 1};
  view.camera.parallel = true;
  view.camera.parallel_scale = 0.5 * of.height / of.pixels_per_metre;
  view.camera.focal_point = of.centre;
  view.camera.view_up = of.up;
  const double far = 10.0 * (of.width + of.height) / of.pixels_per_metre; // outside of everything
  for (std::size_t a = 0; a < 3; ++a)
    view.camera.position[a] = of.centre[a] + far * of.toward[a];
  return view;
}

} // namespace

DrawBody draw_grey_values(const Scene& scene, const std::filesystem::path& file, int threads) {
  auto looks = read_looks(file);
  if (scene.dimension() != 3 || looks.empty() || !looks.front() || looks.front()->grey.values.empty())
    return {};
  auto seen = std::make_shared<SeenScene>(seen_scene(scene, std::move(looks), true));
  seen->objects[0].pose = {}; // panels are in the object's frame
  return [&scene, seen, threads](const Displacement& displacement, const PanelView& of) {
    Displacement drawn = displacement;
    for (double& u : drawn.values())
      u *= of.warp;
    follow(scene, drawn, *seen);
    render::Renderer renderer(threads);
    return renderer.render(seen->objects, view_of_panel(of)).rgb8();
  };
}

} // namespace maille::studies
