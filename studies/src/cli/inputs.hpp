#pragma once
/// What commands read and show: inputs that no option can overwrite, fields of pictures, worlds in words.

#include "maille/scene/answer.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maille::studies {

/// Keeps (keep_input) the files that a command line names; those that they name are kept as they are opened.
void keep_inputs(const std::vector<std::filesystem::path>& files);

/// Compares what ranks are about to share; what differs is printed once. All ranks of a command for all
/// must call it. @param digests  by what they are of, as users call it @return true where they are equal
using Digests = std::vector<std::pair<std::string, std::string>>;
bool ranks_agree(const Digests& digests);

/// Compares the files that are kept, the body and the options, and is the first meeting after they were read.
bool ranks_agree_on(const Scene* scene, const std::string& options);

/// Tells ranks that wait in ranks_agree_on() that this one has failed, unless they have met already.
/// @return whether this rank is to say why: the first of those that have all failed, each that failed alone
bool reports_failure();

/// Says that this rank works alone: the others have nothing to do with the command and wait for no word.
void meet_no_more();
/// True if ranks have agreed on what they share, so that an error of one alone leaves the others waiting.
bool have_all_met();

/// Digests of the files that were opened since keep_inputs(), by absolute name.
std::map<std::string, std::string> digests_of_opened_files();

/// The text of a scene file; nothing where it can no longer be read: part of it would be another scene.
std::string scene_text_of(const std::filesystem::path& file);

/// Strain or stress as pictures take it: at every node a vector whose length is the mean over its cells of
/// matter, of the principal strain of largest size [1], or of von Mises' stress [Pa].
Displacement nodal_sizes(const Scene& scene, const Displacement& displacement, bool of_stress);

/// True if the scene's body is from a NIfTI image: its world is right, anterior, superior of a patient.
bool is_of_a_patient(const std::filesystem::path& scene);

/// One line: `2D world of 64 x 48 cells, 1 fixed, 1 rigid, 0 deformable objects`.
std::string in_words(const WorldScene& scene);

} // namespace maille::studies
