#pragma once
/// From TOML to the values of a parameter.

#include "maille/studies/study.hpp"

#include <toml++/toml.h>

namespace maille::studies {

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

/// `count` values from one end to the other, evenly or by equal factors. @pre parameter.range
std::vector<StudyValue> values_of_range(const StudyParameter& parameter, int count);

} // namespace maille::studies
