#include "body_actors.hpp"

#include "export/body_grid.hpp"

#include <vtkActor.h>
#include <vtkFeatureEdges.h>
#include <vtkGeometryFilter.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTubeFilter.h>

#include <algorithm>
#include <array>

namespace maille::studies {
namespace {

using Actors = std::vector<vtkSmartPointer<vtkProp>>;
constexpr std::array<double, 3> ink{0.10, 0.12, 0.16};

vtkSmartPointer<vtkUnstructuredGrid> body_at(const Scene& scene, const BodyNumbering& numbering,
                                             const Displacement* displacement, const Displacement* shown,
                                             const BodyStyle& style) {
  auto body = cell_grid(scene.specimen, numbering, false);
  if (displacement == nullptr)
    return body;
  vtkNew<vtkDoubleArray> lengths;
  lengths->SetName("length");
  lengths->SetNumberOfTuples(body->GetNumberOfPoints());
  for (vtkIdType point = 0; point < body->GetNumberOfPoints(); ++point) {
    const std::int64_t node = numbering.nodes[static_cast<std::size_t>(point)];
    body->GetPoints()->SetPoint(point, drawn_position(scene, *displacement, style.warp, node).data());
    lengths->SetValue(point, length_of(*shown, node) / style.colour_unit);
  }
  body->GetPointData()->SetScalars(lengths);
  return body;
}

vtkSmartPointer<vtkGeometryFilter> surface_of(const vtkSmartPointer<vtkUnstructuredGrid>& body) {
  auto surface = vtkSmartPointer<vtkGeometryFilter>::New();
  surface->SetInputData(body);
  return surface;
}

vtkSmartPointer<vtkActor> actor_of(vtkAlgorithmOutput* shape) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(shape);
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  return actor;
}

/// How much of its colour a surface shows whatever the light, and how much of it with the light.
struct Shading {
  double ambient, diffuse;
};
constexpr Shading flat{1, 0}, faceted{0.5, 0.75}, round{0.55, 0.45};

vtkSmartPointer<vtkActor> coloured(vtkAlgorithmOutput* shape, const BodyStyle& style,
                                   const Shading& shading) {
  const auto actor = actor_of(shape);
  auto& mapper = *static_cast<vtkPolyDataMapper*>(actor->GetMapper());
  mapper.ScalarVisibilityOn();
  mapper.SetLookupTable(style.colours);
  mapper.UseLookupTableScalarRangeOn();
  mapper.InterpolateScalarsBeforeMappingOn(); // else a cell with far ends shows colours that are on no scale
  vtkProperty& property = *actor->GetProperty();
  // Light and ambient light stay below 1 together, and flat shapes take none: colours must be read off the
  // scale.
  property.SetAmbient(shading.ambient);
  property.SetDiffuse(shading.diffuse);
  property.SetSpecular(0);
  return actor;
}

/// Moves an actor towards the viewer (or away, < 0): under a parallel view that changes only what hides what.
void bring_forward(vtkActor& actor, const View& view, double distance) {
  actor.SetPosition(distance * view.toward[0], distance * view.toward[1], distance * view.toward[2]);
}

vtkSmartPointer<vtkActor> lines(vtkAlgorithmOutput* shape, double opacity, const BodyStyle& style,
                                const View& view) {
  const auto actor = actor_of(shape);
  vtkProperty& property = *actor->GetProperty();
  property.SetColor(ink[0], ink[1], ink[2]);
  property.SetOpacity(opacity);
  property.SetLineWidth(static_cast<float>(style.line_width));
  property.LightingOff();
  constexpr double pixels_forward =
      3; // in front of the faces that they edge, also where those are seen aslant
  bring_forward(*actor, view, pixels_forward * style.line_width / style.pixels_per_metre);
  return actor;
}

/// The body at rest: a grey shape behind everything, and its sharp edges unless voxels make steps everywhere.
Actors rest_actors(const Scene& scene, const BodyNumbering& numbering, const BodyStyle& style,
                   const View& view) {
  const auto surface = surface_of(body_at(scene, numbering, nullptr, nullptr, style));
  const auto shape = actor_of(surface->GetOutputPort());
  shape->GetProperty()->SetColor(0.88, 0.89, 0.91);
  shape->GetProperty()->LightingOff();
  bring_forward(*shape, view, -3 * (view.width + view.height + view.depth));
  Actors actors{shape};
  const bool is_masked = numbering.cells.size() != static_cast<std::size_t>(scene.specimen.grid.n_cells());
  if (scene.dimension() == 2 || !is_masked) {
    vtkNew<vtkFeatureEdges> edges;
    edges->SetInputConnection(surface->GetOutputPort());
    edges->BoundaryEdgesOn();
    edges->NonManifoldEdgesOff();
    edges->ColoringOff();
    actors.push_back(lines(edges->GetOutputPort(), 0.45, style, view));
  }
  return actors;
}

/// A line has no faces: a tube in colours, and the rest shape as a thin tube below it.
Actors line_actors(const Scene& scene, const BodyNumbering& numbering, const Displacement& displacement,
                   const Displacement& shown, const BodyStyle& style, const View& view) {
  const double radius = 0.25 * view.height;
  const auto tube_around = [&](const Displacement* moved, double tube_radius) {
    const auto line = surface_of(body_at(scene, numbering, moved, &shown, style));
    vtkNew<vtkTubeFilter> tube;
    tube->SetInputConnection(line->GetOutputPort());
    tube->SetRadius(tube_radius);
    tube->SetNumberOfSides(48);
    return vtkSmartPointer<vtkTubeFilter>(tube);
  };
  const auto rest = actor_of(tube_around(nullptr, radius / 7)->GetOutputPort());
  rest->GetProperty()->SetColor(0.72, 0.74, 0.77);
  rest->GetProperty()->LightingOff();
  rest->SetPosition(0, -1.6 * radius, 0);
  return {coloured(tube_around(&displacement, radius)->GetOutputPort(), style, round), rest};
}

} // namespace

