#include "maille/studies/export/world_files.hpp"

#include "body_grid.hpp"
#include "data_set_parts.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <vtkCellData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

/// A name as part of a file's name.
std::string in_file_name(const std::string& name) {
  std::string text;
  for (const char c : name)
    text += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ? c : '_';
  return text;
}

/// Of every object, no two the same: signs that file systems do not share become `_`.
std::vector<std::string> names_in_files(const WorldScene& world) {
  std::vector<std::string> names;
  for (const WorldObject& object : world.objects) {
    const std::string plain = in_file_name(object.name);
    std::string name = plain;
    for (int n = 2; std::find(names.begin(), names.end(), name) != names.end(); ++n)
      name = fmt::format("{}-{}", plain, n);
    names.push_back(name);
  }
  return names;
}

void add_points(vtkUnstructuredGrid& body, const BodyNumbering& numbering, const std::vector<Vec3>& now,
                const std::vector<Vec3>& start) {
  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("Displacement");
  displacement->SetNumberOfComponents(3);
  displacement->SetNumberOfTuples(body.GetNumberOfPoints());
  vtkIdType point = 0;
  for (const std::int64_t node : numbering.nodes) {
    const Vec3 &x = now[static_cast<std::size_t>(node)], &from = start[static_cast<std::size_t>(node)];
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

/// Where an object stands in the world, as an image's header would say it.
Placement placement_of(const WorldObject& object) {
  Placement placement;
  placement.origin = object.position;
  const Eigen::AngleAxisd turn(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  const Eigen::Matrix3d direction = turn.toRotationMatrix();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      placement.direction[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          direction(row, column);
  return placement;
}

/// Where the nodes of a deformable object have gone in its own frame.
Displacement in_own_frame(const WorldObject& object, const std::vector<Vec3>& now) {
  const Specimen& body = object.scene.specimen;
  Displacement u(body.grid);
  const Eigen::AngleAxisd turn(object.turn_angle, Eigen::Vector3d::Map(object.turn_axis.data()));
  const Eigen::Matrix3d back = turn.toRotationMatrix().transpose();
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    const Eigen::Vector3d x = back * (Eigen::Vector3d::Map(now[static_cast<std::size_t>(node)].data()) -
                                      Eigen::Vector3d::Map(object.position.data()));
    const Vec3 rest = body.position(body.grid.node_at(node));
    for (int b = 0; b < body.grid.dimension(); ++b)
      u(b, node) = x[b] - rest[static_cast<std::size_t>(b)];
  }
  return u;
}

} // namespace

WorldSeries::WorldSeries(const WorldScene& world, fs::path stem, std::size_t n_moments,
                         std::string provenance)
    : world_(world), stem_(std::move(stem)),
      n_digits_(std::max(4, static_cast<int>(fmt::formatted_size("{}", n_moments > 0 ? n_moments - 1 : 0)))),
      provenance_(std::move(provenance)), names_(names_in_files(world)), shown_(world.objects.size()) {}

void WorldSeries::write_object(std::size_t object, const WorldMoment& moment, const fs::path& file) const {
  const WorldObject& what = world_.objects[object];
  const std::vector<Vec3>& now = *moment.objects[object];
  const BodyNumbering numbering = matter_only(what.scene.specimen);
  const auto body = cell_grid(what.scene.specimen, numbering, false);
  add_points(*body, numbering, now, *shown_[object].start);
  const Placement placement = placement_of(what);
  add_object_id(*body->GetCellData(), object, numbering);
  add_matter(*body->GetCellData(), what.scene, placement, numbering);
  if (what.kind == ObjectKind::deformable)
    add_strain_and_stress(*body->GetCellData(), what.scene, cell_fields(what.scene, in_own_frame(what, now)),
                          placement, numbering, has_stress(world_.method));
  vtkFieldData& field = *body->GetFieldData();
  add_text(field, "ObjectName", what.name);
  if (what.kind == ObjectKind::deformable)
    add_names(field, what.scene);
  add_text(field, "Units",
           "lengths: m; all vectors and tensors in the world's frame; Displacement: m; FiberDirection: 1; "
           "Strain, FiberStrain, PrincipalStrain: 1, tensor shear; VonMises, FiberStress, Stress: Pa; "
           "TimeValue: s");
  add_text(field, "Provenance", provenance_);
  vtkNew<vtkDoubleArray> time;
  time->SetName("TimeValue");
  time->InsertNextValue(moment.time);
  field.AddArray(time);
  write_data_set(*vtkNew<vtkXMLUnstructuredGridWriter>(), *body, file);
}

void WorldSeries::add(const WorldMoment& moment) {
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    Shown& shown = shown_[i];
    if (!shown.start)
      shown.start = moment.objects[i];
    if (shown.last != moment.objects[i]) {
      fs::path file = stem_;
      file += fmt::format("_{}_{:0{}}.vtu", names_[i], n_moments_, n_digits_);
      write_object(i, moment, file);
      shown.last = moment.objects[i];
      shown.file = file;
      files_.push_back(file);
    }
    entries_.push_back({moment.time, shown.file, static_cast<int>(i)});
  }
  ++n_moments_;
}

fs::path WorldSeries::write() const {
  fs::path pvd = stem_;
  pvd += ".pvd";
  write_pvd(entries_, pvd);
  return pvd;
}

} // namespace maille::studies
