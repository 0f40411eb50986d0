#pragma once
/// Volume fractions: the share of tissue in every voxel and cell that a body's surface cuts.
///
/// Shares come from labels (0 or 1), from grey values (linear between two), or from a smoothed segmentation:
/// with G the Gaussian mean, the surface is a level of 2 G f - G G f, which removes the shrinkage of plain
/// smoothing up to the fourth power of the width. Each material has the level, near 1/2, at which it keeps
/// the volume of its voxels, in these and in the voxels that the level 1/2 cuts. A voxel's share is sampled
/// at 4 x 4 x 4 points, a cell's is the mean of its voxels'. Cells below `least` are removed; of a smoothed
/// material the others share out what they had.
///
/// Images stream layer by layer, so memory is a few layers. Exact: shares of labels, volumes of smoothed
/// ones. Approximate: the smooth surface.

#include "voxels/label_cells.hpp"

namespace maille::reader {

/// 1 in voxels of the ranges, 0 elsewhere.
LayerWindow shares_of_labels(LayerWindow image, const std::vector<LabelRange>& ranges);
/// Linear between two grey values, cut off beyond them; not a number where they are not finite.
LayerWindow shares_of_grey(LayerWindow image, double none, double full);
/// The part of each voxel within the smooth surface that a segmentation stands for, found at 4 x 4 x 4 points
/// of a voxel between which 2 G f - G G f is linear. A point is of its voxel's material or of the nearest
/// one.
/// @param image with voids_around() of void on all sides: values go on beyond the border
/// @param ranges must outlive the window
/// @param width  standard deviation of the Gaussian [m], > 0
/// Cost  some 20 ns a voxel and voxel of width; at most some 24 layers of float32 a voxel of width
LayerWindow shares_of_smoothed(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                               double width);
/// How many voxels of void it takes around an image so that its border plays no part, in whole cells; none
/// across a plane scene.
Index3 voids_around(const ImageInfo& info, double width, const Index3& coarsen);

/// Fills the body's cells of which at least `least` is tissue: `tissue`, and of cells that hold no matter so
/// far the material that most voxels of matter around them have; takes the matter from those that have less.
/// Voxels whose share is no number are no tissue.
/// @param body not cut down; its cells are blocks of `coarsen` voxels
/// @param of_matter whether of voxels without a number those alone count that are of the ranges
/// @param keeps_volume whether the other cells on the surface take over what cells below `least` had
/// @return how many have none
/// @throws InputError of the image or of the shares; then the body is as it was
std::int64_t fill_partial_cells(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                                const Index3& coarsen, LayerWindow shares, double least, bool of_matter,
                                bool keeps_volume, Specimen& body);

} // namespace maille::reader
