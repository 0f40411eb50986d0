#pragma once
/// What write_vtk wrote, read again.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <optional>

namespace maille::studies {

/// On the scene's grid, object's frame [m].
struct AnswerFields {
  Displacement displacement;
  std::optional<Displacement> reference, error, estimate;
};

/// @param file that write_vtk wrote of this scene
/// @throws std::runtime_error where it cannot be read, or is of another body
AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file);

} // namespace maille::studies
