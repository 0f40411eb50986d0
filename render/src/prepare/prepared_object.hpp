#pragma once
/// One object prepared for a view: tables, rays, possible tiles. Private to render.
///
/// Scheme: a rigid object's rays are moved into its voxel coordinates, once per pose, as affine functions of
/// the pixel (RayFrame); BrickDepths bounds where they may meet something visible. A deformed object is cast
/// in its own frame: SurfaceEvents finds the stretches of rays inside the body, and the kernel follows them
/// from cell to cell of the lattice. Tables depend only on volume, look and step, and outlive a view.

#include "bodies/brick_depths.hpp"
#include "bodies/surface.hpp"
#include "cast/cast_task.hpp"

#include <memory>
#include <optional>

namespace maille::render {

/// Pixels from (x0, y0) to (x1, y1), exclusive.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

class PreparedObject {
public:
  /// Reuses tables that do not depend on pose and camera from `before`, if volume and look are the same.
  PreparedObject(const SceneObject& object, const View& view, int threads, const PreparedObject* before);

  const PixelBox& box() const { return box_; }
  /// Casts the pixels of a tile. @return number of rays
  std::int64_t cast(int tile, RunSink& sink) const;
  /// Casts some pixels of a tile sample by sample.
  std::int64_t cast_one_by_one(int tile, std::span<const std::int32_t> in_tile, RunSink& sink) const;
  std::int64_t bytes() const;

private:
  /// Tables that depend only on volume, look and step.
  struct Tables {
    TransferTable transfer;
    std::vector<float> gloss;
    std::vector<std::uint8_t> distances; ///< of bricks; rigid objects only
    std::vector<SeenBox> boxes;          ///< likewise
    CropBox visible;                     ///< bounds of the visible bricks, in voxels
    bool is_empty = true;
    Surface surface; ///< of deformed objects
  };
  static std::shared_ptr<const Tables> make_tables(const SceneObject& object, double step, int threads);
  void set_values();
  void set_rays(const View& view);
  void set_light(const View& view);
  void set_paint();
  void set_lattice();
  PixelBox box_on(const View& view) const;
  std::int64_t cast_pixels(int tile, std::span<const std::int32_t> in_tile, const TileStretches* stretches,
                           bool one_by_one, RunSink& sink) const;

  SceneObject object_;
  View view_;
  double step_;
  int tiles_x_;
  std::shared_ptr<const Tables> tables_;
  CastTask task_;
  std::optional<SurfaceEvents> events_; ///< of deformed objects
  std::optional<BrickDepths> depths_;   ///< of rigid ones
  PixelBox box_;
};

} // namespace maille::render
