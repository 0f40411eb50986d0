#include "object_actors.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"
#include "export/body_grid.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFeatureEdges.h>
#include <vtkGeometryFilter.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::studies {
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
      const Vec3& x = positions[static_cast<std::size_t>(body.grid.corner(body.grid.cell_at(cell), end))];
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
    grid->GetPoints()->SetPoint(point++, positions[static_cast<std::size_t>(node)].data());
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
  return {colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0};
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
