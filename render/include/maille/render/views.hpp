#pragma once
/// Pairs of pictures for two eyes, and rings of views that are cast beforehand.

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

/// Pictures from all around a focal point. What does not move is cast once for each view; a tool that moves
/// is cast anew and merged by depth: Gibson 1995, figure 4.
class RingOfViews {
public:
  /// @param n_views equally spaced in azimuth, > 0
  RingOfViews(const View& first, int n_views, int threads = 1);

  int n_views() const { return static_cast<int>(renderers_.size()); }
  const View& view(int which) const { return views_[which]; }
  /// Casts all views beforehand.
  void prepare(std::span<const SceneObject> objects);
  const Picture& render(int which, std::span<const SceneObject> objects);
  Counters counters() const;
  std::int64_t bytes() const;

private:
  std::vector<View> views_;
  std::vector<Renderer> renderers_;
};

} // namespace maille::render
