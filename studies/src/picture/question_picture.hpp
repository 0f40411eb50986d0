#pragma once
/// Pictures of a question, before there is an answer, and of what an answer's inside looks like.

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

/// What a body's cells are told apart by: labels of its image, else materials.
struct BodyParts {
  std::vector<std::string> names;
  std::vector<int> of_cell; ///< per cell of the grid; -1 without matter
};
BodyParts parts_of(const Scene& scene);

/// @brief Draws the body at rest into a PNG file: its labels (else its materials) in a colour each, fibres on
///        the faces that are seen, what holds and moves it, and what pulls at it.
///
/// Dots are held nodes (dark), moved ones (red), loaded faces (violet) and faces on springs (brown); arrows
/// point where moves (red) and loads (violet) go and are of one length; fibres that contract are violet. Seen
/// as render_comparison sees it; a line of names explains the colours.
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
/// Across the body's shortest side, the layer of the middle third with the most matter. @pre three dimensions
Slice middle_slice(const Scene& scene);

struct SlicePanel {
  std::string label;
  const Displacement* displacement = nullptr; ///< on the scene's grid; required
  std::vector<double> values;                 ///< a cell of the grid
};

/// @brief Draws a layer of the deformed body, of 2D bodies all of it, in the colours of values of its cells.
///
/// Colours go from 0 to a round number above what 98 % of the cells that are drawn do not exceed; larger
/// values have the colour of the end.
/// @param quantity  what values are, with the unit of what they are divided by: `largest strain in %`, 0.01
/// @return as render_question @pre the scene has two or three dimensions
[[nodiscard]] std::optional<std::string>
render_slice(const Scene& scene, const std::vector<SlicePanel>& panels, const std::string& quantity,
             double unit, const std::filesystem::path& png, const QuestionPictureSettings& settings = {});

/// Whether a scene's body comes from an image in the space of a patient (NIfTI).
/// @param text of the scene's file
bool is_scene_of_a_patient(std::string_view text);

} // namespace maille::studies
