#pragma once
/// What all pictures are drawn with: text, lights, the camera, the file.

#include "layout.hpp"

#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <filesystem>
#include <string>

namespace maille::studies {

inline constexpr Vec3 ink{0.10, 0.12, 0.16};
inline constexpr Vec3 quiet_ink{0.38, 0.40, 0.45};

/// @param x, @param y  [pixels] of the middle of the text's top
void add_text(vtkRenderer& renderer, const std::string& text, double x, double y, double size,
              const Vec3& colour, bool is_bold);

/// The world's axes, as a triad.
/// @param x, @param y, @param length  of its middle and its arms [pixels] @param is_anatomical  letters R L,
/// A P, S I at the ends in place of x, y, z at the positive ones
void add_triad(vtkRenderer& renderer, const View& view, const Placement& placement, int dimension,
               bool is_anatomical, double x, double y, double length, double text_size);

/// A parallel view that fills a box of the page at the page's scale.
void aim(vtkRenderer& renderer, const View& view, const Page& page, const Box& box);

/// One light from over the viewer's left shoulder and a weaker one from below it, so that the front is not
/// dark.
void add_lights(vtkRenderer& renderer);

/// Writes what the window shows. @throws std::filesystem::filesystem_error, std::runtime_error
void save(vtkRenderWindow& window, const std::filesystem::path& png);

} // namespace maille::studies
