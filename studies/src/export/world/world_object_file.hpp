#pragma once
/// One object of a world at one moment as a file; WorldSeries documents its content.

#include "export/world/world_files.hpp"

namespace maille::studies {

/// @param start  positions of its grid nodes at the first moment [m] @param file  *.vtu @param unit  of
/// positions and displacements
/// @throws as write_vtk
void write_world_object(const WorldScene& world, std::size_t object, const WorldMoment& moment,
                        const std::vector<Vec3>& start, const std::string& provenance,
                        const std::filesystem::path& file, LengthUnit unit);

} // namespace maille::studies
