#include "report/body_pictures.hpp"

#include "export/answer_fields.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "picture/comparison_picture.hpp"
#include "picture/question_picture.hpp"
#include "text.hpp"
#include "view/seen_scene.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <limits>
#include <map>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

using Data = nlohmann::ordered_json;

/// Answer of one method for the page.
struct DrawnAnswer {
  std::string method;
  std::optional<double> error, estimated_error; ///< relative L2
  AnswerFields fields;
};

/// Text of an entry; empty if it is no text.
std::string text_of(const Data& object, std::string_view key) {
  const Data& text = json_entry(object, key);
  return text.is_string() ? text.get<std::string>() : "";
}

/// Draws into a temporary folder.
class Pictures {
public:
  Pictures(const Data& results, const fs::path& folder);
  Data drawn;

private:
  void read_answers(const Data& results, const fs::path& folder);
  void draw_question();
  void draw_slice();
  void draw_overview();
  void draw_map(const DrawnAnswer& answer);
  /// Adds the rendered picture to a list, or a note with the reason of its failure.
  void add(Data& list, const std::optional<std::string>& why_not, std::string alt, std::string caption);
  std::optional<std::string> render(const std::vector<PicturePanel>& panels, PictureSettings settings) {
    settings.is_anatomical = is_anatomical_;
    return render_comparison(*scene_, panels, png_, settings);
  }
  /// Draws grey values; empty if the scene has no grey-value look, or has moved.
  DrawBody draw_body();
  QuestionPictureSettings settings_of(int largest_height) const {
    QuestionPictureSettings settings;
    settings.is_anatomical = is_anatomical_;
    settings.largest_height = largest_height;
    return settings;
  }
  void note(const std::string& text) { drawn["notes"].push_back(text); }

  std::optional<Scene> scene_;
  fs::path scene_file_;
  std::string reference_;
  std::vector<DrawnAnswer> answers_; ///< in the order of first rows; the last row of each method
  WorkFolder work_{"maille_report"};
  fs::path png_ = work_ / "picture.png";
  bool is_anatomical_ = false;
};

Pictures::Pictures(const Data& results, const fs::path& folder)
    : drawn{{"notes", Data::array()},
            {"body", Data::array()},
            {"pictures", Data::array()},
            {"maps", Data::object()}} {
  const auto tried = [&](const auto& step) {
    try {
      step();
      return true;
    } catch (const nlohmann::json::exception&) {
      note(fmt::format("no pictures of {}: its list of results has another form", text_of(results, "scene")));
      return false;
    } catch (const std::exception& error) {
      note(fmt::format("no pictures of {}: {}", text_of(results, "scene"), error.what()));
      return false;
    }
  };
  if (!tried([&] { read_answers(results, folder); }))
    answers_.clear();
  if (scene_)
    tried([&] {
      draw_question();
      draw_slice();
      draw_overview();
      for (const DrawnAnswer& answer : answers_)
        draw_map(answer);
    });
}

void Pictures::read_answers(const Data& results, const fs::path& folder) {
  const std::string text = results.at("scene_text").get<std::string>();
  is_anatomical_ = is_scene_of_a_patient(text);
  scene_file_ = results.at("scene_file").get<std::string>();
  scene_ = parse_scene(text, scene_file_.string());
  std::map<std::string, fs::path> files;
  for (const Data& entry : json_entry(results, "files"))
    files.emplace(entry.at("method").get<std::string>(),
                  folder / fs::path(entry.at("file").get<std::string>()).filename());
  for (const Data& comparison : json_entry(results, "results"))
    for (const Data& row : json_entry(comparison, "results")) {
      const std::string method = row.at("method").get<std::string>();
      const auto error_of = [&](const char* key) {
        return number_in(json_entry(json_entry(row, key), "relative_l2"));
      };
      auto answer = std::ranges::find(answers_, method, &DrawnAnswer::method);
      if (const auto file = files.find(method); answer == answers_.end() && file != files.end())
        answer = answers_.insert(answer, {method, {}, {}, read_answer_fields(*scene_, file->second)});
      if (answer != answers_.end()) {
        answer->error = error_of("error");
        answer->estimated_error = error_of("estimated_error");
      }
    }
  if (const Data& all = json_entry(results, "results"); all.is_array() && !all.empty())
    reference_ = text_of(all.front(), "reference");
}

