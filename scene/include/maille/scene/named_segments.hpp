#pragma once
/// What a segmentation of 3D Slicer (.seg.nrrd) calls its labels.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace maille {

struct NamedSegment {
  std::string name;
  std::int32_t label = 1;
  int layer = 0; ///< of several that overlap; the image has a component each
};

/// In the file's order; empty if the file is no NRRD, or names no segment.
/// @throws InputError  the NRRD header is faulty
std::vector<NamedSegment> named_segments(const std::filesystem::path& file);

} // namespace maille
