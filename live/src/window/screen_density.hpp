#pragma once
/// Text size from the density of the screen.

namespace maille::live {

/// Dots per inch from an X server's resources (`Xft.dpi`, which desktops set for their text). @return 0
/// without an X server or without that resource
double dots_by_resources();

/// Text scale for a screen's dots per inch: multiples of 1/4, 1 to 3.
float text_scale_of(double dots);

} // namespace maille::live
