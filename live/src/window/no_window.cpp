/// Builds without SDL2 or Dear ImGui.

#include "maille/live/window.hpp"

#include <memory>
#include <stdexcept>

namespace maille::live {

bool has_windows() {
  return false;
}

std::unique_ptr<Window> open_window(const WindowSettings&) {
  throw std::runtime_error("this build has no windows: install libsdl2-dev and libimgui-dev and build again, "
                           "or give --headless with --script");
}

} // namespace maille::live
