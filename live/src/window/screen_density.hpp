#pragma once
/// How large letters are wanted.

namespace maille::live {

/// Dots an inch that an X server's resources ask for (`Xft.dpi`, what desktops set for their letters).
/// @return 0 where there is no X server, or it asks for nothing
double dots_by_resources();

/// Scale of the letters for a screen's dots per inch: in quarters, 1 to 3.
float text_scale_of(double dots);

} // namespace maille::live
