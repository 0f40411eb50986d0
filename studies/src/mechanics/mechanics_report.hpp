#pragma once
/// Forces, strain, stress and energy of an answer, as text for people and as JSON; of a series as a curve.

#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"

#include <fmt/format.h>

namespace maille::studies {

/// A row a label, a material or the whole body.
const ResultTable<PartMechanics>& columns_of_parts();
/// A row a hold, a move or a load.
const ResultTable<Resultant>& columns_of_resultants();

/// conventions, energy, holds, moves, loads, labels, materials, body
nlohmann::ordered_json in_json(const Mechanics& mechanics);
/// A table of the labels and the body; without labels of the materials, of which one is the body.
std::string in_words(const Mechanics& mechanics);

/// The sum of their forces; nothing where there are none.
std::optional<Vec3> sum_of(const std::vector<Resultant>& resultants);

/// A column of CSV an axis of the world. @param path to the force, perhaps optional
template<class Row, class... Path>
void add_force(ResultTable<Row>& columns, const std::string& name, Path... path) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns.add({fmt::format("{}_force_{}_n", name, "xyz"[axis]), "", "N", "on the body, N/m in 2D"}, path...,
                [axis](const Vec3& force) { return force[axis]; });
}

} // namespace maille::studies
