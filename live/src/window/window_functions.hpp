#pragma once
/// The functions that maille-window.so exports.

#include "maille/live/window.hpp"
#include "maille/plugins/open_plugin.hpp"

namespace maille::live {

struct WindowFunctions {
  std::unique_ptr<Window> (*open)(const WindowSettings& settings);
};

inline constexpr std::size_t window_layout =
    layout_of<WindowFunctions, WindowSettings, Event, Widget, OverlayLine, OverlayText, Shown>();

} // namespace maille::live