vtkSmartPointer<vtkColorTransferFunction> viridis(double end) {
  constexpr std::array<std::array<int, 3>, 9> anchors{{{68, 1, 84},
                                                       {71, 45, 123},
                                                       {59, 82, 139},
                                                       {44, 114, 142},
                                                       {33, 145, 140},
                                                       {40, 174, 128},
                                                       {94, 201, 98},
                                                       {173, 220, 48},
                                                       {253, 231, 37}}};
  auto colours = vtkSmartPointer<vtkColorTransferFunction>::New();
  colours->SetColorSpaceToLab();
  colours->SetNanColor(0.85, 0.30, 0.25);
  for (std::size_t i = 0; i < anchors.size(); ++i)
    colours->AddRGBPoint(end * static_cast<double>(i) / (anchors.size() - 1), anchors[i][0] / 255.0,
                         anchors[i][1] / 255.0, anchors[i][2] / 255.0);
  return colours;
}

Actors body_actors(const Scene& scene, const Displacement& displacement, const Displacement& shown,
                   const BodyStyle& style, const View& view) {
  const BodyNumbering numbering = matter_only(scene.specimen);
  if (scene.dimension() == 1)
    return line_actors(scene, numbering, displacement, shown, style, view);
  const auto surface = surface_of(body_at(scene, numbering, &displacement, &shown, style));
  const auto body = coloured(surface->GetOutputPort(), style, scene.dimension() == 3 ? faceted : flat);
  body->GetProperty()->SetInterpolationToFlat(); // faces of voxels are flat
  Actors actors = rest_actors(scene, numbering, style, view);
  actors.push_back(body);
  const auto& spacing = scene.specimen.grid.spacing();
  const double smallest =
      *std::min_element(spacing.begin(), spacing.begin() + scene.dimension()) * style.pixels_per_metre;
  constexpr double told_apart = 5; // pixels
  if (smallest >= told_apart * style.line_width) {
    vtkNew<vtkFeatureEdges> edges;
    edges->SetInputConnection(surface->GetOutputPort());
    edges->FeatureEdgesOff(); // then the edges between two faces, sharp or not, are "manifold"
    edges->ManifoldEdgesOn();
    edges->ColoringOff();
    actors.push_back(lines(edges->GetOutputPort(), 0.25, style, view));
  }
  return actors;
}

} // namespace maille::studies
