#pragma once
/// Warps images and labels by deformed bodies, and computes the displacement fields for other programs.
/// docs/images.md lists which program reads which file.
///
/// The *pull* field maps a voxel of the deformed image to the place of its matter at rest ("fixed to moving",
/// "resampling"); the *push* field maps matter at rest to its deformed place ("modeling").

#include "maille/images/image.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace maille {

/// A body and its displacement. Both must outlive objects that use them.
struct DeformedBody {
  const Specimen* specimen = nullptr;         ///< three-dimensional
  const Displacement* displacement = nullptr; ///< on its grid
};

/// For every voxel of an image's grid: the place at rest of its matter.
struct Pull {
  static constexpr std::int32_t nothing = -1; ///< no matter
  static constexpr std::int32_t outside = -2; ///< the matter rests outside the image
  /// Grid of both the deformed image and the one at rest.
  ImageInfo grid; ///< one value a voxel
  /// From a voxel's centre to the place of its matter at rest, in voxels along the image's axes: n_voxels x
  /// 3, component slowest; 0 without matter.
  std::vector<float> shift;
  std::vector<std::int32_t> source; ///< the voxel that contains that place, nothing, or outside
  std::int64_t reached = 0;         ///< voxels with matter
  std::int64_t at_rest = 0;         ///< voxels with matter at rest
  std::int64_t vacated = 0;         ///< those of them without matter now
  std::int64_t reached_twice = 0;   ///< voxels that several cells cover: folds, or overlapping bodies
  std::int64_t folded_cells = 0;    ///< cells of matter that are inverted at one or more corners
};

/// Finds the place at rest of every voxel centre inside a deformed cell, cell by cell.
///
/// Every cell covers few voxels and is inverted separately (Newton iteration on its trilinear map, to 1e-8
/// voxels), so that touching bodies and labels that slide along each other keep their voxels. If cells
/// overlap, a cell that is not folded takes the voxel; among several, the first cell of the first body. If a
/// face passes through a voxel centre, the first of its cells takes the voxel.
///
/// Frames  a body's world and the image's may be RAS and LPS; an unknown one is assumed to equal the other
/// Cost    O(cells + voxels), about 0.2 and 0.02 us each; 16 bytes per voxel; same input, same bits
/// Source  Newton's method on the multilinear map of a hexahedron, as for isoparametric elements
/// @throws std::invalid_argument  bodies that are not three-dimensional, or 2^31 voxels or more
Pull pull_of(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// The deformed image: linear interpolation of its values at rest, which extend half a voxel beyond the
/// outermost voxel centres. Each component separately.
/// @param image on the grid of the pull @param background value without matter
Image warped(const Pull& pull, const Image& image, float background = 0);
/// The same for labels: the label of the voxel that contains the place at rest, without interpolation.
Image warped_labels(const Pull& pull, const Image& labels, float background = 0);

/// The pull field in the form of other programs: displacement [mm] along the axes left, posterior, superior;
/// three components. Write it with write_image.
///
/// Voxels without matter take the value of the nearest voxel with matter (in steps along the axes), so that
/// viewers and resampling show no tear at the surface. If that would show matter twice, the field points
/// outside the image, where every program uses its background.
/// Cost  O(voxels)
Image pull_field(const Pull& pull, std::span<const DeformedBody> bodies);
/// The push field in the same form, at voxel centres at rest; voxels without matter take the value of the
/// nearest matter.
Image push_field(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// Volume ratio det F: for every voxel of matter at rest the mean over its cell; 0 elsewhere. Cost  O(cells),
/// about 0.5 us each
Image volume_ratio(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// Statistics of a label before and after the deformation.
struct WarpedLabel {
  std::int32_t label = 0;
  std::int64_t voxels = 0;             ///< at rest, of matter
  std::int64_t left_out = 0;           ///< at rest, in no body: background in warped_labels
  std::int64_t warped = 0;             ///< voxels after the deformation
  std::int64_t folded = 0;             ///< folded cells with the label at their centre
  double volume_at_rest = 0;           ///< of its voxels of matter [m^3]
  double volume = 0;                   ///< deformed, by whole voxels [m^3]
  double sub_voxel_volume = 0;         ///< deformed, sub-voxel: from 64 points per voxel [m^3]
  double integral_of_det_f = 0;        ///< over its voxels of matter [m^3]: volume without voxel rounding
  Vec3 centroid_at_rest{}, centroid{}; ///< of its voxels before and after, image's world [m]
};

/// One row per non-zero label, ascending. Cost  O(cells + voxels), and 10 us per voxel at borders of labels
/// @param labels at rest, whole numbers on the grid of the pull @param after warped_labels of them
/// @param ratio volume_ratio on the same grid
/// @throws std::invalid_argument  a label that is no whole number below 2^24 in size
std::vector<WarpedLabel> warped_label_table(const Pull& pull, std::span<const DeformedBody> bodies,
                                            const Image& labels, const Image& after, const Image& ratio);

/// The outer faces of the cells of one part, which are those to cells of other parts and to no matter.
struct BodySurface {
  std::string name;                     ///< of its label or material
  std::int32_t part = 0;                ///< its label, or the number of its material
  WorldAxes world = WorldAxes::unknown; ///< of the points
  std::vector<Vec3> points;             ///< in the world [m], each once
  std::vector<std::array<std::int32_t, 4>>
      quads; ///< of points, in an order that turns right-handed about outside
};

/// The parts of a body, a surface each, in the order of their numbers: of labels where it has some, else of
/// materials. Touching parts share faces, each with its own points.
/// @param materials of the scene, for names
/// Cost  O(cells)
/// @throws std::invalid_argument  a body that is not of three dimensions
std::vector<BodySurface> surfaces_of(const DeformedBody& body, const std::vector<Material>& materials);

enum class LengthUnit { metre, millimetre };

/// Writes what the ending of the name says; a quad as two triangles.
///
/// .stl  binary; one part, or several after each other
/// .ply  binary; `part` of every face: the label
/// .vtp  appended raw; cell data Part, field data Units and Name
/// A patient's world is written as LPS, which 3D Slicer and ITK expect, and the file says so (`SPACE=LPS`)
/// beside the unit; where the body's image does not state a world, places are as they are.
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  another ending
void write_surfaces(const std::vector<BodySurface>& surfaces, const std::filesystem::path& file,
                    LengthUnit unit);

} // namespace maille
