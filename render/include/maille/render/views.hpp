#pragma once
/// Pairs of pictures for two eyes, and rings of views.

#include "maille/render/renderer.hpp"

namespace maille::render {

/// Two eyes beside each other.
struct StereoSettings {
  double separation = 0; ///< of the eyes [m]; 0: a thirtieth of the distance to the focal point
};

/// The views of the left and the right eye: both look at the focal point's plane with shifted positions
/// ("toed in", as ParaView's stereo pairs are).
std::array<View, 2> stereo_views(const View& view, const StereoSettings& settings = {});
/// One picture beside the other.
Picture side_by_side(const Picture& left, const Picture& right);
/// For glasses of red (left) and cyan (right): each eye gets the brightness of its picture over a background.
Picture anaglyph(const Picture& left, const Picture& right, const Rgb& background = {1, 1, 1});

/// Two renderers, each of which keeps what its eye sees.
class StereoRenderer {
public:
  explicit StereoRenderer(int threads = 1) : eyes_{Renderer(threads), Renderer(threads)} {}
  /// @return the left and the right picture
  std::array<const Picture*, 2> render(std::span<const SceneObject> objects, const View& view,
                                       const StereoSettings& settings = {});
  const Renderer& eye(std::size_t which) const { return eyes_[which]; }
  Renderer& eye(std::size_t which) { return eyes_[which]; }

private:
  std::array<Renderer, 2> eyes_;
};

/// View `which` of a ring around the focal point, equally spaced in azimuth; 0 is the first itself.
/// @pre n_views > 0
View view_of_ring(const View& first, int which, int n_views);

} // namespace maille::render
