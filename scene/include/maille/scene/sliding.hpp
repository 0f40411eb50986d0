#pragma once
/// Labels that slide on each other: the same body with the nodes of their borders there twice.
///
/// Each label of a pair gets its own copy of the border's nodes. Ties join the copies along the smoothed
/// normal and leave the tangents free. Copies stand in one larger grid, so that every method works on them
/// unchanged; joined() brings the answer back to the body.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille {

/// A scene whose sliding borders are cut open: copies are one above the other along z, with a layer of empty
/// cells between. Places along z are those of the copies; scene.tied joins them.
struct SplitScene {
  Scene scene;                       ///< without `sliding`, with `tied`
  std::vector<std::int32_t> copy_of; ///< by cell of the body: the copy that it stands in; -1: no matter
  int n_copies = 1;

  /// In the copy, of a node or a cell of the body.
  std::int64_t node(const Grid& of_body, std::int64_t node, int copy) const;
  std::int64_t cell(const Grid& of_body, std::int64_t cell, int copy) const;
};

/// Copies of a node are tied along the normal of the smooth border (the mean of its faces' within three
/// cells) of every pair of labels that slide there, and all the way where labels meet in it that are joined.
/// @pre in 3D, with labels @param pairs in place of the scene's own
/// Cost  O(cells times copies); copies are two unless three labels all slide on each other
SplitScene split_borders(const Scene& scene, const std::vector<SlidingBorder>& pairs);
SplitScene split_borders(const Scene& scene);

/// The answer to a split scene as one of the body's: displacements at borders are the mean of copies, each of
/// which is in Answer::split; strains of cells are in Answer::cell_strain; reactions of copies add up.
Answer joined(const Scene& scene, const SplitScene& split, Answer answer);

/// Displacements of nodes as the cells beside them have them: on a sliding border every label has its own.
class DisplacementOfCells {
public:
  /// @pre both outlive it
  DisplacementOfCells(const Specimen& body, const Answer& answer) : body_(body), answer_(answer) {}
  /// [m], object's frame. Cost  O(log of the nodes on borders)
  Vec3 operator()(std::int64_t node, std::int64_t cell) const;
  /// Within a cell. @param part  of its edges, from its first corner, 0 to 1
  Vec3 within(std::int64_t cell, const Vec3& part) const;

private:
  const Specimen& body_;
  const Answer& answer_;
};

/// largest_violation() of a body with sliding borders: a cell's links are between the nodes of its own side.
/// Cost  O(cells log of the nodes on borders)
double largest_violation_of_sides(const Scene& scene, const LinkLimits& limits, const Answer& answer);

/// What springs to the ground pull with at a node, on one side of a sliding border.
struct SpringPull {
  std::int64_t node = 0;
  Vec3 force{};         ///< on the body, object's frame [N]
  double stiffness = 0; ///< along all axes together [N/m]
};
/// Pulls of all springs, or of one condition's, sorted by label and node. Cost  O(springs log springs)
std::vector<SpringPull> pulls_of_springs(const Scene& scene, const Answer& answer,
                                         std::optional<std::int32_t> condition = std::nullopt);

/// The axes that the faces between two labels are across; empty where they do not touch.
std::vector<int> axes_of_border(const Specimen& body, const SlidingBorder& pair);

} // namespace maille
