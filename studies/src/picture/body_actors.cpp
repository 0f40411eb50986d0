#include "body_actors.hpp"

#include "drawing.hpp"
#include "export/body_grid.hpp"

#include <vtkCellData.h>
#include <vtkGeometryFilter.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace maille::studies {
namespace {

/// @param shown  whose lengths its points have; null: they have no values
vtkSmartPointer<vtkPolyData> surface_at(const Scene& scene, const BodyNumbering& numbering,
                                        const Displacement* displacement, const Displacement* shown,
                                        const BodyStyle& style) {
  const auto body = cell_grid(scene.specimen, numbering, false);
  if (displacement == nullptr)
    return surface_of(*body);
  vtkNew<vtkDoubleArray> lengths;
  lengths->SetName("length");
  lengths->SetNumberOfTuples(body->GetNumberOfPoints());
  for (vtkIdType point = 0; point < body->GetNumberOfPoints(); ++point) {
    const std::int64_t node = numbering.nodes[point];
    body->GetPoints()->SetPoint(point, drawn_position(scene, *displacement, style.warp, node).data());
    lengths->SetValue(point, length_of(*shown, node) / style.colour_unit);
  }
  body->GetPointData()->SetScalars(lengths);
  return surface_of(*body);
}

/// The body at rest: a grey shape in the background, with its sharp edges unless it consists of voxel steps.
Props rest_actors(const Scene& scene, const BodyNumbering& numbering, const BodyStyle& style,
                  const View& view) {
  const auto surface = surface_at(scene, numbering, nullptr, nullptr, style);
  const auto shape = flat_actor(surface, grey_at_rest);
  bring_forward(*shape, view, -3 * (view.width + view.height + view.depth));
  Props props{shape};
  const bool is_masked = numbering.cells.size() != static_cast<std::size_t>(scene.specimen.grid.n_cells());
  if (scene.dimension() == 2 || !is_masked)
    props.push_back(edge_actor(surface, false, 0.45, style.line_width, view, style.pixels_per_metre));
  return props;
}

/// A line has no faces: it is a coloured tube, with the rest shape as a thin tube below it.
Props line_actors(const Scene& scene, const BodyNumbering& numbering, const Displacement& displacement,
                  const Displacement& shown, const BodyStyle& style, const View& view) {
  const double radius = 0.25 * view.height;
  const auto tube_around = [&](const Displacement* moved, double tube_radius) {
    vtkNew<vtkTubeFilter> tube;
    tube->SetInputData(surface_at(scene, numbering, moved, &shown, style));
    tube->SetRadius(tube_radius);
    tube->SetNumberOfSides(48);
    tube->Update();
    return vtkSmartPointer<vtkPolyData>(tube->GetOutput());
  };
  const auto rest = flat_actor(tube_around(nullptr, radius / 7), {0.72, 0.74, 0.77});
  rest->SetPosition(0, -1.6 * radius, 0);
  const auto body = surface_actor(tube_around(&displacement, radius), {0.55, 0.45});
  body->GetProperty()->SetInterpolationToGouraud();
  colour_by(*body, *style.colours);
  return {body, rest};
}

} // namespace

vtkSmartPointer<vtkPolyData> surface_of(vtkDataSet& body) {
  vtkNew<vtkGeometryFilter> surface;
  surface->SetInputData(&body);
  surface->Update();
  return surface->GetOutput();
}

void colour_by(vtkActor& actor, vtkColorTransferFunction& colours) {
  vtkMapper& mapper = *actor.GetMapper();
  mapper.SetLookupTable(&colours);
  mapper.UseLookupTableScalarRangeOn();
  mapper.InterpolateScalarsBeforeMappingOn(); // else large cells leave the scale
}

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

