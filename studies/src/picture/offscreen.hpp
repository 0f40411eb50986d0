#pragma once
/// A render window that needs no screen.

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <string>

namespace maille::studies {

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
