/// Lists of files for ParaView, and fields of an answer in a file; without VTK, which writes the files.
#include "export/vtk_files.hpp"
#include "export/whole_file.hpp"

#include <fmt/format.h>
#include <pugixml.hpp>

#include <algorithm>
#include <sstream>

namespace maille::studies {
namespace fs = std::filesystem;

void ExportFields::show(const Answer& answer) {
  displacement = &answer.displacement;
  reaction = &answer.reaction;
  strain_energy = answer.strain_energy;
  nodal_strain = &answer.nodal_strain;
  nodal_stress = &answer.nodal_stress;
  cell_strain = &answer.cell_strain;
  has_stress = maille::has_stress(answer.method);
}

namespace {

/// Root element of a list of files of this type.
pugi::xml_node root_of(pugi::xml_document& document, const char* type, const char* version) {
  document.append_child(pugi::node_comment).set_value(std::string(provenance_of_list).c_str());
  pugi::xml_node root = document.append_child("VTKFile");
  root.append_attribute("type") = type;
  root.append_attribute("version") = version;
  root.append_attribute("byte_order") = "LittleEndian";
  return root.append_child(type);
}

/// Path of `file` in a list in `folder`.
std::string as_listed(const fs::path& file, const fs::path& folder) {
  return fs::absolute(file).lexically_normal().lexically_relative(folder.lexically_normal()).generic_string();
}

void write_list(const pugi::xml_document& document, const fs::path& file) {
  std::ostringstream text;
  document.save(text, "  ");
  write_whole(file, text.view());
}

} // namespace

void write_pvd(const std::vector<PvdEntry>& entries, const fs::path& pvd) {
  pugi::xml_document document;
  pugi::xml_node collection = root_of(document, "Collection", "0.1");
  const fs::path folder = fs::absolute(pvd).parent_path();
  for (const PvdEntry& entry : entries) {
    pugi::xml_node data_set = collection.append_child("DataSet");
    data_set.append_attribute("timestep") = fmt::format("{}", entry.time).c_str(); // shortest that reads back
    data_set.append_attribute("part") = entry.part;
    data_set.append_attribute("file") = as_listed(entry.file, folder).c_str();
  }
  write_list(document, pvd);
}

void write_blocks(const std::vector<NamedBlock>& blocks, const fs::path& vtm) {
  pugi::xml_document document;
  pugi::xml_node list = root_of(document, "vtkMultiBlockDataSet", "1.0");
  const fs::path folder = fs::absolute(vtm).parent_path();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    pugi::xml_node data_set = list.append_child("DataSet");
    data_set.append_attribute("index") = i;
    data_set.append_attribute("name") = blocks[i].name.c_str();
    data_set.append_attribute("file") = as_listed(blocks[i].file, folder).c_str();
  }
  write_list(document, vtm);
}

PvdSeries::PvdSeries(fs::path stem, std::size_t n_steps)
    : stem_(std::move(stem)),
      n_digits_(std::max(4, static_cast<int>(fmt::formatted_size("{}", n_steps > 0 ? n_steps - 1 : 0)))) {}

fs::path PvdSeries::add(const Scene& scene, ExportFields fields, double time) {
  fields.time = time;
  fs::path step_stem = stem_;
  step_stem += fmt::format("_{:0{}}", entries_.size(), n_digits_);
  entries_.push_back({time, write_vtk(scene, fields, step_stem)});
  return entries_.back().file;
}

fs::path PvdSeries::write() const {
  fs::path pvd = stem_;
  pvd += ".pvd";
  write_pvd(entries_, pvd);
  return pvd;
}

} // namespace maille::studies
