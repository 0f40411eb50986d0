#pragma once
/// Inputs of commands, protected from overwriting; fields for pictures; descriptions of worlds.

#include "maille/scene/answer.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace maille::studies {

/// Protects (keep_input) the files named on the command line; files named in them are protected when opened.
void keep_inputs(const std::vector<std::filesystem::path>& files);

/// Compares data that ranks are about to share; prints each difference once. Collective over all ranks of the
/// command. @param digests  digests with their user-visible names @return true if all are equal
using Digests = std::vector<std::pair<std::string, std::string>>;
bool ranks_agree(const Digests& digests);

/// Compares the input files, the body and the options; the first collective call after reading them.
bool ranks_agree_on(const Scene* scene, const std::string& options);

/// Reports the failure of this rank to ranks that wait in ranks_agree_on(), unless that call is over. @return
/// true if this rank must print the reason: the first rank if all failed, else each failed rank
bool reports_failure();

/// Declares that this rank works alone: other ranks take no part in the command and wait for no message.
void meet_no_more();
/// True if ranks have compared their data, so that an error on one rank alone leaves the others waiting.
bool have_all_met();

/// Digests of the files that were opened since keep_inputs(), by absolute name.
std::map<std::string, std::string> digests_of_opened_files();

/// Text of a scene file; nothing if it can no longer be read: a part of it would be another scene.
std::string scene_text_of(const std::filesystem::path& file);

/// True if the body comes from a NIfTI image: the world axes are right, anterior, superior of a patient.
bool is_of_a_patient(const std::filesystem::path& scene);

/// One line: `2D world of 64 x 48 cells, 1 fixed, 1 rigid, 0 deformable objects`.
std::string in_words(const WorldScene& scene);

} // namespace maille::studies
