#pragma once
/// The voxels of an object for ray casting: compact values and gradients, and paint on them.

#include "maille/scene/answer.hpp"
#include "maille/scene/look.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace maille::render {

/// A regular grid of voxels in an object's frame: the centre of voxel (i, j, k) is
/// origin + direction (spacing .* (i, j, k)).
struct VoxelGrid {
  Index3 size{1, 1, 1};
  Vec3 spacing{1, 1, 1};                                            ///< [m]
  Vec3 origin{};                                                    ///< of the centre of voxel 0 [m]
  std::array<Vec3, 3> direction{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of an orthonormal matrix
  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
  /// Voxel coordinates of a point of the object's frame: whole numbers at centres.
  Vec3 index_of(const Vec3& point) const;
  Vec3 point_of(const Vec3& index) const;
};

/// Values of 8 or 16 bits, gradients of 3 x 8 bits, and the least and largest value of every brick of 4^3.
///
/// Values are trilinear between voxel centres; the volume ends at the outermost centres.
/// Memory  5 bytes per voxel with 16 bits and gradients, 4 with 8 bits, plus bricks
class Volume {
public:
  enum class Depth { bits8, bits16 };

  /// @param values n_voxels numbers, x fastest; NaN counts as `low`
  /// @param low, high values of the smallest and the largest code; values beyond are clipped
  /// @param with_gradients for shading: central differences of the values, smoothed by a Gaussian of one
  /// voxel
  Volume(const VoxelGrid& grid, std::span<const float> values, double low, double high,
         Depth depth = Depth::bits16, bool with_gradients = true);

  const VoxelGrid& grid() const { return grid_; }
  Depth depth() const { return depth_; }
  double low() const { return low_; }
  double high() const { return high_; }
  bool has_gradients() const { return !gradients_.empty(); }
  /// Stored value of a voxel.
  double value(std::int64_t voxel) const;
  /// Direction of increasing values, along the grid's axes, of length 0 (flat) to 1 (steep).
  Vec3 gradient(std::int64_t voxel) const;
  /// Trilinear value in double precision of the stored values; `low` outside. @param index see
  /// VoxelGrid::index_of
  double value_at(const Vec3& index) const;
  std::int64_t bytes() const;

  // ---- for the kernels ----
  int largest_code() const { return depth_ == Depth::bits8 ? 255 : 65535; }
  int code(std::int64_t voxel) const;
  const std::uint8_t* codes8() const { return codes8_.data(); }
  const std::uint16_t* codes16() const { return codes16_.data(); }
  const std::int8_t* gradients() const { return gradients_.data(); }
  /// A brick covers 4 intervals between centres per axis: brick b the voxels 4 b to 4 b + 4, inclusive.
  static constexpr int brick_shift = 2, brick_edge = 1 << brick_shift;
  const Index3& bricks() const { return bricks_; }
  struct Range {
    std::uint16_t least, largest;
  };
  const std::vector<Range>& brick_ranges() const { return ranges_; }
  /// Least and largest code of the voxels in a box of voxel indices, both ends inclusive and clipped.
  Range range_of(const Index3& first, const Index3& last) const;

private:
  void fill_gradients(std::span<const float> values);
  void fill_bricks();

  VoxelGrid grid_;
  double low_, high_;
  Depth depth_;
  std::vector<std::uint8_t> codes8_;
  std::vector<std::uint16_t> codes16_;
  std::vector<std::int8_t> gradients_;
  Index3 bricks_{};
  std::vector<Range> ranges_;
};

/// Matter of a body as values from 0 to 1, smooth enough for lighting and 1/2 at the surface: for bodies
/// without grey values. One voxel per cell plus a margin. 8 bits.
std::shared_ptr<const Volume> volume_of_matter(const Specimen& body);
/// The grey values of a look, in the body's frame; volume_of_matter for a look without an image.
std::shared_ptr<const Volume> volume_of(const Seen& seen, const Specimen& body,
                                        Volume::Depth depth = Volume::Depth::bits16);

/// Colours that replace those of a look: a number per voxel of a separate grid, and a colour per number. One
/// byte per voxel, or four for pictures.
class Paint {
public:
  enum class Kind {
    labels, ///< the colour of the nearest voxel's number
    field,  ///< numbers interpolated, then coloured
    picture ///< the nearest voxel's own colour
  };
  static constexpr std::uint8_t own_colour = 255;
  /// @param numbers of voxels; @param colours of each number
  /// @param keeps_own  true: voxels of number `own_colour`, and outside the grid, keep the look's colours
  static std::shared_ptr<const Paint> labels(const VoxelGrid& grid, std::vector<std::uint8_t> numbers,
                                             const std::array<Rgb, 256>& colours, bool keeps_own = false);
  /// Maps values from `low` to `high` to a list of equally spaced colours.
  static std::shared_ptr<const Paint> field(const VoxelGrid& grid, std::span<const float> values, double low,
                                            double high, std::span<const Rgb> colours);
  /// @param rgb three bytes per voxel
  static std::shared_ptr<const Paint> picture(const VoxelGrid& grid, std::span<const std::uint8_t> rgb);

  const VoxelGrid& grid() const { return grid_; }
  Kind kind() const { return kind_; }
  bool keeps_own() const { return keeps_own_; }
  std::int64_t bytes() const;

  // ---- for the kernels ----
  const std::uint8_t* numbers() const { return numbers_.data(); }
  const std::uint32_t* pixels() const { return pixels_.data(); }   ///< 0xbbggrr
  const std::uint32_t* palette() const { return palette_.data(); } ///< 256, likewise

private:
  Paint(const VoxelGrid& grid, Kind kind) : grid_(grid), kind_(kind) {}
  VoxelGrid grid_;
  Kind kind_;
  bool keeps_own_ = false;
  std::vector<std::uint8_t> numbers_;
  std::vector<std::uint32_t> pixels_, palette_;
};

/// Colours similar to `viridis` for fields: 0 dark to 1 bright, perceptually uniform.
std::vector<Rgb> field_colours();

/// A voxel for each cell of a body's box.
VoxelGrid cells_as_voxels(const Specimen& body);
/// Paint by a number a cell, in field_colours() from `low` to `high`. Cells without matter take the mean of
/// their neighbours with it, so that colours go on to the surface.
std::shared_ptr<const Paint> paint_of_cells(const Specimen& body, std::vector<float> values, double low,
                                            double high);

} // namespace maille::render
