#pragma once
/// One input of an image reader.

#include "fuzzing.hpp"
#include "maille/scene/image.hpp"

#include <cmath>

namespace maille::fuzzing {

/// Reads an image, and holds what it promises against what came of it. @return see tried
inline int read_one_image(const std::filesystem::path& file) {
  constexpr std::int64_t largest = 1 << 20;
  return tried([&] {
    const Image image = read_image(file, {largest});
    const ImageInfo& info = image.info;
    require(static_cast<std::int64_t>(image.values.size()) == info.n_voxels() * info.components,
            "as many values as the header says");
    require(static_cast<std::int64_t>(image.values.size() * sizeof(float)) <= largest,
            "no more than was allowed");
    for (std::size_t axis = 0; axis < 3; ++axis)
      require(info.size[axis] > 0 && std::isfinite(info.spacing[axis]) && info.spacing[axis] > 0 &&
                  std::isfinite(info.origin[axis]),
              "a grid that is one");
  });
}

} // namespace maille::fuzzing
