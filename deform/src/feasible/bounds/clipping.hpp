#pragma once
/// Feasibility of requested moves, and their nearest feasible values. The arithmetic does not depend on the
/// algorithm for shortest paths.
///
/// Two prescribed nodes may differ by at most the shortest path between them. A move past what holds permit
/// is cut to the nearest value that they permit. Moves that contradict each other meet at the mean of the
/// least feasible values above them and the greatest below (docs/theory.md, Theorems 4 and 5).

#include "feasible/bounds/bound_source.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"

#include <string>
#include <vector>

namespace maille::deform {

/// Clips the moves of one component to limits and holds: see clip(). Allocates only if there are more
/// prescribed values than before.
class Clipper {
public:
  Clipper(BoundSource& source, const Grid& grid) : source_(source), grid_(grid) {}

  /// The values of `component` among `prescribed` are changed in place. @return how many were
  std::int64_t clip(int component, std::span<Prescribed> prescribed);

private:
  enum class Kind { any, hold, move };
  void bounds_by(Kind ends, int component, std::span<const Prescribed> prescribed, bool least_too);
  bool can_all_be_met(int component, std::span<const Prescribed> prescribed, double tolerance);
  void cut_at_holds(int component, std::span<Prescribed> prescribed, double tolerance);
  void reconcile_moves(int component, std::span<Prescribed> prescribed, double tolerance);

  BoundSource& source_;
  Grid grid_;
  List<PathEnd> ends_;
  List<std::int64_t> nodes_; ///< of the component's values, in the order of `prescribed`
  List<double> least_, greatest_, requested_;
};

/// Clipped values of the prescribed components, and how far moves were cut back.
struct Clipping {
  std::vector<Prescribed>
      prescribed;              ///< those of the scene, in its order, with values that the limits permit
  std::int64_t n_moves = 0;    ///< components that the scene moves (holds are not counted)
  std::int64_t n_cut = 0;      ///< of these, how many were cut back
  double largest_cut = 0;      ///< [m]
  std::int64_t worst_node = 0; ///< grid number of the node that lost most; the first of several
  int worst_component = 0;
};

/// Clips the moves of a scene to its limits and holds; feasible moves do not change, to the last bit.
///
/// First every moved component is clipped to the interval that the holds allow ("until ... a fixed voxel is
/// encountered", Gibson 1995, Object Deformation), without iteration. Then all moves that are still
/// incompatible are replaced at once by the mean of the least feasible values above and the greatest feasible
/// values below them: no feasible values are nearer to the requests in the largest difference. A value is
/// clipped only if it lies outside by more than rounding_tolerance.
///
/// @param limits of `scene`
/// @return never fails: rest is always feasible
/// Cost        one shortest-path search per moved component where all can be met, else five
/// Repeatable  same bits in any order of the prescribed values
/// Source      docs/theory.md, Theorems 4 and 5
/// Checked by  tests/deform/feasible/limits_test.cpp
Clipping clip(const Scene& scene, const LinkLimits& limits);

/// The part of clip() that concerns one component; `prescribed` is changed in place.
void clip_component(const Scene& scene, const LinkLimits& limits, int component,
                    std::vector<Prescribed>& prescribed);

/// Difference between `clipped` and the request. @pre same order as scene.prescribed
Clipping compare_with_request(const Scene& scene, std::vector<Prescribed> clipped);

/// A message with the number of clipped moves, the largest cut and its place; empty if none.
std::string describe(const Scene& scene, const Clipping& clipping);

/// Sets message, count and status of an answer. @param clipped in the order of scene.prescribed; @param
/// stopped why it ended early
void tell_clipping(const Scene& scene, std::vector<Prescribed> clipped, std::optional<Status> stopped,
                   Answer& answer);

/// Rounding error of sums along paths of links [m]: half an ulp of `largest` per link, for paths of twice the
/// sum of the grid's edges, and a few ulps for the comparison.
double rounding_tolerance(const Grid& grid, double largest);

} // namespace maille::deform
