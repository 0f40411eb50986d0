#include "body_grid.hpp"
#include "maille/base/vectors.hpp"

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkIdTypeArray.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPoints.h>

namespace maille::studies {
namespace {

/// Corner (bit a: upper side along axis a) for each vertex of VTK's line, quad and hexahedron, which go
/// around a face, while our numbers run along rows. The first two and four serve the lower dimensions.
constexpr std::array<int, 8> corner_at{0, 1, 3, 2, 4, 5, 7, 6};

int cell_type(int dimension) {
  return dimension == 1 ? VTK_LINE : dimension == 2 ? VTK_QUAD : VTK_HEXAHEDRON;
}

} // namespace

vtkSmartPointer<vtkImageData> image_grid(const Specimen& specimen) {
  const Grid& grid = specimen.grid;
  const Placement& placement = specimen.placement;
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(grid.nodes().data());
  Vec3 spacing = grid.spacing();
  for (std::size_t axis = grid.dimension(); axis < 3; ++axis)
    spacing[axis] = spacing[0]; // without extent, but VTK inverts the matrix of spacings
  image->SetSpacing(spacing.data());
  const Vec3 origin = plus(placement.origin, to_world(placement, specimen.origin));
  image->SetOrigin(origin.data());
  vtkNew<vtkMatrix3x3> direction;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      direction->SetElement(row, column, placement.direction[row][column]);
  image->SetDirectionMatrix(direction);
  return image;
}

vtkSmartPointer<vtkUnstructuredGrid> cell_grid(const Specimen& specimen, const BodyNumbering& numbering,
                                               bool placed) {
  const Grid& grid = specimen.grid;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(numbering.nodes.size()));
  const std::int64_t first = numbering.nodes.empty() ? 0 : numbering.nodes.front(),
                     end = numbering.nodes.empty() ? 0 : numbering.nodes.back() + 1;
  std::vector<vtkIdType> point_of(end - first, -1);
  vtkIdType next = 0;
  for (const std::int64_t node : numbering.nodes) {
    Vec3 position = specimen.position(grid.node_at(node));
    if (placed)
      position = plus(specimen.placement.origin, to_world(specimen.placement, position));
    points->SetPoint(next, position.data());
    point_of[node - first] = next++;
  }

  vtkNew<vtkCellArray> cells;
  const int n_corners = grid.corners_per_cell();
  cells->AllocateExact(static_cast<vtkIdType>(numbering.cells.size()),
                       static_cast<vtkIdType>(numbering.cells.size()) * n_corners);
  for (const std::int64_t cell : numbering.cells) {
    cells->InsertNextCell(n_corners);
    const Index3 at = grid.cell_at(cell);
    for (int place = 0; place < n_corners; ++place)
      cells->InsertCellPoint(point_of[grid.corner(at, corner_at[place]) - first]);
  }
  auto body = vtkSmartPointer<vtkUnstructuredGrid>::New();
  body->SetPoints(points);
  body->SetCells(cell_type(grid.dimension()), cells);
  return body;
}

vtkSmartPointer<vtkDoubleArray> vector_array(const char* name, const Displacement& displacement,
                                             const Placement& placement, const BodyNumbering& numbering) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(3);
  constexpr std::array<const char*, 3> axis_names{"X", "Y", "Z"};
  for (int axis = 0; axis < 3; ++axis)
    array->SetComponentName(axis, axis_names[axis]);
  array->SetNumberOfTuples(static_cast<vtkIdType>(numbering.nodes.size()));
  vtkIdType tuple = 0;
  for (const std::int64_t node : numbering.nodes)
    array->SetTuple(tuple++, to_world(placement, displacement.at(node)).data());
  return array;
}

} // namespace maille::studies
