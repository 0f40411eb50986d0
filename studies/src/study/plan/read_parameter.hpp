#pragma once
/// Reading of a [[parameter]] table of a study from TOML to its values; access to TOML nodes by dotted key
/// (`specimen.material.E_fibre`, `move[1].by`).

#include "maille/materials/toml_reader.hpp"
#include "study/plan/study.hpp"

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace maille::studies {

/// Node of a key; `last` is the part of the key that was found, for messages.
struct DottedNode {
  toml::node* node = nullptr; ///< nullptr if missing
  std::string last;
};

/// Finds a node by table names and array indices: `move[1]`, counted from 1, or `move.0`, from 0.
DottedNode find_dotted(toml::table& root, std::string_view key);

/// Replaces the node at `key` by a value in TOML syntax.
/// @pre find_dotted finds it; the text is one TOML value
void replace_dotted(toml::table& root, std::string_view key, const std::string& value);

struct NumberWithUnit {
  double number = 0;
  std::string unit; ///< as written
};

/// A finite number, or a text that starts with one; nothing for anything else.
std::optional<NumberWithUnit> number_with_unit(const toml::node& node);

/// A value in TOML syntax on one line.
std::string toml_text(const toml::node& node);

/// A value of a list: any TOML value.
StudyValue value_of(const toml::node& node);

/// A drawn number with its unit, rounded to twelve legible digits.
StudyValue drawn(double value, const std::string& unit);

/// `count` values from one end of the range to the other, in equal steps or by equal factors. @pre
/// parameter.range
std::vector<StudyValue> values_of_range(const StudyParameter& parameter, int count);

/// True for plans that sample ranges instead of counting values.
constexpr bool is_drawn_plan(Combination combination) {
  return combination == Combination::latin_hypercube || combination == Combination::sobol ||
         combination == Combination::saltelli;
}

/// A text, or a non-empty list of texts; an error for anything else.
std::vector<std::string> texts_of(const toml::node& node, const std::string& path,
                                  const std::string& expected, FaultList& faults);

/// Reads the table. Every scene of `study` must have its keys, and no key may be inside a key of an earlier
/// parameter.
/// @return nothing if errors make it unusable
std::optional<StudyParameter> read_parameter(TableReader& table, const StudyFile& study);

} // namespace maille::studies
