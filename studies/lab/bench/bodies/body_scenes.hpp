#pragma once
/// The bodies that `studies/lab/run bodies` asks about.

#include "bench/bench_report.hpp"
#include "maille/scene/scene.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

/// A body and what is asked of it, without limits.
struct Body {
  std::string name;
  Scene scene;
  bool has_limits = false;    ///< its materials have some, and it is also answered within them
  bool is_against_fem = true; ///< finite elements can take its size in the time that there is
};

/// Sizes of generated bodies, in cells.
struct BodySizes {
  int network, large_network, huge_network, layers, period;
  static BodySizes of(const BenchOptions& options) {
    return options.quick ? BodySizes{16, 24, 32, 16, 8} : BodySizes{64, 128, 256, 48, 16};
  }
};

/// The larger half of a gyroid's network: cells whose sin x cos y + sin y cos z + sin z cos x is among the
/// highest, of which only the largest piece that hangs together by faces is kept; pressed together by 1 %.
/// Struts are some six cells thick where a third of a period of 16 is solid.
/// @param solid share of the cells @param filling Young's modulus of what is between them over theirs; 0:
/// nothing is
Scene gyroid_network(int cells, int period, double solid, double filling = 0);

/// Skin one cell thick, fat, muscle, whose lower face is held; the middle of the skin is pushed in.
Scene layered_tissue(int cells);

/// A strip one cell thick, nu 0.45, held at one end and bent by a traction on the other.
Scene one_cell_strip(const BenchOptions& options);

/// All that is measured in rows of their own; without the images that MAILLE_DATA does not name, of which the
/// report says so.
std::vector<Body> bodies(const BenchOptions& options, BenchReport& report);

/// The same body and question within limits of its materials. @pre has_limits
Scene within_limits(Scene scene);

} // namespace maille::lab
