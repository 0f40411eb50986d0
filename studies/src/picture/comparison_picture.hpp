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
  bool is_reference = false;                  ///< writes "reference" in place of the error
  const Displacement* coloured = nullptr;     ///< colours show the length of this field, such as an error
};

/// View of a box on the page: parallel projection, directions and lengths in the object's frame.
struct PanelView {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, toward{0, 0, 1}; ///< unit vectors; `toward` the viewer
  Vec3 centre{};                                     ///< centre of the box [m]
  double pixels_per_metre = 1;
  int width = 1, height = 1; ///< [pixels]
  double warp = 1;           ///< factor on the drawn displacements
};
/// Draws a displaced body: three bytes per pixel over white, rows from the top.
using DrawBody = std::function<std::vector<std::uint8_t>(const Displacement&, const PanelView&)>;

struct PictureSettings {
  std::string title = {};                ///< above the panels; none if empty
  int width = 1600;                      ///< [pixels], at least 200
  int largest_height = 800;              ///< [pixels], at least 200; the height follows the content
  std::optional<double> warp = {};       ///< factor on the drawn displacements; default: chosen_warp()
  std::string quantity = "displacement"; ///< what colours show
  std::optional<double> unit = {}; ///< unit of the colour scale, in units of `coloured`; default: a length
  std::string unit_name = {};      ///< name of `unit`
  std::vector<PicturePanel> also_in_view = {}; ///< view and colour scale include these, too
  DrawBody draw_body = {};    ///< replaces surfaces; it defines its colours, and there is no scale
  bool is_anatomical = false; ///< world of a patient (RAS): letters at the ends of the axes
};

/// Scale factor of drawn displacements: 1 (true scale) if the largest is at least 3 % of the body's longest
/// side, else the largest of 1, 2, 5, 10, 20, ... that keeps it below 12 %.
double chosen_warp(const Scene& scene, const std::vector<PicturePanel>& panels);

/// @brief Draws the deformed bodies side by side to a PNG file, with the body at rest behind them in grey.
///
/// All panels share one camera and one colour scale (length of the displacement, object's frame).
/// Three-dimensional bodies are seen from above one side, with the longest axis of the grid to the right;
/// images stand upright in their world, seen along its y axis (the front of a patient); one-dimensional
/// bodies are tubes. A triad shows the world's axes. Nodes with non-finite displacement are drawn red, at
/// rest. No screen is needed: an EGL context without a window is tried first, then the X server of DISPLAY.
///
/// @param panels  at least one; displacements on the scene's grid
/// @param png     in an existing folder; written atomically
/// @return nothing, or the reason of a failure on this machine; never ends the process
/// @throws std::invalid_argument  no panels, or a panel without a displacement on the scene's grid
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written
/// @pre not called from two threads at once (OpenGL's context is per process here)
[[nodiscard]] std::optional<std::string> render_comparison(const Scene& scene,
                                                           const std::vector<PicturePanel>& panels,
                                                           const std::filesystem::path& png,
                                                           const PictureSettings& settings = {});

} // namespace maille::studies
