#pragma once
/// What a kind of matter is: constants, density, limits if it has its own, and where it fails if that is
/// known.

#include "maille/materials/damage.hpp"
#include "maille/materials/elasticity.hpp"
#include "maille/materials/neighbour_limits.hpp"

#include <optional>
#include <string>

namespace maille {

struct Material {
  std::string name;                      ///< "muscle/soleus", or the key where a scene defines it
  ElasticConstants elasticity;           ///< in the material frame, axis 1 = fibre
  double density = 1000;                 ///< kg/m^3, > 0
  std::optional<NeighbourLimits> limits; ///< in the material frame
  std::optional<Damage> damage;          ///< nothing where no figure is known; in the material frame
  /// Factors > 0 on what `relaxed` takes for the modulus along axis 1, 2, 3 of a component's own links; no
  /// other method sees them. In the material frame, turned as slack is (see turned).
  std::array<double, 3> relaxed_weights{1, 1, 1};
};

} // namespace maille
