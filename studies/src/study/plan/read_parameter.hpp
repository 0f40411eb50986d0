#pragma once
/// One [[parameter]] table of a study.

#include "maille/materials/toml_reader.hpp"
#include "maille/studies/study.hpp"

namespace maille::studies {

/// True for plans that draw from ranges instead of counting values.
constexpr bool is_drawn_plan(Combination combination) {
  return combination == Combination::latin_hypercube || combination == Combination::sobol;
}

/// A text, or a list of at least one; a fault for anything else.
std::vector<std::string> texts_of(const toml::node& node, const std::string& path,
                                  const std::string& expected, FaultList& faults);

/// Reads the table. Its keys must be there in every scene of `study`, none of them inside one of an earlier
/// parameter.
/// @return nothing where it is too faulty to go on with
std::optional<StudyParameter> read_parameter(TableReader& table, const StudyFile& study);

} // namespace maille::studies
