#pragma once
/// What all pictures are drawn with: a window that needs no screen, text, lights, the camera, the file.

#include "layout.hpp"

#include <vtkColorTransferFunction.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <memory>
#include <string>

namespace maille::studies {

inline constexpr Vec3 ink{0.10, 0.12, 0.16};
inline constexpr Vec3 quiet_ink{0.38, 0.40, 0.45};

/// @param x, @param y  [pixels] of the middle of the text's top
void add_text(vtkRenderer& renderer, const std::string& text, double x, double y, double size,
              const Vec3& colour, bool is_bold);

/// The world's axes, as a triad in the page's legend.
/// @param is_anatomical  letters R L, A P, S I at the ends in place of x, y, z at the positive ones
/// @param em  size of the text [pixels]
void add_triad(vtkRenderer& renderer, const View& view, const Scene& scene, bool is_anatomical,
               const Page& page, double em);

/// Moves an actor towards the viewer (or away, < 0): under a parallel view that changes only what hides what.
void bring_forward(vtkActor& actor, const View& view, double distance);

/// A bar of the colours from 0 to the scale's end with its numbers, and a line of text above it.
void add_legend(vtkRenderer& renderer, const Page& page, vtkColorTransferFunction& colours,
                const Scale& scale, const std::string& text);

/// A parallel view that fills a box of the page at the page's scale.
void aim(vtkRenderer& renderer, const View& view, const Page& page, const Box& box);

/// One light from over the viewer's left shoulder and a weaker one from below it, so that the front is not
/// dark.
void add_lights(vtkRenderer& renderer);

/// Writes what the window shows. @throws std::filesystem::filesystem_error, std::runtime_error
void save(vtkRenderWindow& window, const std::filesystem::path& png);

/// Owns a window and the OpenGL context behind it.
class OffscreenWindow {
public:
  /// @param why_not  filled if there is no way to draw on this machine
  /// @return null in that case
  static std::unique_ptr<OffscreenWindow> open(int width, int height, std::string& why_not);
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;
  ~OffscreenWindow();

  vtkRenderWindow& window() { return *window_; }

private:
  class EglContext;
  OffscreenWindow();
  bool open_with_egl(int width, int height, std::string& why_not);
  bool open_with_x(int width, int height, std::string& why_not);

  std::unique_ptr<EglContext> context_; ///< null with X; outlives the window, which frees its objects in it
  vtkSmartPointer<vtkRenderWindow> window_;
};

} // namespace maille::studies
