#pragma once
/// Pictures of worlds: one moment, or several side by side.

#include "export/world/world_files.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// One moment in a picture.
struct WorldPanel {
  std::string label; ///< written under it; none if empty
  const WorldMoment* moment = nullptr;
};

struct WorldPictureSettings {
  std::string title;        ///< above the panels; none if empty
  int width = 960;          ///< [pixels], at least 200
  int largest_height = 720; ///< [pixels], at least 200
};

/// @brief Draws moments of a world side by side to a PNG file, all with the same view, which shows the whole
///        world.
///
/// Fixed objects are grey, each other object has its own colour. Deformable objects show their cell edges;
/// cells of different materials differ in shade, or in colour if there are many, as in pieces of a picture.
/// Dots mark contacts. Three-dimensional worlds are seen from the front, a little from above and the right, z
/// upwards; one-dimensional objects are drawn as bands.
///
/// Requirements are those of render_comparison; widths and heights are even, as required by films.
/// @return nothing, or why no picture could be made on this machine
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written
/// @pre not called from two threads at once
[[nodiscard]] std::optional<std::string> render_world(const WorldScene& world,
                                                      const std::vector<WorldPanel>& panels,
                                                      const std::filesystem::path& png,
                                                      const WorldPictureSettings& settings = {});

} // namespace maille::studies
