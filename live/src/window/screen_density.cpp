#include "window/screen_density.hpp"

#include <algorithm>
#include <cmath>

#ifdef MAILLE_X11
#include <X11/Xlib.h>
#endif

namespace maille::live {

double dots_by_resources() {
#ifdef MAILLE_X11
  Display* const display = XOpenDisplay(nullptr);
  if (display == nullptr)
    return 0;
  const char* const asked = XGetDefault(display, "Xft", "dpi");
  const double dots = asked != nullptr ? std::atof(asked) : 0;
  XCloseDisplay(display);
  return std::isfinite(dots) ? std::max(0.0, dots) : 0;
#else
  return 0;
#endif
}

float text_scale_of(double dots) {
  constexpr double usual = 96;
  return static_cast<float>(std::clamp(std::round(4 * dots / usual) / 4, 1.0, 3.0));
}

} // namespace maille::live
