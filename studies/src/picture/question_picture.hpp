#pragma once
/// Pictures of a question before it is solved, and of the interior of an answer.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct QuestionPictureSettings {
  int width = 1400;           ///< [pixels], at least 200
  int largest_height = 900;   ///< [pixels], at least 200
  bool is_anatomical = false; ///< see PictureSettings
};

/// Parts of a body: labels of its image, else materials.
struct BodyParts {
  std::vector<std::string> names;
  std::vector<int> of_cell; ///< per cell of the grid; -1 without matter
};
BodyParts parts_of(const Scene& scene);

/// @brief Draws the body at rest to a PNG file: labels (else materials) in different colours, fibres on
///        visible faces, boundary conditions and loads.
///
/// Dots mark held nodes (dark), moved nodes (red), loaded faces (violet) and faces on springs (brown); arrows
/// of equal length show the directions of moves (red) and loads (violet); contracting fibres are violet. Same
/// view as render_comparison; a legend explains the colours.
/// @return nothing, or why no picture could be made on this machine
/// @throws std::filesystem::filesystem_error, std::runtime_error  the file could not be written
/// @pre not called from two threads at once
[[nodiscard]] std::optional<std::string> render_question(const Scene& scene, const std::filesystem::path& png,
                                                         const QuestionPictureSettings& settings = {});

/// A layer of cells, all of one index along an axis.
struct Slice {
  int axis = 2;
  std::int64_t index = 0;
};
/// The layer with the most cells in the middle third of the body's shortest side. @pre three dimensions
Slice middle_slice(const Scene& scene);

struct SlicePanel {
  std::string label;
  const Displacement* displacement = nullptr; ///< on the scene's grid; required
  std::vector<double> values;                 ///< one per grid cell
};

/// @brief Draws a layer of the deformed body (2D: the whole body), coloured by cell values.
///
/// Colours range from 0 to a round number above the 98th percentile of the drawn cells; larger values have
/// the last colour.
/// @param quantity  name of the values, and the unit that they are divided by: `largest strain in %`, 0.01
/// @return as render_question @pre the scene has two or three dimensions
[[nodiscard]] std::optional<std::string>
render_slice(const Scene& scene, const std::vector<SlicePanel>& panels, const std::string& quantity,
             double unit, const std::filesystem::path& png, const QuestionPictureSettings& settings = {});

/// True if a scene's body comes from an image in the space of a patient (NIfTI).
/// @param text of the scene file
bool is_scene_of_a_patient(std::string_view text);

} // namespace maille::studies
