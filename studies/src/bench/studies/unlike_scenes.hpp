#pragma once
/// Scenes that are unlike those of the table that `choose` knows.

#include "bench/studies/scene_maker.hpp"
#include "maille/materials/text_file.hpp"

#include <filesystem>
#include <vector>

namespace maille::studies {

/// Layers of muscle, fat and skin, seams, sheets and checkerboards; plates of one and two cells, of one
/// matter and of two; shells: hollow boxes, balls, tubes and domes; gravity and tractions on stout and
/// slender boxes; fibres 50 times as stiff along as across; with MAILLE_DATA all fourteen muscles of a calf
/// from MRI, and bone and flesh of a head from CT. Cells are of half a millimetre where they are not an
/// image's.
class UnlikeScenes {
public:
  /// Makes a temporary folder with the images, which goes with this.
  UnlikeScenes();

  const std::vector<KindScene>& list() const { return scenes_; }
  /// That images are named relative to.
  const std::filesystem::path& folder() const { return folder_.path(); }

private:
  WorkFolder folder_;
  std::vector<KindScene> scenes_;
};

} // namespace maille::studies
