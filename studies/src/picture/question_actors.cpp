#include "question_actors.hpp"

#include "body_actors.hpp"
#include "export/body_grid.hpp"

#include <vtkCellData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::studies {

namespace {

/// Polygons that face the viewer.
class FacingShapes {
public:
  explicit FacingShapes(const View& view) : view_(view) {}

  /// @param corners  offsets right and up from `at` [m]
  void add(const Vec3& at, const std::vector<std::array<double, 2>>& corners) {
    Shape& shape = shapes_.emplace_back();
    for (const auto& [right, up] : corners)
      shape.push_back(plus(plus(at, right, view_.right), up, view_.up));
  }
  void add_disc(const Vec3& at, double radius) { shapes_.push_back(disc(at, radius, view_)); }
  void add_arrow(const Arrow& arrow, double width) {
    const Vec3 along = plus(arrow.to, -1, arrow.from);
    const double right = dot(along, view_.right), up = dot(along, view_.up), length = std::hypot(right, up);
    if (length < 2 * width) // parallel to the line of sight: a ring without direction
      return add_disc(arrow.from, 1.5 * width);
    const double c = right / length, s = up / length, head = std::min(4 * width, 0.6 * length);
    const auto at = [&](double forward, double aside) {
      return std::array<double, 2>{c * forward - s * aside, s * forward + c * aside};
    };
    add(arrow.from, {at(0, -0.5 * width), at(length - head, -0.5 * width), at(length - head, 0.5 * width),
                     at(0, 0.5 * width)});
    add(arrow.from, {at(length - head, -1.6 * width), at(length, 0), at(length - head, 1.6 * width)});
  }
  vtkSmartPointer<vtkActor> actor(const Vec3& colour, double forward) const {
    const auto actor = flat_actor(data_of(shapes_), colour);
    bring_forward(*actor, view_, forward);
    return actor;
  }

private:
  const View& view_;
  std::vector<Shape> shapes_;
};

/// A cell face that the viewer may see.
struct SeenFace {
  std::int64_t cell = 0;
  Index3 at{};
  int axis = 0; ///< of its normal
  Vec3 middle{};
};

std::vector<SeenFace> seen_faces(const Scene& scene, const View& view) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  std::vector<SeenFace> faces;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    Vec3 middle = body.position(at);
    for (int a = 0; a < grid.dimension(); ++a)
      middle[a] += 0.5 * grid.spacing()[a];
    if (grid.dimension() < 3) {
      faces.push_back({cell, at, 2, middle});
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(view.toward[axis]) < 0.15) // seen edge-on: strokes would overlap
        continue;
      const int side = view.toward[axis] > 0 ? 1 : -1;
      Index3 next = at;
      next[axis] += side;
      if (grid.has_cell(next) && body.is_matter(grid.cell(next)))
        continue;
      Vec3 on_face = middle;
      on_face[axis] += 0.5 * side * grid.spacing()[axis];
      faces.push_back({cell, at, static_cast<int>(axis), on_face});
    }
  }
  return faces;
}

/// Adds dots on the faces that the viewer may see.
template<class Faces>
void add_faces(const Specimen& body, const Faces& faces, const View& view, double radius,
               FacingShapes& shapes) {
  for (const auto& face : faces)
    if (body.grid.dimension() < 3 || view.toward[face.axis] * (face.upper ? 1 : -1) > 0.15)
      shapes.add_disc(middle_of_face(body, face), radius);
}

/// Selects some hundred faces, in a pattern in the plane of each face.
std::vector<SeenFace> thinned(const std::vector<SeenFace>& faces, int& stride) {
  constexpr std::size_t wanted = 450;
  std::vector<SeenFace> some = faces;
  for (stride = 1; some.size() > wanted && stride < 64; ++stride) {
    some.clear();
    const int every = stride + 1;
    for (const SeenFace& face : faces) {
      const auto b = static_cast<std::size_t>((face.axis + 1) % 3),
                 c = static_cast<std::size_t>((face.axis + 2) % 3);
      if (face.at[b] % every == every / 2 && face.at[c] % every == every / 2)
        some.push_back(face);
    }
  }
  return some;
}

/// By cell: true if its fibres contract at any time.
std::vector<bool> contracting_cells(const Scene& scene) {
  std::vector<bool> contracts(scene.specimen.grid.n_cells(), false);
  for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
    contracts[cell] = scene.active_stress[cell] > 0;
  for (const TimedContraction& timed : scene.timed)
    for (const std::int64_t cell : timed.cells)
      if (timed.stress > 0)
        contracts[cell] = true;
  return contracts;
}

} // namespace

