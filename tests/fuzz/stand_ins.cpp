/// Stand-ins for the parts of Maille that fuzzers are built without: what draws.

#include "choose/choose.hpp"
#include "export/answer_fields.hpp"
#include "gnuplot.hpp"
#include "picture/comparison_picture.hpp"
#include "picture/question_picture.hpp"
#include "study/plan/study_table.hpp"
#include "view/seen_scene.hpp"

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

std::string_view table_csv() {
  return {};
}

} // namespace maille::studies
