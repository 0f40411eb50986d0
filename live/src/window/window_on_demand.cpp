/// Windows for a program that starts without SDL2: the first one opens the plugin maille-window.so, which
/// builds with libsdl2-dev and libimgui-dev include.

#include "maille/plugins/open_plugin.hpp"
#include "window/window_functions.hpp"

#include <stdexcept>

namespace maille::live {

constexpr const char* plugin = "maille-window.so";

bool has_windows() {
  return has_plugin(plugin);
}

std::unique_ptr<Window> open_window(const WindowSettings& settings) {
  if (!has_windows())
    throw std::runtime_error(
        "this build has no windows: install libsdl2-dev and libimgui-dev and build again, "
        "or give --headless with --script");
  static const auto* const functions =
      static_cast<const WindowFunctions*>(open_plugin(plugin, "a window (SDL2)", window_layout));
  return functions->open(settings);
}

} // namespace maille::live
