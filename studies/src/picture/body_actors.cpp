#include "body_actors.hpp"

#include "drawing.hpp"
#include "export/body_grid.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFeatureEdges.h>
#include <vtkGeometryFilter.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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
    const std::int64_t node = numbering.nodes[point];
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

namespace {

/// Colours that stay apart for the colour-blind (M. Okabe, K. Ito, 2002).
constexpr std::array<std::array<int, 3>, 7> palette{{{0, 114, 178},
                                                     {230, 159, 0},
                                                     {0, 158, 115},
                                                     {204, 121, 167},
                                                     {86, 180, 233},
                                                     {213, 94, 0},
                                                     {240, 228, 66}}};

/// Colours of an object's cells.
class CellColours {
public:
  CellColours(const WorldScene& world, std::size_t object) : base_(object_colour(world, object)) {
    const Specimen& body = world.objects[object].scene.specimen;
    for (const std::uint8_t id : body.material_id)
      most_ = id == no_material ? most_ : std::max(most_, static_cast<int>(id));
    if (most_ > 2)
      scale_ = viridis(most_);
  }
  std::array<unsigned char, 3> of(std::uint8_t material) const {
    Vec3 colour = base_;
    if (scale_ != nullptr)
      scale_->GetColor(material, colour.data());
    else if (most_ > 0)
      for (double& c : colour)
        c += 0.55 * (1 - c) * material / most_;
    std::array<unsigned char, 3> bytes{};
    for (std::size_t i = 0; i < 3; ++i)
      bytes[i] = static_cast<unsigned char>(std::lround(255 * colour[i]));
    return bytes;
  }

private:
  Vec3 base_;
  int most_ = 0; ///< largest number of a material
  vtkSmartPointer<vtkColorTransferFunction> scale_;
};

/// A line's cells as a band about it.
vtkSmartPointer<vtkUnstructuredGrid> band(const Specimen& body, const BodyNumbering& numbering,
                                          const std::vector<Vec3>& positions, double half_height) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> quads;
  for (const std::int64_t cell : numbering.cells) {
    const vtkIdType first = points->GetNumberOfPoints();
    for (const int end : {0, 1}) {
      const Vec3& x = positions[body.grid.corner(body.grid.cell_at(cell), end)];
      points->InsertNextPoint(x[0], -half_height, 0);
      points->InsertNextPoint(x[0], half_height, 0);
    }
    quads->InsertNextCell({first, first + 2, first + 3, first + 1});
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_QUAD, quads);
  return grid;
}

vtkSmartPointer<vtkUnstructuredGrid> placed_body(const Specimen& body, const BodyNumbering& numbering,
                                                 const std::vector<Vec3>& positions) {
  if (body.grid.dimension() == 1)
    return band(body, numbering, positions, 0.35 * body.grid.spacing()[0]);
  auto grid = cell_grid(body, numbering, false);
  vtkIdType point = 0;
  for (const std::int64_t node : numbering.nodes)
    grid->GetPoints()->SetPoint(point++, positions[node].data());
  return grid;
}

vtkSmartPointer<vtkActor> lines_of(vtkGeometryFilter& surface, bool of_every_cell, const View& view,
                                   double pixels_per_metre) {
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputConnection(surface.GetOutputPort());
  edges->SetBoundaryEdges(true);
  edges->SetFeatureEdges(!of_every_cell);
  edges->SetManifoldEdges(of_every_cell);
  edges->SetNonManifoldEdges(false);
  edges->SetFeatureAngle(30);
  edges->ColoringOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(edges->GetOutputPort());
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(ink[0], ink[1], ink[2]);
  actor->GetProperty()->SetOpacity(of_every_cell ? 0.35 : 0.5);
  actor->GetProperty()->LightingOff();
  const double forward = 3 / pixels_per_metre; // in front of the faces that they edge
  actor->SetPosition(forward * view.toward[0], forward * view.toward[1], forward * view.toward[2]);
  return actor;
}

} // namespace

Vec3 object_colour(const WorldScene& world, std::size_t object) {
  if (world.objects[object].kind == ObjectKind::fixed)
    return {0.74, 0.74, 0.76};
  std::size_t place = 0; // among the objects that move
  for (std::size_t i = 0; i < object; ++i)
    place += world.objects[i].kind == ObjectKind::fixed ? 0 : 1;
  const auto& colour = palette[place % palette.size()];
  const std::size_t round = place / palette.size(); // lighter each time that the palette comes round
  const double light = 1 - std::pow(0.6, static_cast<double>(round));
  Vec3 mixed;
  for (std::size_t c = 0; c < 3; ++c)
    mixed[c] = light + (1 - light) * colour[c] / 255.0;
  return mixed;
}

std::vector<vtkSmartPointer<vtkProp>> object_actors(const WorldScene& world, std::size_t object,
                                                    const std::vector<Vec3>& positions, const View& view,
                                                    double pixels_per_metre) {
  const WorldObject& what = world.objects[object];
  const Specimen& body = what.scene.specimen;
  const BodyNumbering numbering = matter_only(body);
  const auto grid = placed_body(body, numbering, positions);
  const CellColours colours(world, object);
  vtkNew<vtkUnsignedCharArray> shown;
  shown->SetNumberOfComponents(3);
  for (const std::int64_t cell : numbering.cells)
    shown->InsertNextTypedTuple(colours.of(body.material(cell)).data());
  grid->GetCellData()->SetScalars(shown);
  vtkNew<vtkGeometryFilter> surface;
  surface->SetInputData(grid);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(surface->GetOutputPort());
  mapper->SetColorModeToDirectScalars();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  const bool is_solid = body.grid.dimension() == 3;
  actor->GetProperty()->SetInterpolationToFlat();
  actor->GetProperty()->SetAmbient(is_solid ? 0.45 : 1);
  actor->GetProperty()->SetDiffuse(is_solid ? 0.7 : 0);
  std::vector<vtkSmartPointer<vtkProp>> actors{actor.Get()};
  const Vec3& spacing = body.grid.spacing();
  const double cell =
      *std::min_element(spacing.begin(), spacing.begin() + body.grid.dimension()) * pixels_per_metre;
  const bool is_deformable = what.kind == ObjectKind::deformable;
  if (cell >= (is_deformable || is_solid ? 4 : 2))
    actors.push_back(lines_of(*surface, is_deformable, view, pixels_per_metre));
  return actors;
}

vtkSmartPointer<vtkProp> dots(const std::vector<Vec3>& points, double radius, const View& view) {
  constexpr int n_corners = 16;
  vtkNew<vtkPoints> corners;
  vtkNew<vtkCellArray> discs;
  for (const Vec3& point : points) {
    discs->InsertNextCell(n_corners);
    for (int i = 0; i < n_corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / n_corners;
      Vec3 corner{};
      for (std::size_t a = 0; a < 3; ++a)
        corner[a] = point[a] + radius * (std::cos(angle) * view.right[a] + std::sin(angle) * view.up[a]) +
                    (view.depth + 2 * radius) * view.toward[a]; // in front of everything
      discs->InsertCellPoint(corners->InsertNextPoint(corner.data()));
    }
  }
  vtkNew<vtkPolyData> shapes;
  shapes->SetPoints(corners);
  shapes->SetPolys(discs);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shapes);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.85, 0.1, 0.15);
  actor->GetProperty()->LightingOff();
  return actor;
}

} // namespace maille::studies
