#pragma once
/// Pictures of several objects: each is cast separately, cached while unchanged, and merged by depth.

#include "maille/render/camera.hpp"
#include "maille/render/deformation.hpp"
#include "maille/render/volume.hpp"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace maille::render {

/// Position and orientation of an object's frame in the world: x_world = position + rotation x.
struct Pose {
  std::array<Vec3, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows
  Vec3 position{};                                                 ///< [m]
  friend bool operator==(const Pose&, const Pose&) = default;
  Vec3 to_world(const Vec3& point) const;
  Vec3 to_object(const Vec3& point) const;
};

/// A box in the object's frame, at rest; the outside is invisible.
struct CropBox {
  Vec3 low{}, high{};
  friend bool operator==(const CropBox&, const CropBox&) = default;
};

/// A visible object. Volumes, looks and paints are constant once they are here; a deformation may change and
/// then increases its version.
struct SceneObject {
  std::shared_ptr<const Volume> volume;
  std::shared_ptr<const Look> look;
  Pose pose;
  std::shared_ptr<const Deformation> deformation; ///< null: rigid
  std::shared_ptr<const Paint> paint;             ///< null: the look's own colours
  std::optional<CropBox> crop;
  bool hidden = false;
};

/// Rows from the top, x fastest.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::array<float, 4>> rgba; ///< premultiplied
  std::vector<float> depth;         ///< along the ray, where half of the light is absorbed [m]; or infinity
  std::vector<std::int32_t> object; ///< object at that depth; -1: background

  std::size_t pixel(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  /// Three bytes per pixel over a background.
  std::vector<std::uint8_t> rgb8(const Rgb& background = {1, 1, 1}) const;
  /// Four bytes per pixel, red first, into `out` (4 width height bytes): opaque, for windows.
  void rgba8(const Rgb& background, std::uint8_t* out) const;
};

/// Work of all renders, summed.
struct Counters {
  std::int64_t rays = 0;          ///< cast, one for each object and pixel
  std::int64_t rays_again = 0;    ///< of `rays`: cast sample by sample because objects interleave in depth
  std::int64_t objects = 0;       ///< cast
  std::int64_t pixels_merged = 0; ///< composited
};

/// Caches, for each object, runs of matter along each pixel's ray (depth, premultiplied colour) while its
/// pose, deformation, look and the view are unchanged.
///
/// Exact: pixels in which two objects interleave are cast again sample by sample, so that the picture equals
/// that of casting all objects together. The picture does not depend on earlier renders.
/// Order       objects are identified by their index in the list
/// Cost        an unchanged object costs nothing; a moved one its own rays and the merging of its pixels
/// Repeatable  same bits for any number of threads
/// Checked by  tests/render/
class Renderer {
public:
  explicit Renderer(int threads = 1);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// @throws std::invalid_argument for a picture of no pixels or more than 2^28, a camera without direction,
  ///         non-finite values, or a missing look or volume
  const Picture& render(std::span<const SceneObject> objects, const View& view);
  const Counters& counters() const;
  std::int64_t bytes() const;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The box of the visible part of an object, in the world; nothing if it is hidden. For a deformed object:
/// the box of its nodes.
std::optional<CropBox> bounds_of(const SceneObject& object);

} // namespace maille::render
