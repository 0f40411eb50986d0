/// Files and pictures for programs that start without VTK: the first one opens the plugin.

#include "export/whole_file.hpp"
#include "maille/materials/text_file.hpp"
#include "plugin/vtk_functions.hpp"

namespace maille::studies {
namespace {

const VtkFunctions& plugin() {
  static constexpr VtkHost host{.write_whole = write_whole, .write_whole_text = write_whole};
  static const auto* const functions = static_cast<const VtkFunctions*>(
      open_plugin("maille-vtk.so", "files and pictures (VTK)", vtk_layout, &host));
  return *functions;
}

} // namespace

std::filesystem::path write_vtk(const Scene& scene, const ExportFields& fields,
                                const std::filesystem::path& stem) {
  return plugin().write_vtk_file(scene, fields, stem);
}

void write_world_object(const WorldScene& world, std::size_t object, const WorldMoment& moment,
                        const std::vector<Vec3>& start, const std::string& provenance,
                        const std::filesystem::path& file, LengthUnit unit) {
  plugin().write_object(world, object, moment, start, provenance, file, unit);
}

AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& file) {
  note_opened(file); // the plugin does not track opened files
  std::error_code none;
  for (const auto& piece : std::filesystem::directory_iterator(file.parent_path() / file.stem(), none))
    note_opened(piece.path());
  return plugin().read_fields(scene, file);
}

std::optional<std::string> render_comparison(const Scene& scene, const std::vector<PicturePanel>& panels,
                                             const std::filesystem::path& png,
                                             const PictureSettings& settings) {
  return plugin().comparison(scene, panels, png, settings);
}

std::optional<std::string> render_question(const Scene& scene, const std::filesystem::path& png,
                                           const QuestionPictureSettings& settings) {
  return plugin().question(scene, png, settings);
}

std::optional<std::string> render_slice(const Scene& scene, const std::vector<SlicePanel>& panels,
                                        const std::string& quantity, double unit,
                                        const std::filesystem::path& png,
                                        const QuestionPictureSettings& settings) {
  return plugin().slice(scene, panels, quantity, unit, png, settings);
}

std::optional<std::string> render_world(const WorldScene& world, const std::vector<WorldPanel>& panels,
                                        const std::filesystem::path& png,
                                        const WorldPictureSettings& settings) {
  return plugin().world(world, panels, png, settings);
}

ColourPicture read_picture(const std::filesystem::path& file) {
  note_opened(file);
  return plugin().picture(file);
}

} // namespace maille::studies
