#pragma once
/// Stereo pairs of pictures, and rings of views that are cast in advance.

#include "maille/render/renderer.hpp"

namespace maille::render {

/// Settings of a stereo pair.
struct StereoSettings {
  double separation = 0; ///< of the eyes [m]; 0: a thirtieth of the distance to the focal point
};

/// The views of the left and the right eye: both look at the plane of the focal point from shifted positions
/// ("toed in", as ParaView's stereo pairs).
std::array<View, 2> stereo_views(const View& view, const StereoSettings& settings = {});
/// One picture beside the other.
Picture side_by_side(const Picture& left, const Picture& right);
/// For red (left) and cyan (right) glasses: each eye gets the brightness of its picture over a background.
Picture anaglyph(const Picture& left, const Picture& right, const Rgb& background = {1, 1, 1});

/// Two renderers, one per eye, each with its own cache.
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
