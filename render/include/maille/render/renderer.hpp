#pragma once
/// Pictures of several objects: each cast by itself, kept while it does not change, merged by depth.

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

/// Where an object's frame is in the world: x_world = position + rotation x.
struct Pose {
  std::array<Vec3, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows
  Vec3 position{};                                                 ///< [m]
  friend bool operator==(const Pose&, const Pose&) = default;
  Vec3 to_world(const Vec3& point) const;
  Vec3 to_object(const Vec3& point) const;
};

/// A box in the object's frame, at rest; nothing outside it is seen.
struct CropBox {
  Vec3 low{}, high{};
  friend bool operator==(const CropBox&, const CropBox&) = default;
};

/// What is to be seen. Volumes, looks and paints do not change once they are here; a deformation may, and
/// says so by its version.
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
  std::vector<float> depth;         ///< along the ray, where half of the light is spent [m]; or infinity
  std::vector<std::int32_t> object; ///< whose surface that is; -1: background

  std::size_t pixel(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  /// Three bytes a pixel over a background.
  std::vector<std::uint8_t> rgb8(const Rgb& background = {1, 1, 1}) const;
  /// Four bytes a pixel, red first, into `out` (4 width height bytes): opaque, for windows.
  void rgba8(const Rgb& background, std::uint8_t* out) const;
};

/// What renders did, all together.
struct Counters {
  std::int64_t rays = 0;          ///< cast, one for each object and pixel
  std::int64_t rays_again = 0;    ///< of `rays`: cast sample by sample where objects interleave in depth
  std::int64_t objects = 0;       ///< cast
  std::int64_t pixels_merged = 0; ///< composited
};

/// Keeps, for each object, runs of matter along each pixel's ray (depth, premultiplied colour) while its
/// pose, deformation, look and the view stay the same.
///
/// Exact: pixels in which two objects interleave are cast again sample by sample, so that a picture is the
/// one that all objects cast at once give. What is seen does not depend on what was rendered before.
/// Order       objects are known by their place in the list
/// Cost        a still object costs nothing; a moved one its own rays and the merging of its pixels
/// Repeatable  same bits for any number of threads
/// Checked by  tests/render/
class Renderer {
public:
  explicit Renderer(int threads = 1);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// @throws std::invalid_argument for a picture of no pixels or more than 2^28, a camera that looks nowhere,
  ///         what is not finite, or a look or a volume that is missing
  const Picture& render(std::span<const SceneObject> objects, const View& view);
  const Counters& counters() const;
  std::int64_t bytes() const;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The box of what may be seen of an object, in the world; nothing where it is hidden. Of deformed ones that
/// of their nodes.
std::optional<CropBox> bounds_of(const SceneObject& object);

} // namespace maille::render
