/// What stands in for parts of Maille that fuzzers are built without.

#include "choose/built_in_table.hpp"
#include "export/answer_fields.hpp"
#include "gnuplot.hpp"
#include "image/dicom_files.hpp"
#include "maille/materials/fault.hpp"
#include "maille/studies/picture/comparison_picture.hpp"
#include "maille/studies/picture/question_picture.hpp"
#include "maille/studies/study_table.hpp"
#include "support/temporary_folder.hpp"
#include "view/seen_scene.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

/// For maille::available_memory() (the linker's --wrap): sizes are held against this.
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv();
extern "C" std::int64_t __wrap__ZN6maille16available_memoryEv() {
  return std::int64_t{1} << 20;
}

namespace {

using maille::image_formats::DicomHeader;

/// Numbers as they stand in the file; it needs no GDCM.
std::vector<DicomHeader> headers(const std::vector<std::string>& files) {
  std::vector<DicomHeader> all;
  for (const std::string& file : files) {
    std::array<char, 128> bytes{};
    const std::string text = std::filesystem::is_regular_file(file) ? maille::test::text_of(file) : "";
    text.copy(bytes.data(), bytes.size());
    std::array<double, 14> number{};
    std::memcpy(number.data(), bytes.data(), sizeof number);
    const auto flag = [&](std::size_t at) { return static_cast<unsigned char>(bytes[112 + at]); };
    DicomHeader& header = all.emplace_back();
    header.is_dicom = !text.empty();
    header.is_damaged = flag(0) == 'd';
    header.series = std::string(1, static_cast<char>('a' + flag(1) % 2));
    header.modality = flag(2) == 'S' ? "SEG" : "CT";
    header.columns = flag(3) - 1;
    header.rows = flag(4) - 1;
    header.frames = flag(5);
    header.samples = flag(6);
    header.has_position = header.has_orientation = header.has_spacing = flag(7) != 'n';
    std::copy_n(number.begin(), 3, header.position.begin());
    std::copy_n(number.begin() + 3, 3, header.along[0].begin());
    std::copy_n(number.begin() + 6, 3, header.along[1].begin());
    header.row_spacing = number[9];
    header.column_spacing = number[10];
    header.thickness = number[11];
    header.slope = number[12];
    header.intercept = number[13];
  }
  return all;
}

std::string pixels(const std::string& file, std::vector<double>& values) {
  const DicomHeader header = headers({file}).front();
  values.assign(static_cast<std::size_t>(std::max(0, header.rows) * std::max(0, header.columns)), 1);
  return "";
}

} // namespace

/// For maille::open_plugin(), of which readers open DICOM's alone.
extern "C" const void* __wrap__ZN6maille11open_pluginEPKcS1_mPKv(const char*, const char*, std::size_t,
                                                                 const void*);
extern "C" const void* __wrap__ZN6maille11open_pluginEPKcS1_mPKv(const char* /*file*/, const char* /*what*/,
                                                                 std::size_t /*layout*/,
                                                                 const void* /*host*/) {
  static constexpr maille::image_formats::DicomFunctions functions{headers, pixels};
  return &functions;
}

namespace maille::studies {

std::optional<std::string> why_no_gnuplot() {
  return "no plots";
}
void run_gnuplot(const std::string& /*commands*/) {}
std::string gnuplot_quoted(const std::string& text) {
  return text;
}
std::optional<std::string> render_comparison(const Scene& /*scene*/, const std::vector<PicturePanel>& /*of*/,
                                             const std::filesystem::path& /*png*/,
                                             const PictureSettings& /*settings*/) {
  return "no pictures";
}
std::optional<std::string> render_question(const Scene& /*scene*/, const std::filesystem::path& /*png*/,
                                           const QuestionPictureSettings& /*settings*/) {
  return "no pictures";
}
std::optional<std::string> render_slice(const Scene& /*scene*/, const std::vector<SlicePanel>& /*panels*/,
                                        const std::string& /*quantity*/, double /*unit*/,
                                        const std::filesystem::path& /*png*/,
                                        const QuestionPictureSettings& /*settings*/) {
  return "no pictures";
}
bool is_scene_of_a_patient(std::string_view text) {
  return text.size() % 2 == 0; // either
}
DrawBody draw_grey_values(const Scene& /*scene*/, const std::filesystem::path& /*file*/, int /*threads*/) {
  return {};
}
AnswerFields read_answer_fields(const Scene& scene, const std::filesystem::path& /*file*/) {
  return {Displacement(scene.specimen.grid), {}, {}, {}};
}
std::optional<std::string> draw_study(const std::vector<StudyRow>& /*rows*/, const std::string& /*title*/,
                                      const std::filesystem::path& /*file*/, const std::string& /*column*/) {
  return "no plots";
}

std::string_view built_in_table_text() {
  return {};
}

} // namespace maille::studies