Vec3 part_colour(std::size_t part, std::size_t n_parts) {
  // Colours of M. Okabe, K. Ito, 2002, lightened.
  constexpr std::array<Vec3, 7> few{{{0.55, 0.75, 0.88},
                                     {0.95, 0.77, 0.45},
                                     {0.48, 0.78, 0.66},
                                     {0.89, 0.68, 0.80},
                                     {0.96, 0.91, 0.50},
                                     {0.90, 0.58, 0.42},
                                     {0.72, 0.74, 0.78}}};
  if (n_parts <= few.size())
    return few[part];
  // Hues by the golden ratio, in three lightnesses.
  const double hue = 6 * std::fmod(0.58 + 0.618034 * static_cast<double>(part), 1.0);
  const double low = 0.38 + 0.13 * static_cast<double>(part % 3),
               high = 0.80 + 0.07 * static_cast<double>(part % 3);
  Vec3 colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double k = std::fmod(5 - 2.0 * static_cast<double>(c) + hue, 6.0);
    colour[c] = high - (high - low) * std::clamp(std::min(k, 4 - k), 0.0, 1.0);
  }
  return colour;
}

Props part_actors(const Scene& scene, const BodyParts& parts, const View& view, double pixels_per_metre) {
  const BodyNumbering numbering = matter_only(scene.specimen);
  const auto grid = cell_grid(scene.specimen, numbering, false);
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (const std::int64_t cell : numbering.cells) {
    const Vec3 colour = part_colour(static_cast<std::size_t>(parts.of_cell[cell]), parts.names.size());
    for (const double c : colour)
      colours->InsertNextValue(static_cast<unsigned char>(std::lround(255 * c)));
  }
  grid->GetCellData()->SetScalars(colours);
  const auto surface = surface_of(*grid);
  const bool is_solid = scene.dimension() == 3;
  const auto body = surface_actor(surface, is_solid ? Shading{0.5, 0.7} : Shading{1, 0});
  body->GetMapper()->SetColorModeToDirectScalars();
  if (scene.dimension() == 1)
    body->GetProperty()->SetLineWidth(12);
  Props props{body};
  if (scene.dimension() > 1 && least_spacing(scene.specimen.grid) * pixels_per_metre >= 5)
    props.push_back(edge_actor(surface, true, 0.18, 1, view, pixels_per_metre));
  return props;
}

Props fibre_actors(const Scene& scene, const View& view, double pixels_per_metre) {
  if (!scene.has_fibres() || scene.dimension() == 1)
    return {};
  int stride = 1;
  const std::vector<SeenFace> faces = thinned(seen_faces(scene, view), stride);
  const double half = 0.42 * stride * least_spacing(scene.specimen.grid);
  FacingShapes at_rest(view), pulling(view);
  const double width = std::max(1.4 / pixels_per_metre, 0.05 * half);
  const std::vector<bool> contracts = contracting_cells(scene);
  for (const SeenFace& face : faces) {
    const bool pulls = contracts[face.cell];
    if (!pulls && scene.materials[scene.specimen.material(face.cell)].elasticity.is_isotropic())
      continue;
    FacingShapes& strokes = pulls ? pulling : at_rest;
    const Vec3 fibre = scene.specimen.fibre_of(face.cell);
    const double right = half * dot(fibre, view.right), up = half * dot(fibre, view.up);
    const double length = std::hypot(right, up);
    if (length < width) {
      strokes.add_disc(face.middle, 1.2 * width);
      continue;
    }
    const double c = right / length * width, s = up / length * width;
    strokes.add(face.middle,
                {{-right - s, -up + c}, {-right + s, -up - c}, {right + s, up - c}, {right - s, up + c}});
  }
  Props props;
  for (const auto& [shapes, colour] : {std::pair(&at_rest, fibre_colour), std::pair(&pulling, loaded_colour)})
    props.push_back(shapes->actor(colour, 6 / pixels_per_metre));
  return props;
}

Props condition_actors(const Scene& scene, const std::vector<Arrow>& arrows, const View& view,
                       double pixels_per_metre) {
  const Specimen& body = scene.specimen;
  const double radius =
      std::clamp(0.28 * least_spacing(body.grid), 1.6 / pixels_per_metre, 6 / pixels_per_metre);
  FacingShapes held(view), moved(view), loaded(view), sprung(view);
  add_faces(body, scene.tractions, view, radius, loaded);
  add_faces(body, scene.springs, view, 0.6 * radius, sprung);
  std::int64_t last_held = -1, last_moved = -1;
  for (const Prescribed& one : scene.prescribed) { // sorted by component, then node, so nodes repeat
    std::int64_t& last = one.held ? last_held : last_moved;
    if (one.node != last)
      (one.held ? held : moved).add_disc(body.position(body.grid.node_at(one.node)), radius);
    last = one.node;
  }
  Props props;
  for (const auto& [shapes, colour] : {std::pair(&sprung, sprung_colour), std::pair(&loaded, loaded_colour),
                                       std::pair(&held, held_colour), std::pair(&moved, moved_colour)})
    props.push_back(shapes->actor(colour, 9 / pixels_per_metre));
  for (const Arrow& arrow : arrows) {
    FacingShapes one(view);
    one.add_arrow(arrow, 5 / pixels_per_metre);
    props.push_back(one.actor(arrow.colour, 2 * (view.width + view.height + view.depth)));
  }
  return props;
}

} // namespace maille::studies
