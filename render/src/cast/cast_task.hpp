#pragma once
/// Data of an object and a view for the kernel, in single precision. Private to render.
///
/// Scheme: the picture is cut into tiles of 16 x 16 pixels, the unit of work of a thread; a tile into blocks
/// of as many pixels as the machine has lanes. The kernel (cast_kernel.cpp) casts one ray per lane and puts
/// what it finds into runs, which compose.hpp merges. Notation: t, distance along a ray [m]; codes, values of
/// voxels in 8 or 16 bits; bricks, blocks of voxels whose range of values is known, so that invisible ones
/// are skipped.

#include "maille/render/renderer.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::render {

/// A gapless part of one object along a ray.
struct Run {
  float begin = 0, end = 0;                    ///< along the ray [m]
  float half = 0;                              ///< depth at which half of its light is absorbed [m]
  std::array<float, 4> rgba{};                 ///< premultiplied
  float middle() const { return begin + end; } ///< times two; orders runs that do not overlap
};

/// Edge of the squares of pixels that are cast by one thread at a time.
inline constexpr int tile_edge = 16;
inline constexpr int tile_pixels = tile_edge * tile_edge;
/// Number of tiles along a number of pixels.
constexpr int tiles_along(int pixels) {
  return (pixels + tile_edge - 1) / tile_edge;
}

/// The runs of one object in one tile; those of pixel p are runs[first[p]] to runs[first[p + 1]], ordered by
/// depth. `first` is empty if the object is not in the tile.
struct TileRuns {
  std::vector<std::uint32_t> first;
  std::vector<Run> runs;

  bool empty() const { return runs.empty(); }
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(first.capacity() * sizeof(std::uint32_t) +
                                     runs.capacity() * sizeof(Run));
  }
};

using Float3 = std::array<float, 3>;

/// Points of rays as an affine function of the pixel's offset (across, up) from the centre of the picture and
/// of the distance t: a ray is origin + across o_right + up o_up + t scale (ahead + across right + up up),
/// where scale normalises the direction to world length.
struct RayFrame {
  Float3 origin{}, origin_right{}, origin_up{}; ///< the last two are 0 in perspective
  Float3 ahead{}, right{}, up{};                ///< the last two are 0 for parallel rays
};

/// Half-space offset + dot(normal, x) >= 0 that stays visible, as a function of the ray as in RayFrame.
struct RayPlane {
  float origin, origin_right, origin_up, ahead, right, up;
};

/// Transfer function of a look for one step: opacity and colour by code.
struct TransferTable {
  static constexpr int size = 4096;
  std::vector<float> alpha;                 ///< of a sample
  std::array<std::vector<float>, 3> colour; ///< not premultiplied
  std::vector<std::int32_t> visible_before; ///< number of entries before this one with alpha > 0; size + 1
};

/// Size of the table of specular light by the cosine between mirrored light and eye.
inline constexpr int gloss_size = 1024;

/// A stretch of a ray inside a deformed body.
struct Stretch {
  float begin, end;           ///< [m]
  std::array<float, 3> entry; ///< entry point, in cells of the lattice at rest
};

/// Faces of cells are cut along a diagonal for rays to enter, so points may be outside the lattice by this
/// much [cells].
inline constexpr float lattice_slack = 0.5f;

/// The stretches of a tile's pixels; those of pixel p from first[p] to first[p + 1], in order.
struct TileStretches {
  std::vector<std::uint32_t> first;
  std::vector<Stretch> stretches;
};

struct CastTask {
  // ---- rays ----
  float pixel_scale = 0;            ///< half of the picture's height is 1
  float middle_x = 0, middle_y = 0; ///< [pixels]
  bool parallel = false;
  RayFrame voxels; ///< in voxel coordinates (rigid)
  RayFrame object; ///< in the object's frame [m] (deformed)
  std::vector<RayPlane> clips;
  float step = 0;                      ///< [m]
  float cue_offset = 1, cue_slope = 0; ///< colours times offset + slope t, clamped to 0 ... 1

