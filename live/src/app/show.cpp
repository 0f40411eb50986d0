/// Contents of the window, screenshots and films.

#include "app/app.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

constexpr double film_period = 1.0 / 15;

} // namespace

/// Called when the picture is in the window: latencies end with the displayed picture.
void App::take_picture() {
  const std::shared_ptr<const Painted> painted = in_window_;
  if (!painted || painted->number == shown_picture_)
    return;
  shown_picture_ = painted->number;
  const double now = seconds_now();
  if (report_.pictures == 0)
    report_.first_picture = now - began_;
  if (painted->state->event_time > last_event_shown_) {
    last_event_shown_ = painted->state->event_time;
    // Overtaken events have waited until now, too.
    while (!waiting_events_.empty() && waiting_events_.front() <= last_event_shown_) {
      report_.event_to_picture.push_back(now - waiting_events_.front());
      waiting_events_.pop_front();
    }
    if (last_picture_at_ > 0 && now - last_picture_at_ < 1)
      report_.picture_seconds.push_back(now - last_picture_at_);
    last_picture_at_ = now;
  }
  ++report_.pictures;
}

void App::show() {
  Shown shown;
  shown.text_scale = static_cast<float>(text_scale_);
  const std::shared_ptr<const Painted> painted = painter_ ? painter_->newest() : nullptr;
  if (painted && painted->rgba) {
    shown.width = painted->width;
    shown.height = painted->height;
    shown.rgba = painted->rgba;
    shown.picture_number = painted->number;
  }
  shown.panel = panel();
  if (session_ && state_) {
    shown.texts = corner();
    for (const Eye& eye : eyes()) {
      const Sight seen{*scene_, *state_, eye.looking, eye.width, looking_.view.height};
      std::vector<OverlayLine> lines = seen.marks(text_scale_);
      if (has_rings_)
        for (OverlayLine& line : seen.rings(selected_, drag_ == Drag::ring ? ring_axis_ : -1))
          lines.push_back(std::move(line));
      if (axis_ >= 0)
        lines.push_back(
            seen.axis_line(axis_, grabbed_at_, 2 * ball_about(*scene_, *state_, selected_).second));
      for (OverlayLine& line : lines) {
        for (std::array<float, 2>& point : line.points)
          point[0] += static_cast<float>(eye.left);
        line.colour = eye.colour.value_or(line.colour);
        shown.lines.push_back(std::move(line));
      }
    }
  }
  has_new_numbers_ = false;
  last_shown_ = seconds_now();
  window_.show(shown);
  in_window_ = painted;
  take_picture();
}

/// Position of each eye picture in the window.
std::vector<App::Eye> App::eyes() const {
  const int width = looking_.view.width;
  if (looking_.stereo == Stereo::none || scene_->dimension < 3)
    return {{looking_, width, 0, std::nullopt}};
  const bool is_beside = looking_.stereo == Stereo::side_by_side;
  render::View view = looking_.view;
  if (is_beside)
    view.width = std::max(1, width / 2);
  std::vector<Eye> eyes;
  for (const render::View& seen : render::stereo_views(view, {looking_.eye_separation})) {
    Eye& eye = eyes.emplace_back(looking_, seen.width, 0, std::nullopt);
    eye.looking.view = seen;
    if (is_beside)
      eye.left = eyes.size() > 1 ? seen.width : 0;
    else // through a red filter cyan is dark and red appears white
      eye.colour =
          eyes.size() > 1 ? std::array<float, 4>{1, 0, 0, 1} : std::array<float, 4>{0, 0.8f, 0.8f, 1};
  }
  return eyes;
}

void App::save_shot(std::string file) {
  const bool is_numbered = file.empty(); // keeps pictures of earlier sessions
  while (file.empty() || (is_numbered && std::filesystem::exists(settings_.shots / file)))
    file = fmt::format("maille_{:03}.png", ++shots_);
  const bool is_plain = is_name_of_picture(file);
  file = (settings_.shots / file).string();
  show();
  const std::vector<std::uint8_t> pixels = window_.screenshot();
  const std::string why = !is_plain ? file + ": expected the plain name of a picture, NAME.png"
                          : pixels.empty()
                              ? file + ": there is nothing to be seen"
                              : write_png(file, window_.width(), window_.height(), pixels, tools_.add_mark);
  faults_.clear();
  report_.has_lost = report_.has_lost || !why.empty();
  if (!why.empty())
    say(why);
}

void App::write_film_picture() {
  const double now = seconds_now();
  if (!film_ || now < film_next_)
    return;
  film_next_ = now + film_period;
  const std::vector<std::uint8_t> pixels = window_.screenshot();
  if (pixels.empty())
    return;
  const std::string why = write_png(fmt::format("{}_{:04}.png", film_->string(), film_pictures_),
                                    window_.width(), window_.height(), pixels, tools_.add_mark);
  if (why.empty()) {
    ++film_pictures_;
    return;
  }
  report_.has_lost = true;
  say(why);
}

void App::end_film() {
  if (!film_)
    return;
  const std::filesystem::path stem = *film_;
  film_.reset();
  if (tools_.make_film && film_pictures_ > 0)
    if (const auto why = tools_.make_film(stem, film_pictures_, film_period)) {
      report_.has_lost = true;
      say(*why);
    }
  film_pictures_ = 0;
}

} // namespace maille::live
