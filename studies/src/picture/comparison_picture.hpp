#pragma once
/// A picture of several answers to one scene, side by side in the same view and colours.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// One of the bodies in a picture.
struct PicturePanel {
  std::string label = {};                     ///< written under the body, e.g. the method's name
  const Displacement* displacement = nullptr; ///< [m], object's frame; required
  std::optional<double> relative_l2 = {};     ///< error against the reference [1]; written under the label
  bool is_reference = false;                  ///< writes "reference" there instead
  const Displacement* coloured = nullptr;     ///< colours show the length of this instead, such as an error
};

/// What a box of the page shows: a parallel view, directions and lengths in the object's frame.
struct PanelView {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, toward{0, 0, 1}; ///< unit vectors; `toward` the viewer
  Vec3 centre{};                                     ///< in the middle of the box [m]
  double pixels_per_metre = 1;
  int width = 1, height = 1; ///< [pixels]
  double warp = 1;           ///< factor on the drawn displacements
};
/// Draws a body that is displaced: three bytes a pixel over white, rows from the top.
using DrawBody = std::function<std::vector<std::uint8_t>(const Displacement&, const PanelView&)>;

struct PictureSettings {
  std::string title = {};          ///< above the panels; none if empty
  int width = 1600;                ///< [pixels], at least 200
  int largest_height = 800;        ///< [pixels], at least 200; the picture is as high as its content needs
  std::optional<double> warp = {}; ///< factor on the drawn displacements; else chosen_warp
  std::string quantity = "displacement"; ///< what colours show
  std::optional<double> unit = {}; ///< of the numbers by the colours, in units of `coloured`; else a length
  std::string unit_name = {};      ///< then
  std::vector<const Displacement*> also_in_view = {}; ///< view and colours are those for these, too
  DrawBody draw_body = {};    ///< in place of surfaces; colours then mean what it says, not a scale
  bool is_anatomical = false; ///< the world is that of patients (RAS): letters at the ends of its axes
};

/// The factor by which displacements are drawn larger: 1 (true scale) if the largest is at least 3 % of the
/// body's longest side, else the largest of 1, 2, 5, 10, 20, ... that keeps it below 12 %.
double chosen_warp(const Scene& scene, const std::vector<PicturePanel>& panels);

/// @brief Draws the deformed bodies side by side into a PNG file, the body at rest behind them in grey.
///
/// One camera and one colour scale (length of the displacement, object's frame) serve all panels.
/// Three-dimensional bodies are seen from above one side, the longest axis of the grid to the right; images
/// stand upright in their world, seen from its y axis (the front of a patient); one-dimensional bodies are
/// tubes. A triad shows the world's axes. Nodes whose displacement is not finite are drawn red, at rest. No
/// screen is needed: an EGL context without a window is tried first, then the X server that DISPLAY names.
///
/// @param panels  at least one; displacements on the scene's grid
/// @param png     in a folder that exists; appears whole or not at all
/// @return nothing, or why no picture could be made on this machine; never ends the process
/// @throws std::invalid_argument  no panels, or one without a displacement of the scene's grid
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written
/// @pre not called from two threads at once (OpenGL's context is per process here)
[[nodiscard]] std::optional<std::string> render_comparison(const Scene& scene,
                                                           const std::vector<PicturePanel>& panels,
                                                           const std::filesystem::path& png,
                                                           const PictureSettings& settings = {});

} // namespace maille::studies