  // ---- values ----
  const std::uint8_t* codes8 = nullptr;
  const std::uint16_t* codes16 = nullptr;
  const std::int8_t* gradients = nullptr;
  std::array<std::int32_t, 3> size{}, stride{};
  float table_scale = 0; ///< table entries per code
  float isocode = 0;
  LookMode mode = LookMode::composite;

  // ---- colours ----
  const float* alpha = nullptr;
  std::int32_t last_unseen = -1; ///< no entry up to this one has alpha > 0
  std::array<const float*, 3> colour{};
  float surface_alpha = 1; ///< of isosurfaces
  const std::uint8_t* paint_numbers = nullptr;
  const std::uint32_t* paint_pixels = nullptr;
  const std::uint32_t* palette = nullptr;
  bool paint_is_field = false;
  bool paint_keeps_own = false; ///< keep the look's colours for Paint::own_colour and outside the paint
  std::array<std::int32_t, 3> paint_size{}, paint_stride{};
  std::array<Float3, 3> paint_rows{}; ///< voxel coordinates -> the paint's
  Float3 paint_offset{};

  // ---- light ----
  bool shaded = false;
  float ambient = 1, diffuse = 0;
  const float* gloss = nullptr; ///< mirrored part by cosine
  Float3 light{}, eye{};        ///< unit vectors in the gradients' axes (rigid) or the object's (deformed)
  float light_eye = 1;          ///< their scalar product
  float cut_scale = 0;          ///< 1 / distance behind a cut where light starts; full at twice that distance

  // ---- skipping (rigid) ----
  const std::uint8_t* brick_distance = nullptr;
  std::array<std::int32_t, 3> brick_stride{};

  // ---- deformed ----
  const float* nodes = nullptr; ///< four numbers each
  std::array<std::int32_t, 3> cells{};
  std::array<std::int32_t, 3> node_stride{};
  std::array<Float3, 3> voxel_rows{}; ///< lattice coordinates -> voxel coordinates
  Float3 voxel_offset{};
  bool leaves_voxels = false;            ///< the lattice extends beyond the outermost voxels
  std::array<Float3, 3> gradient_rows{}; ///< gradients' axes -> the lattice's, times spacings
  bool has_crop = false;
  Float3 crop_low{}, crop_high{}; ///< in cells of the lattice
};

/// Largest number of pixels that are cast at once: one per lane.
inline constexpr int most_lanes = 16;
struct PixelBlock {
  int n = 0;
  std::array<std::int32_t, most_lanes> x{}, y{};  ///< of the picture
  std::array<std::int32_t, most_lanes> in_tile{}; ///< number in its tile
  /// For rigid objects: range of depths along the line of sight with visible samples [m].
  std::array<float, most_lanes> nearest{}, farthest{};
};

/// Runs in the order in which they are found, for any pixels.
struct RunSink {
  std::vector<std::pair<std::int32_t, Run>> runs; ///< of the pixel in the tile
  void clear() { runs.clear(); }
  /// Sorts them by pixel; runs of one pixel keep their order.
  void take(TileRuns& tile);
};

/// Number of pixels per block on this machine.
int lanes_of_cast();
/// @param one_by_one every visible sample becomes a separate run
/// @param stretches  of the tile; null for rigid objects
void cast_blocks(const CastTask& task, std::span<const PixelBlock> blocks, const TileStretches* stretches,
                 bool one_by_one, RunSink& sink);

/// Transfer function of a look for a volume, for samples `step` apart [m].
TransferTable transfer_table(const Look& look, const Volume& volume, double step);
std::vector<float> gloss_table(const Shading& shading);
/// Distance of each brick from the nearest one with something visible, in bricks (Chebyshev), at most 255.
std::vector<std::uint8_t> brick_distances(const Volume& volume, const TransferTable& table, const Look& look);
/// True if some code in a range may be visible.
bool is_visible(const Volume::Range& range, const TransferTable& table, const Look& look,
                const Volume& volume);
/// True if all codes are visible; always false for an isosurface.
bool is_all_visible(const Volume::Range& range, const TransferTable& table, const Look& look,
                    const Volume& volume);

} // namespace maille::render
