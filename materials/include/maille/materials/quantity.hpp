#pragma once
/// Numbers with units: converts text to SI. The only place that defines units.

#include <optional>
#include <string>
#include <string_view>

namespace maille {

/// Dimension of a quantity; numbers without a unit are in its SI unit.
enum class Dimension {
  dimensionless, ///< 1; "%" is understood
  length,        ///< m
  pressure,      ///< Pa: moduli, stresses, tractions
  density,       ///< kg/m^3
  angle,         ///< rad
  acceleration,  ///< m/s^2
  time,          ///< s
  force,         ///< N
  foundation,    ///< Pa/m: pressure over displacement, of springs to the ground
};

/// `text` such as "2 mm", "41.8kPa", "-20 deg", "5 %" or a bare number, in SI units.
/// @return the value; nothing if the text is not a finite number followed by a unit of `dimension`
std::optional<double> parse_quantity(std::string_view text, Dimension dimension);

/// For messages: `a length such as "2 mm" (units: m, cm, mm, um, nm)`.
std::string describe(Dimension dimension);

} // namespace maille
