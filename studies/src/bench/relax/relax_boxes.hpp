#pragma once
/// The boxes that `maille bench relax` asks about.

#include "maille/scene/answer.hpp"

#include <string>
#include <vector>

namespace maille::studies {

enum class BoxLoad { poke, stretch };

/// What is asked of a cube, whatever its number of cells.
struct BoxQuestion {
  BoxLoad load = BoxLoad::poke;
  /// "nu 0.3", or "fibre 10": ten times as stiff along fibres at 30 degrees to x as across them
  std::string material;
  ElasticConstants elasticity;
  std::string load_name() const { return load == BoxLoad::poke ? "poke" : "stretch"; }
};

BoxQuestion isotropic_box(BoxLoad load, double poisson_ratio);
BoxQuestion fibrous_box(BoxLoad load);

/// A cube of 64 mm and cells^3 cells, held below. Poke: the middle of the top, a quarter of the side wide,
/// goes down by 0.05 mm; moves are as small as that for the sake of rivals whose springs turn. Stretch: the
/// whole top goes up by 0.05 mm. Limits are taut, which do not bind `coupled`.
/// @param cells a multiple of 8, so that every lattice prescribes the same part of the top
Scene box_scene(const BoxQuestion& question, int cells);

/// The same with limits that are never active, for methods that ask for limits: to find taut ones is no part
/// of relaxing.
Scene with_wide_limits(Scene scene);

/// "65^3"
std::string nodes_in_words(const Scene& scene);

} // namespace maille::studies