Props body_actors(const Scene& scene, const Displacement& displacement, const Displacement& shown,
                  const BodyStyle& style, const View& view) {
  const BodyNumbering numbering = matter_only(scene.specimen);
  if (scene.dimension() == 1)
    return line_actors(scene, numbering, displacement, shown, style, view);
  const auto surface = surface_at(scene, numbering, &displacement, &shown, style);
  // Diffuse and ambient light are below 1 in sum, and flat shapes have no diffuse light, so that colours can
  // be compared with the scale.
  const auto body = surface_actor(surface, scene.dimension() == 3 ? Shading{0.5, 0.75} : Shading{1, 0});
  colour_by(*body, *style.colours);
  Props props = rest_actors(scene, numbering, style, view);
  props.push_back(body);
  constexpr double told_apart = 5; // pixels
  if (least_spacing(scene.specimen.grid) * style.pixels_per_metre >= told_apart * style.line_width)
    props.push_back(edge_actor(surface, true, 0.25, style.line_width, view, style.pixels_per_metre));
  return props;
}

namespace {

/// Colours that are distinct for colour-blind readers (M. Okabe, K. Ito, 2002).
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
  int most_ = 0; ///< largest material number
  vtkSmartPointer<vtkColorTransferFunction> scale_;
};

/// A line's cells are drawn as a band about it.
vtkSmartPointer<vtkPolyData> placed_surface(const Specimen& body, const BodyNumbering& numbering,
                                            const std::vector<Vec3>& positions, vtkDataArray& colours) {
  vtkSmartPointer<vtkDataSet> shape;
  if (body.grid.dimension() == 1) {
    const double half = 0.35 * body.grid.spacing()[0];
    std::vector<Shape> band;
    for (const std::int64_t cell : numbering.cells) {
      const double x = positions[body.grid.corner(body.grid.cell_at(cell), 0)][0],
                   end = positions[body.grid.corner(body.grid.cell_at(cell), 1)][0];
      band.push_back({{x, -half, 0}, {end, -half, 0}, {end, half, 0}, {x, half, 0}});
    }
    shape = data_of(band);
  } else {
    const auto grid = cell_grid(body, numbering, false);
    vtkIdType point = 0;
    for (const std::int64_t node : numbering.nodes)
      grid->GetPoints()->SetPoint(point++, positions[node].data());
    shape = grid;
  }
  shape->GetCellData()->SetScalars(&colours);
  return surface_of(*shape);
}

} // namespace

Vec3 object_colour(const WorldScene& world, std::size_t object) {
  if (world.objects[object].kind == ObjectKind::fixed)
    return {0.74, 0.74, 0.76};
  std::size_t place = 0; // index among moving objects
  for (std::size_t i = 0; i < object; ++i)
    place += world.objects[i].kind == ObjectKind::fixed ? 0 : 1;
  const auto& colour = palette[place % palette.size()];
  const std::size_t round = place / palette.size(); // lighter in every round of the palette
  const double light = 1 - std::pow(0.6, static_cast<double>(round));
  Vec3 mixed;
  for (std::size_t c = 0; c < 3; ++c)
    mixed[c] = light + (1 - light) * colour[c] / 255.0;
  return mixed;
}

Props object_actors(const WorldScene& world, std::size_t object, const std::vector<Vec3>& positions,
                    const View& view, double pixels_per_metre) {
  const WorldObject& what = world.objects[object];
  const Specimen& body = what.scene.specimen;
  const BodyNumbering numbering = matter_only(body);
  const CellColours colours(world, object);
  vtkNew<vtkUnsignedCharArray> shown;
  shown->SetNumberOfComponents(3);
  for (const std::int64_t cell : numbering.cells)
    shown->InsertNextTypedTuple(colours.of(body.material(cell)).data());
  const auto surface = placed_surface(body, numbering, positions, *shown);
  const bool is_solid = body.grid.dimension() == 3, is_deformable = what.kind == ObjectKind::deformable;
  const auto actor = surface_actor(surface, is_solid ? Shading{0.45, 0.7} : Shading{1, 0});
  actor->GetMapper()->SetColorModeToDirectScalars();
  Props props{actor};
  if (least_spacing(body.grid) * pixels_per_metre >= (is_deformable || is_solid ? 4 : 2))
    props.push_back(
        edge_actor(surface, is_deformable, is_deformable ? 0.35 : 0.5, 1, view, pixels_per_metre));
  return props;
}

} // namespace maille::studies
