#pragma once
/// Measured displacements for `identify`: of points in a table, or of every voxel of an image.

#include "identify/identify.hpp"
#include "maille/scene/measure/measure.hpp"

namespace maille::studies {

struct DisplacementData {
  std::vector<Measure> measures;         ///< a point each, of the scene as it was read
  std::vector<Observation> observations; ///< their columns, components in the world's frame
};

/// By its first row: columns `x`, `ux`, ... in place of `measure`.
bool is_table_of_points(std::string_view text);

/// Places and vectors are in the world of the body's image (of other bodies, the object's frame); those of an
/// image are taken from where its header says, values in mm.
/// @param sigma standard deviation of every component [m]; unset: of points the column `sigma`
/// @throws InputError with every fault: points without matter, no sigma, numbers that are none, no overlap
DisplacementData read_displacement_data(const std::filesystem::path& file, std::optional<double> sigma,
                                        const Scene& scene);

} // namespace maille::studies