void Pictures::add(Data& list, const std::optional<std::string>& why_not, std::string alt,
                   std::string caption) {
  if (why_not)
    return note("no pictures: " + *why_not);
  const std::string bytes = read_own_text_file(png_, "a picture", std::numeric_limits<std::int64_t>::max());
  std::string base64(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  // The cast is for the library's own byte type; it appends a zero.
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  base64.resize(length);
  list.push_back({{"source", "data:image/png;base64," + base64},
                  {"look", "picture"},
                  {"alt", std::move(alt)},
                  {"caption", std::move(caption)}});
}

DrawBody Pictures::draw_body() {
  try {
    return fs::exists(scene_file_) ? draw_grey_values(*scene_, scene_file_, 1) : DrawBody();
  } catch (const std::exception& error) {
    note(std::string("no picture of grey values: ") + error.what());
    return {};
  }
}

void Pictures::draw_question() {
  drawn["question"] = question_of(*scene_);
  add(drawn["body"], render_question(*scene_, png_, settings_of(760)),
      "The body at rest, coloured by label or material, with its fibres and what is done to it",
      "The body at rest: its parts, fibres, and what holds, moves and loads it");
}

void Pictures::draw_slice() {
  if (answers_.empty() || scene_->dimension() < 2)
    return;
  std::vector<SlicePanel> panels;
  for (const DrawnAnswer& answer : answers_) {
    SlicePanel& panel = panels.emplace_back(SlicePanel{answer.method, &answer.fields.displacement, {}});
    for (const auto& strain : cell_fields(*scene_, answer.fields.displacement).strain)
      panel.values.push_back(principal_values(strain)[0]);
  }
  add(drawn["body"],
      render_slice(*scene_, panels, "largest principal strain in %", 0.01, png_, settings_of(700)),
      "A layer of cells through the deformed body, coloured by the largest principal strain",
      scene_->dimension() == 3 ? "Strain in a layer through the middle of the body" : "Strain in the body");
}

void Pictures::draw_overview() {
  if (answers_.empty())
    return;
  std::vector<PicturePanel> panels;
  std::string names;
  for (const DrawnAnswer& answer : answers_) {
    panels.push_back({answer.method, &answer.fields.displacement, answer.error, answer.method == reference_});
    names += (names.empty() ? "" : ", ") + answer.method;
  }
  add(drawn["pictures"], render(panels, {}),
      "The deformed body as answered by " + names + ", coloured by the length of the displacement",
      "The answers beside each other, in one view and one scale of colours");
  PictureSettings by_grey_values;
  by_grey_values.draw_body = draw_body();
  if (by_grey_values.draw_body)
    add(drawn["pictures"], render(panels, by_grey_values),
        "The deformed body as answered by " + names + ", by its grey values",
        "The same answers with the grey values of the image inside");
}

void Pictures::draw_map(const DrawnAnswer& answer) {
  const AnswerFields& fields = answer.fields;
  std::vector<PicturePanel> panels;
  if (fields.error)
    panels.push_back({"against " + reference_, &fields.displacement, answer.error, false, &*fields.error});
  if (fields.estimate)
    panels.push_back({"estimated", &fields.displacement, answer.estimated_error, false, &*fields.estimate});
  if (panels.empty())
    return;
  PictureSettings settings;
  settings.quantity = "error";
  settings.width = 1100;
  settings.largest_height = 520;
  add(drawn["maps"][answer.method], render(panels, settings),
      "The deformed body as answered by " + answer.method + ", coloured by the length of the error",
      fields.error && fields.estimate
          ? "Where the error sits: the true one, and the estimate without finite elements"
      : fields.error ? "Where the error sits"
                     : "Where the error sits, as estimated without finite elements");
}

} // namespace

Data drawn_bodies(const Data& results, const fs::path& folder) {
  return Pictures(results, folder).drawn;
}

} // namespace maille::studies
