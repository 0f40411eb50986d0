#pragma once
/// The faces between visible cells and the rest, where rays enter and leave a deformed body. Private to
/// render.

#include "cast/cast_task.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::render {

/// A face of a cell on the border of the visible cells.
struct SurfaceFace {
  Index3 cell{};
  std::uint8_t axis = 0;
  std::uint8_t upper = 0; ///< which of the two faces along `axis`
  std::array<std::uint32_t, 4>
      corners{}; ///< numbers in Surface::nodes, counterclockwise as seen from outside
};

struct Surface {
  std::vector<SurfaceFace> faces;
  std::vector<std::int64_t> nodes; ///< of the lattice: nodes of faces, unique, ascending
  std::int64_t bytes() const;
};

/// The border faces of the cells with something visible.
Surface surface_of(const Lattice& lattice, const Volume& volume, const Look& look, const TransferTable& table,
                   int threads);

/// Finds the stretches of rays inside a deformed body, tile by tile.
///
/// Each face is cut into two triangles along a diagonal; a pixel is inside between a triangle that faces the
/// eye and one that faces away, counted, so that bodies may have any shape, even folded. Triangles with a
/// common edge leave no gap and cover no pixel twice (vertices snapped to 2^-16 pixels, upper-left rule).
class SurfaceEvents {
public:
  /// @param view of the picture; @param pose of the object
  SurfaceEvents(const Deformation& deformation, const Surface& surface, const Pose& pose, const View& view,
                int threads);

  int tiles_x() const { return tiles_x_; }
  int tiles_y() const { return tiles_y_; }
  bool is_in_tile(int tile) const { return from_[tile] < from_[static_cast<std::size_t>(tile) + 1]; }
  /// The stretches of the pixels of a tile.
  void stretches(int tile, TileStretches& out) const;

private:
  struct Corner {
    double x, y, z;           ///< in the camera's axes, z ahead [m]
    std::int32_t column, row; ///< in the picture [2^-16 pixels]; far_off: out of range
  };
  /// Rays of a tile's pixels, in the camera's axes: across and up at z = 1 (perspective) or constant [m]
  /// (parallel).
  struct TileRays {
    int x = 0, y = 0; ///< the tile's first pixel
    std::array<double, tile_edge> across{}, up{};
    std::array<double, tile_pixels> length{}; ///< along the ray where z is 1
  };
  using Triangle = std::array<const Corner*, 3>;
  using Entry = std::array<float, 3>; ///< centre of a face, in cells of the lattice
  struct Covering;
  class Events;
  TileRays rays_of(int tile) const;
  Corner corner(const std::array<float, 4>& node) const;
  /// Column and row [pixels] of a point ahead of the eye.
  std::array<double, 2> in_picture(const Vec3& at) const;
  /// Rows and columns of tiles that a face may cover; false if there are none.
  bool tiles_of(const SurfaceFace& face, std::array<int, 4>& range) const;
  /// The same for a face that is too near to the eye, or extends far beyond the picture.
  bool tiles_of_far_face(const SurfaceFace& face, std::array<int, 4>& range) const;
  void add_face(const TileRays& tile, const SurfaceFace& face, Events& events) const;
  /// Rasterises at most two triangles, with corners snapped to fractions of pixels.
  void rasterise(const TileRays& tile, std::span<const Triangle> triangles, const Entry& entry,
                 Events& events) const;
  void cast_at(const TileRays& tile, const Triangle& triangle, const Entry& entry, Events& events) const;

  const Deformation& deformation_;
  const Surface& surface_;
  std::array<Vec3, 3> to_camera_{};
  Vec3 camera_offset_{};
  int width_, height_, tiles_x_, tiles_y_;
  bool parallel_;
  double scale_;                ///< pixels per metre (parallel) or per unit of slope
  std::vector<Corner> corners_; ///< of the surface's nodes
  std::vector<std::uint32_t> from_, in_tile_;
};

} // namespace maille::render
