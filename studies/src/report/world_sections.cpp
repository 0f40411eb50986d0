/// Sections of what was played and what was probed.

#include "page_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

double size_of(const PageData& vector) {
  double squares = 0;
  for (const PageData& value : vector)
    squares += value.is_number() ? std::pow(value.get<double>(), 2) : 0;
  return std::sqrt(squares);
}

/// What two objects, or one and its drive, did to each other over all frames.
struct Touch {
  std::int64_t frames = 0;
  double largest = 0; ///< [N]
};

std::string in_newtons(double newtons) {
  return fmt::format("{:.4g} N", newtons);
}

/// Visits what acts in a frame, under a name of its own.
template<class Visit>
void for_each_force(const PageData& frame, Visit&& visit) {
  for (const PageData& drive : at(frame, "drives"))
    visit("drive of " + plain(at(drive, "object")), size_of(at(drive, "force")));
  for (const PageData& contact : at(frame, "contacts"))
    visit(plain(at(contact, "object")) + " against " + plain(at(contact, "other")),
          size_of(at(contact, "force")));
}

void add_forces_of_frames(const PageData& frames, const std::string& id, PageData& run, PageDraft& draft) {
  std::map<std::string, Touch> touches;
  SeriesByMethod over_time;
  const double step = at(frames, "frame_seconds").is_number() ? at(frames, "frame_seconds").get<double>() : 1;
  for (const PageData& frame : at(frames, "frames")) {
    const PageData number = at(frame, "frame");
    for_each_force(frame, [&](const std::string& name, double force) {
      Touch& touch = touches[name];
      ++touch.frames;
      touch.largest = std::max(touch.largest, force);
      if (number.is_number() && force > 0)
        over_time.add(name, step * number.get<double>(), force);
    });
  }
  PageData table{{"id", id},
                 {"caption", "What objects and drives did to each other"},
                 {"columns", {column("what", false), column("frames", true), column("largest force", true)}},
                 {"rows", PageData::array()}};
  for (const auto& [name, touch] : touches)
    table["rows"].push_back(
        {{"cells",
          {text_cell(name), number_cell(fmt::format("{}", touch.frames), touch.frames),
           number_cell(touch.largest > 0 ? in_newtons(touch.largest) : "–", touch.largest)}}});
  if (!touches.empty())
    run["table"] = table;
  constexpr std::size_t most_series = 8;
  if (!over_time.series.empty() && over_time.series.size() <= most_series)
    if (auto figure =
            plot({"time [s]", "force [N]", false, false, true, over_time.series},
                 "Plot of the forces over time; the table has the largest", "Forces over time", draft))
      run["plots"].push_back(*figure);
}

void add_row(PageData& table, const char* name, std::string value) {
  if (value != "–" && !value.empty())
    table["rows"].push_back({{"cells", {text_cell(name), text_cell(std::move(value))}}});
}

std::string with_unit(const PageData& value, const char* unit) {
  return value.is_number() ? fmt::format("{:.4g} {}", value.get<double>(), unit) : "–";
}

} // namespace

void add_play_section(const PageData& results, const PageData& frames, const std::vector<fs::path>& moments,
                      PageDraft& draft) {
  const PageData& named = results.is_object() ? results : frames;
  const std::string scene = plain(at(named, "scene")), id = id_of(scene + "-play");
  const PageData title = at(results, "title"), trajectory = at(frames, "trajectory");
  PageData run{{"id", id}, {"heading", "Play: " + (title.is_string() ? plain(title) : scene)}};
  run["question"] =
      "How do the objects of this world move when they are driven, where do they touch, and with "
      "what force?";
  const PageData method = at(named, "method");
  std::string summary = fmt::format("{}, by {}", scene, method.is_string() ? plain(method) : "its methods");
  if (trajectory.is_string())
    summary += fmt::format(", driven by {}", plain(trajectory));
  if (at(frames, "frames").is_array())
    summary +=
        fmt::format("; {} of {} frames", at(frames, "frames").size(), plain(at(frames, "frames_asked")));
  else if (at(results, "moments").is_number())
    summary += fmt::format("; {} moments", plain(at(results, "moments")));
  run["summary"] = summary + ".";
  run["notes"] = PageData::array();
  run["plots"] = PageData::array();
  run["body"] = PageData::array();
  constexpr std::size_t most_pictures = 4;
  const std::size_t n = std::min(most_pictures, moments.size());
  for (std::size_t i = 0; i < n; ++i) {
    const fs::path& file = moments[n == 1 ? 0 : i * (moments.size() - 1) / (n - 1)];
    run["body"].push_back(picture_of_file(file, "The world at one moment: " + file.filename().string(),
                                          file.filename().string()));
  }
  add_forces_of_frames(frames, id + "-table", run, draft);
  add_what_was_asked(results, run);
  draft.runs.push_back(std::move(run));
}

void add_probe_section(const PageData& probe, const std::string& name, const std::vector<fs::path>& pictures,
                       PageDraft& draft) {
  const PageData title = at(probe, "title");
  PageData run{{"id", id_of(name + "-probe")},
               {"heading", "Probe: " + (title.is_string() ? plain(title) : name)}};
  run["question"] =
      "What does a hand feel that touches this body with a tool, and does the loop keep its time?";
  const PageData period = at(probe, "period_s");
  run["summary"] =
      fmt::format("{} ticks{}, {}; a tool of {} voxels, {} deformable bodies.", plain(at(probe, "ticks")),
                  period.is_number() && period.get<double>() > 0
                      ? fmt::format(" at {:.4g} a second", 1 / period.get<double>())
                      : "",
                  at(probe, "in_real_time") == true ? "in real time" : "without a clock",
                  plain(at(probe, "tool_voxels")), plain(at(probe, "deformable_bodies")));
  run["notes"] = PageData::array();
  if (const PageData inside = at(probe, "penetrations"); inside.is_number() && inside.get<double>() > 0)
    run["notes"].push_back(
        fmt::format("The tool was in matter in {} of {} looks: forces there are not to be believed.",
                    plain(inside), plain(at(probe, "looks"))));
  run["body"] = PageData::array();
  for (const fs::path& file : pictures)
    run["body"].push_back(
        picture_of_file(file, "Force and latency over time; the table has the figures", "Over time"));
  PageData table{{"id", id_of(name + "-probe-table")},
                 {"caption", "What was felt, and what it cost"},
                 {"columns", {column("figure", false), column("value", false)}},
                 {"rows", PageData::array()}};
  add_row(table, "largest force", with_unit(at(probe, "force", "largest_n"), "N"));
  add_row(table, "mean force while touching", with_unit(at(probe, "force", "mean_touching_n"), "N"));
  add_row(table, "largest torque", with_unit(at(probe, "force", "largest_torque_nm"), "N m"));
  add_row(table, "ticks in touch", plain(at(probe, "force", "touching_ticks")));
  const PageData deepest = at(probe, "bodies", "deepest_m");
  add_row(table, "deepest indentation",
          deepest.is_number() ? fmt::format("{:.4g} mm", 1e3 * deepest.get<double>()) : "–");
  add_row(table, "slowest answer of a body", seconds(at(probe, "bodies", "slowest_answer_s")));
  add_row(table, "stiffness of the coupling", with_unit(at(probe, "passivity", "stiffness"), "N/m"));
  add_row(table, "least energy of the device", with_unit(at(probe, "passivity", "least_energy_j"), "J"));
  add_row(table, "missed deadlines", plain(at(probe, "missed_deadlines")));
  run["table"] = table;
  add_what_was_asked(probe, run);
  draft.runs.push_back(std::move(run));
}

} // namespace maille::studies
