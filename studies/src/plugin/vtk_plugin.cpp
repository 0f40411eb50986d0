/// Entry point of the shared object maille-vtk.so, which contains the code that uses VTK.

#include "export/whole_file.hpp"
#include "plugin/vtk_functions.hpp"

namespace maille::studies {
namespace {

const VtkHost* program = nullptr;

constexpr VtkFunctions functions{
    .write_vtk_file = write_vtk,
    .write_object = write_world_object,
    .read_fields = read_answer_fields,
    .comparison = render_comparison,
    .question = render_question,
    .slice = render_slice,
    .world = render_world,
    .picture = read_picture,
};

} // namespace

/// Calls the program's own function: only the program tracks its inputs and unfinished files.
void write_whole(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write) {
  program->write_whole(file, write);
}

void write_whole(const std::filesystem::path& file, std::string_view text) {
  program->write_whole_text(file, text);
}

} // namespace maille::studies

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* host) {
  if (layout != maille::studies::vtk_layout)
    return nullptr;
  maille::studies::program = static_cast<const maille::studies::VtkHost*>(host);
  return &maille::studies::functions;
}
