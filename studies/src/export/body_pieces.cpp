#include "body_pieces.hpp"

#include "export/whole_file.hpp"

#include <fmt/format.h>
#include <pugixml.hpp>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

constexpr const char* name_of_layers = "Layers";

/// `n` numbers of a list starting at `first`; empty for an empty list.
template<class List>
List part_of(const List& whole, std::int64_t first, std::int64_t n) {
  return whole.empty() ? List() : List(whole.begin() + first, whole.begin() + first + n);
}

/// A scene of some layers, without prescribed components.
Scene layers_of(const Scene& scene, const Layers& layers) {
  const Specimen& body = scene.specimen;
  const Index3& n = body.grid.cells();
  const std::int64_t in_layer = std::int64_t{1} * n[0] * n[1], first = layers.first * in_layer,
                     cells = (layers.end - layers.first) * in_layer;
  Scene part;
  part.name = scene.name;
  part.materials = scene.materials;
  part.plane = scene.plane;
  part.active_stress = part_of(scene.active_stress, first, cells);
  Specimen& of = part.specimen;
  of.shape = body.shape;
  of.grid = Grid(3, {n[0], n[1], layers.end - layers.first}, body.grid.spacing());
  of.origin = body.position({0, 0, layers.first});
  of.placement = body.placement;
  of.material_id = part_of(body.material_id, first, cells);
  of.fibre = body.fibre;
  of.fibres = part_of(body.fibres, first, cells);
  of.label = part_of(body.label, first, cells);
  of.tissue = part_of(body.tissue, first, cells);
  of.stiffness_ratio = part_of(body.stiffness_ratio, first, cells);
  return part;
}

Displacement part_of(const Displacement& whole, const Grid& grid, std::int64_t first) {
  Displacement part(grid);
  for (std::size_t c = 0; c < part.n_components(); ++c)
    std::ranges::copy(whole.component(c).subspan(static_cast<std::size_t>(first), part.n_nodes()),
                      part.component(c).begin());
  return part;
}

std::vector<std::int64_t> shifted(std::vector<std::int64_t> numbers, std::int64_t by) {
  for (std::int64_t& number : numbers)
    number += by;
  return numbers;
}

} // namespace

std::vector<Layers> pieces_of(const Specimen& specimen, std::int64_t cells) {
  const Index3& n = specimen.grid.cells();
  const std::int64_t in_layer = std::int64_t{1} * n[0] * n[1];
  std::vector<Layers> pieces;
  std::int64_t matter = 0;
  Layers piece;
  for (int z = 0; z < n[2]; ++z) {
    for (std::int64_t cell = z * in_layer; cell < (z + 1) * in_layer; ++cell)
      matter += specimen.is_matter(cell) ? 1 : 0;
    piece.end = z + 1;
    if (matter < cells && piece.end < n[2])
      continue;
    if (matter > 0 || pieces.empty())
      pieces.push_back(piece);
    else
      pieces.back().end = piece.end;
    piece.first = piece.end;
    matter = 0;
  }
  return pieces;
}

LayersOfBody::LayersOfBody(const Scene& scene, const ExportFields& fields, const Layers& layers)
    : first_cell_(scene.specimen.grid.cell({0, 0, layers.first})),
      first_node_(scene.specimen.grid.node({0, 0, layers.first})), scene_(layers_of(scene, layers)),
      fields_(fields) {
  const Grid& grid = scene_.specimen.grid;
  const auto cut_displacement = [&](std::size_t which, const Displacement*& of) {
    if (of != nullptr)
      of = &(displacements_[which] = part_of(*of, grid, first_node_));
  };
  cut_displacement(0, fields_.displacement);
  cut_displacement(1, fields_.reference);
  cut_displacement(2, fields_.error_estimate);
  const auto cut_tensors = [&](std::size_t which, const Tensors*& of, std::int64_t first, std::int64_t n) {
    if (of != nullptr)
      of = &(tensors_[which] = part_of(*of, first, n));
  };
  cut_tensors(0, fields_.nodal_strain, first_node_, grid.n_nodes());
  cut_tensors(1, fields_.nodal_stress, first_node_, grid.n_nodes());
  cut_tensors(2, fields_.cell_strain, first_cell_, grid.n_cells());
  if (fields.reaction == nullptr || fields.reaction->empty())
    return;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (const std::int64_t node = scene.prescribed[i].node - first_node_;
        node >= 0 && node < grid.n_nodes()) {
      scene_.prescribed.push_back(scene.prescribed[i]);
      scene_.prescribed.back().node = node;
      reaction_.push_back(fields.reaction->at(i));
    }
  if (reaction_.empty()) { // pieces have the same arrays
    scene_.prescribed.emplace_back();
    reaction_.push_back(0);
  }
  fields_.reaction = &reaction_;
}

BodyNumbering LayersOfBody::numbering(BodyNumbering of_body) const {
  return {shifted(std::move(of_body.nodes), -first_node_), shifted(std::move(of_body.cells), -first_cell_)};
}

fs::path file_of_piece(const fs::path& list, std::size_t piece) {
  return fs::path(list).replace_extension() / fmt::format("{:04}.vtu", piece);
}

void add_layers(vtkFieldData& arrays, const Layers& layers) {
  vtkNew<vtkIntArray> array;
  array->SetName(name_of_layers);
  array->InsertNextValue(layers.first);
  array->InsertNextValue(layers.end);
  arrays.AddArray(array);
}

std::string list_of_pieces(const fs::path& list, std::size_t pieces, vtkDataSet& one) {
  pugi::xml_document document;
  document.append_child(pugi::node_comment).set_value(std::string(provenance_of_list).c_str());
  pugi::xml_node root = document.append_child("VTKFile");
  root.append_attribute("type") = "PUnstructuredGrid";
  root.append_attribute("version") = "1.0";
  root.append_attribute("byte_order") = "LittleEndian";
  pugi::xml_node grid = root.append_child("PUnstructuredGrid");
  grid.append_attribute("GhostLevel") = 0;
  const auto declare = [](pugi::xml_node node, vtkDataArray& array) {
    pugi::xml_node of = node.append_child("PDataArray");
    const int type = array.GetDataType();
    of.append_attribute("type") = type == VTK_UNSIGNED_CHAR ? "UInt8" : type == VTK_INT ? "Int32" : "Float64";
    of.append_attribute("Name") = array.GetName();
    of.append_attribute("NumberOfComponents") = array.GetNumberOfComponents();
    for (int c = 0; c < array.GetNumberOfComponents() && array.HasAComponentName(); ++c)
      of.append_attribute(fmt::format("ComponentName{}", c).c_str()) = array.GetComponentName(c);
  };
  const auto declare_all = [&](const char* name, vtkFieldData& data) {
    pugi::xml_node node = grid.append_child(name);
    for (int i = 0; i < data.GetNumberOfArrays(); ++i)
      if (vtkDataArray* const array = data.GetArray(i))
        declare(node, *array);
  };
  declare_all("PPointData", *one.GetPointData());
  declare_all("PCellData", *one.GetCellData());
  pugi::xml_node points = grid.append_child("PPoints").append_child("PDataArray");
  points.append_attribute("type") = "Float64";
  points.append_attribute("Name") = "Points";
  points.append_attribute("NumberOfComponents") = 3;
  for (std::size_t i = 0; i < pieces; ++i) {
    const fs::path file = file_of_piece(list, i);
    grid.append_child("Piece").append_attribute("Source") =
        (file.parent_path().filename() / file.filename()).generic_string().c_str();
  }
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

} // namespace maille::studies
