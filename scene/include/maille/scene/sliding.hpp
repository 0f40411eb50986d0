#pragma once
/// Labels that slide on each other: the same body with duplicated nodes at their borders.
///
/// Each label of a pair has its own copy of the border's nodes. Ties join the copies along the smoothed
/// normal; tangential motion is free. All copies are placed in one larger grid, so that every method works
/// unchanged; joined() maps the answer back to the body.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille {

/// A scene whose sliding borders are cut open: copies are stacked along z, with a layer of empty cells
/// between. z coordinates are those of the copies; scene.tied joins them.
struct SplitScene {
  Scene scene;                       ///< without `sliding`, with `tied`
  std::vector<std::int32_t> copy_of; ///< per cell of the body: its copy; -1: no matter
  int n_copies = 1;

  /// Number in the copy of a node or a cell of the body.
  std::int64_t node(const Grid& of_body, std::int64_t node, int copy) const;
  std::int64_t cell(const Grid& of_body, std::int64_t cell, int copy) const;
};

/// Copies of a node are tied along the smoothed border normal (mean over faces within three cells) of every
/// sliding pair there; along all axes between copies of labels that meet there without sliding.
/// @pre 3D, with labels @param pairs replace those of the scene
/// Cost  O(cells times copies); two copies unless three labels slide on each other
SplitScene split_borders(const Scene& scene, const std::vector<SlidingBorder>& pairs);
SplitScene split_borders(const Scene& scene);

/// Maps the answer of a split scene to the body: displacements at borders are means over copies, with each
/// copy in Answer::split; strains of cells are in Answer::cell_strain; reactions of copies are added.
Answer joined(const Scene& scene, const SplitScene& split, Answer answer);

/// Displacements of nodes as seen from a cell: on a sliding border each label has its own.
class DisplacementOfCells {
public:
  /// @pre both outlive this
  DisplacementOfCells(const Specimen& body, const Answer& answer) : body_(body), answer_(answer) {}
  /// [m], object's frame. Cost  O(log of the nodes on borders)
  Vec3 operator()(std::int64_t node, std::int64_t cell) const;
  /// Displacement within a cell. @param part  fraction of its edges, from its first corner, 0 to 1
  Vec3 within(std::int64_t cell, const Vec3& part) const;

private:
  const Specimen& body_;
  const Answer& answer_;
};

/// largest_violation() for a body with sliding borders: a cell's links join the nodes of its own side.
/// Cost  O(cells log of the nodes on borders)
double largest_violation_of_sides(const Scene& scene, const LinkLimits& limits, const Answer& answer);

/// Force of springs to the ground at a node, on one side of a sliding border.
struct SpringPull {
  std::int64_t node = 0;
  Vec3 force{};         ///< on the body, object's frame [N]
  double stiffness = 0; ///< sum over all axes [N/m]
};
/// Forces of all springs, or of one condition's, sorted by label and node. Cost  O(springs log springs)
std::vector<SpringPull> pulls_of_springs(const Scene& scene, const Answer& answer,
                                         std::optional<std::int32_t> condition = std::nullopt);

/// Axes normal to the faces between two labels; empty if they do not touch.
std::vector<int> axes_of_border(const Specimen& body, const SlidingBorder& pair);

} // namespace maille
