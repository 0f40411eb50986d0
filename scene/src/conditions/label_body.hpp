#pragma once
/// From the voxels of a label image to the cells of a body: the same for images that are read and for a
/// program's arrays.

#include "image/label_cells.hpp"
#include "maille/materials/toml_reader.hpp"

#include <string>
#include <vector>

namespace maille::reader {

/// Every grey value but 0, for material 0.
std::vector<LabelRange> all_but_zero();

/// Appends a range; a fault of `path` where it overlaps another. @param text as it is asked for
void add_label(const LabelRange& range, const std::string& text, int line, const std::string& path,
               std::vector<LabelRange>& ranges, FaultList& faults);

/// A label as it is asked for, and its line.
struct NamedLabel {
  std::string text;
  int line = 0;
};
/// A label that no voxel has is a slip: what it was meant for would be missing without a word.
/// @param names of the ranges, in their order
void check_labels_occur(const Image& image, const std::vector<LabelRange>& ranges,
                        const std::vector<NamedLabel>& names, const std::string& path, FaultList& faults);

/// Grid, placement and materials of a body's cells, not cut down to its matter. Two-dimensional where the
/// image has one slice.
/// @param coarsen voxels of a cell along each axis
void fill_cells(const Image& image, const Index3& coarsen, const std::vector<LabelRange>& ranges,
                Specimen& body);

/// A body without a cell of matter is a fault.
bool has_matter(const Specimen& body, const std::string& path, int line, FaultList& faults);

} // namespace maille::reader
