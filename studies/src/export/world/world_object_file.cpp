#include "export/world/world_object_file.hpp"

#include "export/body_grid.hpp"
#include "export/data_set_parts.hpp"

#include <Eigen/Geometry>

#include <vtkCellData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLUnstructuredGridWriter.h>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

void add_points(vtkUnstructuredGrid& body, const BodyNumbering& numbering, const std::vector<Vec3>& now,
                const std::vector<Vec3>& start) {
  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("Displacement");
  displacement->SetNumberOfComponents(3);
  displacement->SetNumberOfTuples(body.GetNumberOfPoints());
  vtkIdType point = 0;
  for (const std::int64_t node : numbering.nodes) {
    const Vec3 &x = now[node], &from = start[node];
    body.GetPoints()->SetPoint(point, x.data());
    displacement->SetTuple3(point++, x[0] - from[0], x[1] - from[1], x[2] - from[2]);
  }
  body.GetPointData()->AddArray(displacement);
  body.GetPointData()->SetActiveVectors("Displacement");
}

void add_object_id(vtkCellData& arrays, std::size_t object, const BodyNumbering& numbering) {
  vtkNew<vtkIntArray> id;
  id->SetName("ObjectId");
  for (std::size_t i = 0; i < numbering.cells.size(); ++i)
    id->InsertNextValue(static_cast<int>(object));
  arrays.AddArray(id);
  arrays.SetActiveScalars("ObjectId");
}

/// Placement of an object in the world, as in an image header.
Placement placement_of(const WorldObject& object) {
  Placement placement;
  placement.origin = object.position;
  const Eigen::AngleAxisd turn(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  const Eigen::Matrix3d direction = turn.toRotationMatrix();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      placement.direction[row][column] = direction(row, column);
  return placement;
}

/// Displacement of the nodes of a deformable object in its own frame.
Displacement in_own_frame(const WorldObject& object, const std::vector<Vec3>& now) {
  const Specimen& body = object.scene.specimen;
  Displacement u(body.grid);
  const Eigen::AngleAxisd turn(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  const Eigen::Matrix3d back = turn.toRotationMatrix().transpose();
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    const Eigen::Vector3d x =
        back * (Eigen::Vector3d::Map(now[node].data()) - Eigen::Vector3d::Map(object.position.data()));
    const Vec3 rest = body.position(body.grid.node_at(node));
    for (int b = 0; b < body.grid.dimension(); ++b)
      u(b, node) = x[b] - rest[b];
  }
  return u;
}

} // namespace

void write_world_object(const WorldScene& world, std::size_t object, const WorldMoment& moment,
                        const std::vector<Vec3>& start, const std::string& provenance, const fs::path& file,
                        LengthUnit unit) {
  const WorldObject& what = world.objects[object];
  const std::vector<Vec3>& now = *moment.objects[object];
  const BodyNumbering numbering = matter_only(what.scene.specimen);
  const auto body = cell_grid(what.scene.specimen, numbering, false);
  add_points(*body, numbering, now, start);
  const Placement placement = placement_of(what);
  add_object_id(*body->GetCellData(), object, numbering);
  add_matter(*body->GetCellData(), what.scene, placement, numbering);
  if (what.kind == ObjectKind::deformable)
    add_strain_and_stress(*body->GetCellData(), what.scene,
                          FieldsOfCells(what.scene, in_own_frame(what, now)), placement, numbering,
                          has_stress(world.method));
  vtkFieldData& field = *body->GetFieldData();
  add_text(field, "ObjectName", what.name);
  if (what.kind == ObjectKind::deformable)
    add_names(field, what.scene);
  add_units(field, placement,
            "lengths: m; all vectors and tensors in the world's frame; Displacement: m; FiberDirection: 1; "
            "Strain, FiberStrain, PrincipalStrain: 1, tensor shear; VonMises, FiberStress, Stress: Pa; "
            "TimeValue: s");
  add_text(field, "Provenance", provenance);
  vtkNew<vtkDoubleArray> time;
  time->SetName("TimeValue");
  time->InsertNextValue(moment.time);
  field.AddArray(time);
  if (unit == LengthUnit::millimetre)
    use_millimetres(*body);
  write_data_set(*vtkNew<vtkXMLUnstructuredGridWriter>(), *body, file);
}

} // namespace maille::studies
