#include "conditions/loads.hpp"

namespace maille::reader {

namespace {

std::vector<FaceLoad> faces_in(const Region& region, const Asked& where, const Specimen& body,
                               FaultList& faults) {
  auto faces = region.faces(body);
  if (faces.empty())
    faults.add(where.line, where.key, "a region with at least one whole outer face of a cell in it",
               where.text);
  return faces;
}

void pull_at(std::vector<FaceLoad> faces, const Vec3& traction, Scene& scene) {
  for (FaceLoad& face : faces) {
    face.traction = traction;
    scene.tractions.push_back(face);
  }
}

/// Of one cell's face [m^2]; in 2D of a body 1 m thick, in 1D 1.
double area(const Grid& grid, int axis) {
  double area = 1;
  for (int a = 0; a < grid.dimension(); ++a)
    if (a != axis)
      area *= grid.spacing()[static_cast<std::size_t>(a)];
  return area;
}

} // namespace

void add_traction(const Region& region, const Vec3& traction, const Asked& where, Scene& scene,
                  FaultList& faults) {
  pull_at(faces_in(region, where, scene.specimen, faults), traction, scene);
}

void add_force(const Region& region, const Vec3& force, const Asked& where, Scene& scene, FaultList& faults) {
  const auto faces = faces_in(region, where, scene.specimen, faults);
  double total = 0;
  for (const FaceLoad& face : faces)
    total += area(scene.specimen.grid, face.axis);
  pull_at(faces, {force[0] / total, force[1] / total, force[2] / total}, scene);
}

void add_contraction(const std::vector<std::int64_t>& cells, double stress, Scene& scene) {
  if (cells.empty())
    return;
  scene.active_stress.resize(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (const std::int64_t cell : cells)
    scene.active_stress[static_cast<std::size_t>(cell)] += stress;
}

} // namespace maille::reader
