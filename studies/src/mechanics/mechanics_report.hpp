#pragma once
/// Forces, strain, stress and energy of an answer as text and JSON; for a series as a curve.

#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"

#include <fmt/format.h>

namespace maille::studies {

/// One row per label or material, or for the whole body.
const ResultTable<PartMechanics>& columns_of_parts();
/// One row per hold, move or load.
const ResultTable<Resultant>& columns_of_resultants();

/// Object with conventions, energy, holds, moves, loads, labels, materials, body
nlohmann::ordered_json in_json(const Mechanics& mechanics);
/// Table of the labels and the body; without labels, of the materials, which include the body.
std::string in_words(const Mechanics& mechanics);

/// Sum of the forces; nothing for an empty list.
std::optional<Vec3> sum_of(const std::vector<Resultant>& resultants);

/// Adds one CSV column per world axis. @param path to the force, perhaps optional
template<class Row, class... Path>
void add_force(ResultTable<Row>& columns, const std::string& name, Path... path) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns.add({fmt::format("{}_force_{}_n", name, "xyz"[axis]), "", "N", "on the body, N/m in 2D"}, path...,
                [axis](const Vec3& force) { return force[axis]; });
}

} // namespace maille::studies
