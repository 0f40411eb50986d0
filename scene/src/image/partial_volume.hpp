#pragma once
/// Which part of every voxel and cell is tissue, where a body's surface runs through them.

#include "image/label_cells.hpp"

namespace maille::reader {

/// Parts of voxels, 0 to 1, by voxel.
using TissueShares = std::vector<float>;

/// 1 in voxels of the ranges, 0 elsewhere.
TissueShares shares_of_labels(const Image& image, const std::vector<LabelRange>& ranges);
/// Linear between two grey values, cut off beyond them. What is not finite is no tissue.
TissueShares shares_of_grey(const Image& image, double none, double full);
/// The part of each voxel within the smooth surface that a segmentation stands for: where twice the labels'
/// Gaussian mean less its own mean, whose surface is off by the fourth power of the width only, is above 1/2,
/// found at 4 x 4 x 4 points of a voxel between which it is linear. The border of the image is no surface.
/// @param width standard deviation of the Gaussian [m], > 0
/// Cost  some 30 ns a voxel and voxel of width, twelve bytes a voxel
TissueShares shares_of_smoothed(const TissueShares& labels, const ImageInfo& info, double width);

/// Fills the body's cells of which at least `least` is tissue: `tissue`, and of cells that hold no matter so
/// far the material that most voxels of matter around them have; takes the matter from those that have less.
/// @param body not cut down; its cells are blocks of `coarsen` voxels
void fill_partial_cells(const Image& image, const std::vector<LabelRange>& ranges, const Index3& coarsen,
                        const TissueShares& shares, double least, Specimen& body);

} // namespace maille::reader
