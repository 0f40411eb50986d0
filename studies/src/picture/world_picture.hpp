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

/// @brief Draws moments of a world side by side into a PNG file, all from the same place: what is seen is the
///        whole world.
///
/// Fixed objects are grey, the others each of a colour of its own; cells of deformable objects show their
/// edges; cells of several materials differ in shade, and where there are many of them, as in pieces of a
/// picture, colours show which. Dots mark where objects touch. Three-dimensional worlds are seen from the
/// front, a little from above and the right, z upwards; lines are drawn as bands.
///
/// Drawing needs what render_comparison needs; widths and heights are even numbers, as films want them.
/// @return nothing, or why no picture could be made on this machine
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written
/// @pre not called from two threads at once
[[nodiscard]] std::optional<std::string> render_world(const WorldScene& world,
                                                      const std::vector<WorldPanel>& panels,
                                                      const std::filesystem::path& png,
                                                      const WorldPictureSettings& settings = {});

} // namespace maille::studies
