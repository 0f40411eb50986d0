#pragma once
/// Layout of the page and view of the body. Numbers only, no VTK.

#include "picture/comparison_picture.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::studies {

/// A parallel view: directions in the object's frame, and the visible part of the picture plane.
struct View {
  Vec3 right{1, 0, 0}, up{0, 1, 0}, toward{0, 0, 1}; ///< orthonormal; `toward` the viewer
  Vec3 centre{};                                     ///< centre of the visible part [m]
  double width = 0, height = 0, depth = 0; ///< size of the visible part [m]; only the depth may be 0
};

inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length_of(const Vec3& v) {
  return std::sqrt(dot(v, v));
}
inline Vec3 plus(const Vec3& a, double factor, const Vec3& b) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

/// Directions of a view whose horizon is `along`, seen from a little to its right and above [deg].
View looking(const Vec3& along, const Vec3& upright, double turn, double tilt);

/// The part of a view's picture plane that must be seen.
class SeenBox {
public:
  explicit SeenBox(const View& view) : directions_{view.right, view.up, view.toward} {}
  void include(const Vec3& position);
  /// Sets the centre and the sizes of the view. @pre something was included
  void fit(View& view) const;

private:
  std::array<Vec3, 3> directions_;
  Vec3 low_{INFINITY, INFINITY, INFINITY}, high_{-INFINITY, -INFINITY, -INFINITY};
};

/// Longest side of the specimen's grid, and least spacing of a grid [m].
double longest_side(const Scene& scene);
double least_spacing(const Grid& grid);
/// Euclidean length [m]; not finite if a component is not.
double length_of(const Displacement& displacement, std::int64_t node);
/// Largest finite length over the panels [m], of displacements and of coloured fields.
double largest_length(const Scene& scene, const std::vector<PicturePanel>& panels);
double largest_shown(const Scene& scene, const std::vector<PicturePanel>& panels);
/// The field shown by the panel's colours.
const Displacement& shown_by_colour(const PicturePanel& panel);
/// Drawn position of a node [m], object's frame: at rest if its displacement is not finite.
Vec3 drawn_position(const Scene& scene, const Displacement& displacement, double warp, std::int64_t node);

/// The view that contains every panel's body and the body at rest.
View choose_view(const Scene& scene, const std::vector<PicturePanel>& panels, double warp,
                 const std::vector<std::int64_t>& nodes, const std::vector<Vec3>& also = {});

/// Picture coordinates (right, up) of the world's axes, of length 1 for axes in the picture plane.
std::array<std::array<double, 2>, 3> world_axes(const View& view, const Placement& placement);

/// A rectangle on the page [pixels], origin at the lower left.
struct Box {
  double left = 0, bottom = 0, width = 0, height = 0;
};

/// The page: boxes of the drawings, and below them their labels.
struct Page {
  int width = 0, height = 0;
  double text_size = 0; ///< [pixels] of a label
  double scale = 0;     ///< [pixels/m] of the drawings
  std::vector<Box> drawings;
  std::vector<Box> labels;
  Box title;
  Box legend;
};

/// Heights of parts of a page, in heights of its text.
struct PageParts {
  double label = 3.5;  ///< under a drawing: two lines
  double legend = 3.6; ///< at the bottom: a scale and two lines
};
/// Arranges the panels in the number of columns that gives the largest drawings.
Page choose_page(const View& view, std::size_t n_panels, const PictureSettings& settings,
                 const PageParts& parts = {});

/// End and number of steps of a colour scale; the end is round and at least `largest`.
struct Scale {
  double end = 1;
  int steps = 4;
};
Scale round_scale(double largest);

} // namespace maille::studies
