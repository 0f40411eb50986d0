#pragma once
/// Forces, strain, stress and energy of an answer, as text for people and as JSON.

#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

/// A row a label, a material or the whole body.
const ResultTable<PartMechanics>& columns_of_parts();
/// A row a hold, a move or a load.
const ResultTable<Resultant>& columns_of_resultants();

/// conventions, energy, holds, moves, loads, labels, materials, body
nlohmann::ordered_json in_json(const Mechanics& mechanics);
/// A table of the labels and the body; without labels of the materials, of which one is the body.
std::string in_words(const Mechanics& mechanics);

} // namespace maille::studies
