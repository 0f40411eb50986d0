#pragma once
/// Published power laws from the density of bone to its Young's modulus. Each is a data file in
/// materials/library/density_law/, compiled in.

#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Prefix of library files that are laws, not tissues.
inline constexpr std::string_view density_law_group = "density_law/";

/// E = modulus (density / 1000 kg/m^3)^exponent.
struct DensityLaw {
  std::string name;   ///< `morgan_2003_femoral_neck`
  std::string title;  ///< which bone
  std::string of;     ///< which density: `apparent` (wet), `ash`
  double modulus = 0; ///< at 1000 kg/m^3, which is 1 g/cm^3 [Pa]
  double exponent = 1;
  double least = 0, most = 0; ///< range of measured densities [kg/m^3]
  std::string source, note;
  bool verified = false; ///< the numbers were read in the source

  /// @param density [kg/m^3], > 0 @return [Pa]
  double youngs_modulus(double density) const;
};

/// All laws, sorted by name. @throws InputError if a compiled-in file is faulty (a test reads them all)
const std::vector<DensityLaw>& density_laws();
/// The law of that name, or nullptr.
const DensityLaw* find_density_law(std::string_view name);

/// Reads one file. @param text its content; @param file its name for messages; @param name the law's
/// @throws InputError with every fault
DensityLaw parse_density_law(std::string_view text, const std::string& file, const std::string& name);

} // namespace maille
