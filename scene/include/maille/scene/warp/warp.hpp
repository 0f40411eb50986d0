#pragma once
/// Images and labels carried along by bodies that have been deformed, the fields that other programs carry
/// them with, and the bodies' surfaces. docs/images.md says which program takes which file.
///
/// The *pull* field leads from where a voxel of the deformed image is to where its matter rests ("fixed to
/// moving", "resampling"); the *push* field from where matter rests to where it has gone ("modeling").

#include "maille/images/image.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace maille {

/// A body and where its nodes have gone. Both must outlive what is made of them.
struct DeformedBody {
  const Specimen* specimen = nullptr;         ///< of three dimensions
  const Displacement* displacement = nullptr; ///< on its grid
};

/// Where every voxel of an image's grid comes from.
struct Pull {
  static constexpr std::int32_t nothing = -1; ///< no matter is there
  static constexpr std::int32_t outside = -2; ///< the matter there rests outside of the image
  /// What holds on the way from the deformed image to the one at rest.
  ImageInfo grid; ///< one value a voxel
  /// From a voxel's middle to where its matter rests, in voxels along the image's axes: n_voxels x 3,
  /// component slowest; 0 where there is nothing.
  std::vector<float> shift;
  std::vector<std::int32_t> source; ///< the voxel that holds that place, nothing, or outside
  std::int64_t reached = 0;         ///< voxels with matter
  std::int64_t at_rest = 0;         ///< voxels that held matter before
  std::int64_t vacated = 0;         ///< of those, the ones that hold none now
  std::int64_t reached_twice = 0;   ///< voxels that several cells cover: folds, or bodies in each other
  std::int64_t folded_cells = 0;    ///< cells of matter that are turned inside out at a corner or more
};

/// Finds the place at rest of every voxel's middle that lies in a deformed cell, cell by cell.
///
/// Every cell covers few voxels and is inverted by itself (Newton's steps on its trilinear map, to 1e-8
/// voxels), so that bodies that touch, or labels that slide along each other, keep their voxels. Where cells
/// overlap, one that is not folded has the voxel, of several the first body's and the first. A face that goes
/// through a voxel's middle belongs to the first of its cells.
///
/// Frames  a body's world and the image's may be RAS and LPS; where one of them does not say, they are the
///         same
/// Cost    O(cells + voxels), about 0.2 and 0.02 us each; 16 bytes a voxel; same input, same bits
/// Source  Newton's method on the multilinear map of a hexahedron, as for isoparametric elements
/// @throws std::invalid_argument  bodies that are not of three dimensions, or 2^31 voxels and more
Pull pull_of(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// The image where its matter has gone: linear in its values at rest, whose indices end half a voxel
/// outside of the middles of the outermost. Every component for itself.
/// @param image on the grid of the pull @param background where there is no matter
Image warped(const Pull& pull, const Image& image, float background = 0);
/// The same of labels: of the voxel that holds the place at rest, never a mixture.
Image warped_labels(const Pull& pull, const Image& labels, float background = 0);

/// The pull field as other programs take it: displacement [mm] along the axes left, posterior, superior,
/// three components. Write it with write_image.
///
/// Voxels without matter go on as the nearest one with matter does (in steps along the axes), so that viewers
/// and resampling see no tear at the surface; where that would show matter a second time, the field leads out
/// of the image, where every program takes its background.
/// Cost  O(voxels)
Image pull_field(const Pull& pull, std::span<const DeformedBody> bodies);
/// The push field, likewise, of voxels' middles at rest; it goes on as the nearest matter does.
Image push_field(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// How much larger matter has become, det F: of every voxel of matter at rest the mean over its cell; 0
/// elsewhere. Cost  O(cells), about 0.5 us each
Image volume_ratio(const ImageInfo& grid, std::span<const DeformedBody> bodies);

/// What became of a label of an image.
struct WarpedLabel {
  std::int32_t label = 0;
  std::int64_t voxels = 0;      ///< at rest, of matter
  std::int64_t left_out = 0;    ///< at rest, of no body: background in warped_labels
  std::int64_t warped = 0;      ///< voxels that it has now
  std::int64_t folded = 0;      ///< cells with the label at their middle that are folded
  double volume_at_rest = 0;    ///< of its voxels of matter [m^3]
  double volume = 0;            ///< of the voxels that it has now, each whole or not at all [m^3]
  double sub_voxel_volume = 0;  ///< what it fills of every voxel now, from 64 points of each [m^3]
  double integral_of_det_f = 0; ///< over its voxels of matter [m^3]: its volume but for the voxels' size
  Vec3 centroid_at_rest{},
      centroid{}; ///< of its voxels of matter and of those that it has now, image's world [m]
};

/// A row a label other than 0, ascending. Cost  O(cells + voxels), and 10 us a voxel at borders of labels
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
