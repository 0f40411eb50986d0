#pragma once
/// Volume fractions: the fraction of tissue in every voxel and cell that the surface of a body cuts.
///
/// Fractions come from labels (0 or 1), from grey values (linear between two), or from a smoothed
/// segmentation: with G the Gaussian mean, the surface is a level of 2 G f - G G f, which removes the
/// shrinkage of plain smoothing up to the fourth power of the width. Each material uses the level, near 1/2,
/// that preserves the volume of its voxels in these and in the voxels that the level 1/2 cuts. A voxel's
/// fraction is sampled at 4 x 4 x 4 points; a cell's is the mean over its voxels. Cells below `least` are
/// removed; for a smoothed material their volume is redistributed to the others.
/// Images are streamed layer by layer, so memory is a few layers. Exact: fractions of labels, volumes of
/// smoothed ones. Approximate: the smooth surface.

#include "voxels/label_cells.hpp"

namespace maille::reader {

/// 1 in voxels of the ranges, 0 elsewhere.
LayerWindow shares_of_labels(LayerWindow image, const std::vector<LabelRange>& ranges);
/// Linear between two grey values, clipped to 0 and 1; NaN if they are not finite.
LayerWindow shares_of_grey(LayerWindow image, double none, double full);
/// The fraction of each voxel within the smooth surface of a segmentation, from 4 x 4 x 4 points per voxel
/// with linear interpolation of 2 G f - G G f. A point has the material of its voxel or of the nearest one.
/// @param image padded by voids_around() on all sides: values extend beyond the border
/// @param ranges must outlive the window
/// @param width  standard deviation of the Gaussian [m], > 0
/// Cost  about 20 ns per voxel and voxel of width; at most about 24 layers of float32 per voxel of width
LayerWindow shares_of_smoothed(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                               double width);
/// Number of empty voxels around an image that exclude effects of its border, in whole cells; none across a
/// plane scene.
Index3 voids_around(const ImageInfo& info, double width, const Index3& coarsen);

/// Fills `tissue` of the body's cells with a fraction of at least `least`; empty cells among them take the
/// most frequent material of the matter voxels around them; cells below lose their matter.
/// Voxels with fraction NaN are no tissue.
/// @param body not cropped; its cells are blocks of `coarsen` voxels
/// @param of_matter true: among voxels with NaN, count only those in the ranges
/// @param keeps_volume true: redistribute the tissue of cells below `least` to other surface cells
/// @return number of voxels with NaN
/// @throws InputError for the image or the fractions; then the body is unchanged
std::int64_t fill_partial_cells(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                                const Index3& coarsen, LayerWindow shares, double least, bool of_matter,
                                bool keeps_volume, Specimen& body);

} // namespace maille::reader
