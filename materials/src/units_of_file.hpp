#pragma once
/// Lengths and angles without units of their own.

#include "maille/materials/toml_reader.hpp"

namespace maille {

/// A length or an angle that has no unit is in the file's; where the file says none, only 0 is one.
/// @param value as if it were in SI units @return in SI units; nothing and a fault where nobody knows
std::optional<double> in_units_of_the_file(const toml::node& node, double value, const std::string& path,
                                           Dimension dimension, FaultList& faults);

} // namespace maille
