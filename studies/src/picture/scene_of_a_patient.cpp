#include "maille/materials/toml_reader.hpp"
#include "maille/studies/picture/question_picture.hpp"

namespace maille::studies {

bool is_scene_of_a_patient(std::string_view text) {
  try {
    const toml::table root = parse_toml(text, "scene");
    const auto image = root["specimen"]["image"].value<std::string>();
    return image && (image->ends_with(".nii") || image->ends_with(".nii.gz"));
  } catch (const InputError&) {
    return false;
  }
}

} // namespace maille::studies
