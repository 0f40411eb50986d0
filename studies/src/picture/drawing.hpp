#pragma once
/// Drawing tools of all pictures: offscreen window, text, lights, camera, file.

#include "layout.hpp"

#include <vtkActor.h>
#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkProp.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

inline constexpr Vec3 ink{0.10, 0.12, 0.16};
inline constexpr Vec3 quiet_ink{0.38, 0.40, 0.45};

/// @param x, @param y  top centre of the text [pixels]
void add_text(vtkRenderer& renderer, const std::string& text, double x, double y, double size,
              const Vec3& colour, bool is_bold);

/// Adds a triad of the world's axes to the page's legend.
/// @param is_anatomical  letters R L, A P, S I at both ends, in place of x, y, z at the positive ends
/// @param em  text size [pixels]
void add_triad(vtkRenderer& renderer, const View& view, const Scene& scene, bool is_anatomical,
               const Page& page, double em);

/// A filled box of the page.
void add_rectangle(vtkRenderer& renderer, const Box& box, const Vec3& colour);

/// Adds a colour bar from 0 to the scale's end with its numbers, and a line of text above it.
void add_legend(vtkRenderer& renderer, const Page& page, vtkColorTransferFunction& colours,
                const Scale& scale, const std::string& text);

/// Moves an actor towards the viewer (< 0: away): in a parallel view this changes only the occlusion.
void bring_forward(vtkActor& actor, const View& view, double distance);

using Props = std::vector<vtkSmartPointer<vtkProp>>;
/// Corners of a polygon, or the ends of a line.
using Shape = std::vector<Vec3>;
vtkSmartPointer<vtkPolyData> data_of(const std::vector<Shape>& shapes, bool are_lines = false);
/// A disc that faces the viewer.
Shape disc(const Vec3& at, double radius, const View& view);

/// How much of its colour a surface shows whatever the light, and how much of it with the light.
struct Shading {
  double ambient, diffuse;
};
/// A surface in its own colours, faces flat.
vtkSmartPointer<vtkActor> surface_actor(vtkPolyData* surface, const Shading& shading);
/// A shape in one colour whatever the light.
vtkSmartPointer<vtkActor> flat_actor(vtkPolyData* shape, const Vec3& colour, double opacity = 1);
/// The edges of a surface, in front of it: of every cell, or its sharp ones alone.
/// @param line_width [pixels]
vtkSmartPointer<vtkActor> edge_actor(vtkPolyData* surface, bool of_every_cell, double opacity,
                                     double line_width, const View& view, double pixels_per_metre);

/// Writes what the window shows. @throws std::filesystem::filesystem_error, std::runtime_error
void save(vtkRenderWindow& window, const std::filesystem::path& png);

/// Owns a window and the OpenGL context behind it.
class OffscreenWindow {
public:
  /// @param why_not  filled if there is no way to draw on this machine
  /// @return null on failure
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

  std::unique_ptr<EglContext> context_; ///< null with X; must outlive the window, whose destructor uses it
  vtkSmartPointer<vtkRenderWindow> window_;
};

/// A page that is being drawn: text on white paper, and over it each panel's drawing in one view.
class Sheet {
public:
  /// @param why_not  filled if there is no way to draw on this machine @return null in that case
  /// @pre page and view outlive it
  static std::unique_ptr<Sheet> open(const Page& page, const View& view, std::string& why_not);

  vtkRenderer& paper() { return *paper_; }
  /// Above all; none if empty.
  void add_title(const std::string& title);
  /// @param lines_down, @param size  in heights of the page's text
  void write_under(std::size_t panel, const std::string& text, const Vec3& colour, bool is_bold,
                   double lines_down = 0, double size = 1);
  /// @param background  of the panel; nothing: the paper
  void draw(std::size_t panel, const Props& props, const std::optional<Vec3>& background = {});
  /// @throws std::filesystem::filesystem_error, std::runtime_error
  void save(const std::filesystem::path& png);

private:
  Sheet(std::unique_ptr<OffscreenWindow> window, const Page& page, const View& view);

  std::unique_ptr<OffscreenWindow> window_; ///< outlives what is drawn in it
  const Page& page_;
  const View& view_;
  vtkNew<vtkRenderer> paper_;
};

} // namespace maille::studies
