#pragma once
/// Scenes of many kinds, the hard ones among them.

#include "bench/studies/scene_maker.hpp"
#include "maille/materials/text_file.hpp"

#include <cstddef>
#include <filesystem>
#include <vector>

namespace maille::studies {

/// Boxes that are poked, sheared, pulled and bent, with Poisson's ratios of 0.3 to 0.4999; plates and strips
/// one and two cells thick; bodies held along an edge; fibres up to 50 times as stiff along as across; layers
/// of skin, fat and muscle, soft seams, thin inclusions and checkerboards; slender bodies; gravity and
/// tractions; flat cells; bellies; with MAILLE_DATA muscles and bone from images.
class KindScenes {
public:
  /// Makes a temporary folder with the images, which goes with this.
  /// @param scale cells of 1 mm are divided by it along every axis: what is one cell thick is then so many
  explicit KindScenes(int scale);

  const std::vector<KindScene>& list() const { return scenes_; }
  /// That images are named relative to.
  const std::filesystem::path& folder() const { return folder_.path(); }

private:
  WorkFolder folder_;
  std::vector<KindScene> scenes_;
};

/// The numbers of 0 .. n - 1 that a quick run looks at: `wanted` of them, spread evenly.
std::vector<std::size_t> spread(std::size_t n, std::size_t wanted);

} // namespace maille::studies
