#pragma once
/// Whether a question can mean what it says: its sizes, for people to look at, and what is out of all
/// proportion.

#include "maille/scene/scene.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille {

struct Plausibility {
  Vec3 size{};                 ///< of the box around the matter, along the scene's axes [m]
  double largest_move = 0;     ///< length of the largest prescribed displacement [m]
  double move_over_length = 0; ///< that over the longest side of the box [1]
  std::optional<double>
      mean_strain; ///< see plausibility [1]; unset where moves turn the body, or nothing is moved
  std::optional<double>
      strain_of_loads; ///< largest traction or contraction over the least Young's modulus [1]; unset without
  std::vector<std::string> warnings; ///< in words, empty where all is in proportion
};

/// Looks at the question alone; nothing is solved.
///
/// The mean strain is the largest move over the distance to the nearest node that is held (where nothing is
/// held, the difference to the node that moves least, over their distance). It is what the scene asks for on
/// the way, not the strain at a corner.
///
/// Warned of are: a mean strain, or a strain of loads, above 10 %, where small-strain elasticity no longer
/// holds (not with frame = "blocks", whose strains are measured otherwise); a stretch at which a material of
/// the body is known to fail; cells larger than 1 cm and bodies larger than 10 m, as of lengths in another
/// unit than was meant.
/// Cost  O(cells + prescribed components)
Plausibility plausibility(const Scene& scene);

/// `60 x 20 x 20 mm`, with the unit that suits the largest.
std::string size_in_words(const Scene& scene, const Vec3& size);
/// `2.5 mm`.
std::string length_in_words(double metres);
/// `size 60 x 20 x 20 mm; largest move 6 mm, 10 % of the length; mean strain 10 %`
std::string in_words(const Scene& scene, const Plausibility& found);

} // namespace maille
