#pragma once
/// Reader for files of write_vtk.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <optional>

namespace maille::studies {

/// Fields on the scene's grid, object's frame [m].
struct AnswerFields {
  Displacement displacement;
  std::optional<Displacement> reference, error, estimate;
};

/// @param file by write_vtk, of this scene
/// @throws std::runtime_error if it cannot be read or belongs to another body
AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file);

} // namespace maille::studies
