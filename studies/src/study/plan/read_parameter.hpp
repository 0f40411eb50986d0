#pragma once
/// One [[parameter]] table of a study, from TOML to its values, and nodes of TOML by dotted key
/// (`specimen.material.E_fibre`, `move[1].by`).

#include "maille/materials/toml_reader.hpp"
#include "study/plan/study.hpp"

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace maille::studies {

/// Where a key leads; `last` is how far it can be followed, for messages.
struct DottedNode {
  toml::node* node = nullptr; ///< nullptr if missing
  std::string last;
};

/// Follows names of tables and entries of arrays: `move[1]`, counted from 1, or `move.0`, from 0.
DottedNode find_dotted(toml::table& root, std::string_view key);

/// Puts a value, written as TOML, in the place of what stands at `key`.
/// @pre find_dotted finds it; the text is one TOML value
void replace_dotted(toml::table& root, std::string_view key, const std::string& value);

struct NumberWithUnit {
  double number = 0;
  std::string unit; ///< as written
};

/// A finite number, or a text that begins with one; nothing for anything else.
std::optional<NumberWithUnit> number_with_unit(const toml::node& node);

/// A value on one line as TOML writes it.
std::string toml_text(const toml::node& node);

/// A value of a list: any TOML value.
StudyValue value_of(const toml::node& node);

/// A number with its unit, of twelve digits: what is drawn ought to be legible, and nothing is known better.
StudyValue drawn(double value, const std::string& unit);

/// `count` values from one end to the other, evenly or by equal factors. @pre parameter.range
std::vector<StudyValue> values_of_range(const StudyParameter& parameter, int count);

/// True for plans that draw from ranges instead of counting values.
constexpr bool is_drawn_plan(Combination combination) {
  return combination == Combination::latin_hypercube || combination == Combination::sobol ||
         combination == Combination::saltelli;
}

/// A text, or a list of at least one; a fault for anything else.
std::vector<std::string> texts_of(const toml::node& node, const std::string& path,
                                  const std::string& expected, FaultList& faults);

/// Reads the table. Its keys must be there in every scene of `study`, none of them inside one of an earlier
/// parameter.
/// @return nothing where it is too faulty to go on with
std::optional<StudyParameter> read_parameter(TableReader& table, const StudyFile& study);

} // namespace maille::studies
