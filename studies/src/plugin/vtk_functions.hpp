#pragma once
/// Interface of programs to the VTK plugin, maille-vtk.so: files for ParaView and pictures.

#include "export/answer_fields.hpp"
#include "export/world/world_object_file.hpp"
#include "maille/plugins/open_plugin.hpp"
#include "picture/comparison_picture.hpp"
#include "picture/question_picture.hpp"
#include "picture/read_picture.hpp"
#include "picture/world_picture.hpp"

#include <functional>
#include <string_view>

namespace maille::studies {

/// Functions of the public headers that require VTK.
struct VtkFunctions {
  decltype(&write_vtk) write_vtk_file;
  decltype(&write_world_object) write_object;
  decltype(&read_answer_fields) read_fields;
  decltype(&render_comparison) comparison;
  decltype(&render_question) question;
  decltype(&render_slice) slice;
  decltype(&render_world) world;
  decltype(&read_picture) picture;
};

/// Functions of the program for the plugin: the program tracks its inputs and the files to delete on a
/// signal.
struct VtkHost {
  void (*write_whole)(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path&)>& write);
  void (*write_whole_text)(const std::filesystem::path& file, std::string_view text);
};

inline constexpr std::size_t vtk_layout =
    layout_of<VtkFunctions, VtkHost, Scene, Answer, ExportFields, WorldScene, WorldMoment, AnswerFields,
              PicturePanel, PictureSettings, QuestionPictureSettings, SlicePanel, WorldPanel,
              WorldPictureSettings, ColourPicture>();

} // namespace maille::studies
