#include "maille/live/window.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::live {

void HeadlessWindow::put(Event event) {
  events_.push_back(std::move(event));
}

const Widget* HeadlessWindow::widget(std::string_view name) const {
  const auto found = std::ranges::find(shown_.panel, name, &Widget::name);
  return found == shown_.panel.end() ? nullptr : &*found;
}

std::vector<Event> HeadlessWindow::poll(double seconds) {
  if (events_.empty()) {
    std::unique_lock lock(lock_);
    bell_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return is_awake_; });
    is_awake_ = false;
  }
  std::vector<Event> events(std::make_move_iterator(events_.begin()), std::make_move_iterator(events_.end()));
  events_.clear();
  for (const Event& event : events)
    if (event.kind == EventKind::resize) {
      width_ = static_cast<int>(event.x);
      height_ = static_cast<int>(event.y);
    }
  return events;
}

void HeadlessWindow::show(const Shown& shown) {
  shown_ = shown;
}

void HeadlessWindow::wake() {
  {
    const std::lock_guard lock(lock_);
    is_awake_ = true;
  }
  bell_.notify_one();
}

/// Only the picture, by nearest pixels.
std::vector<std::uint8_t> HeadlessWindow::screenshot() {
  std::vector<std::uint8_t> out;
  if (width_ < 1 || height_ < 1 || !shown_.rgba || shown_.width < 1 || shown_.height < 1)
    return out;
  out.resize(std::size_t{4} * width_ * height_);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const auto from =
          static_cast<std::size_t>(y) * shown_.height / static_cast<std::size_t>(height_) * shown_.width +
          x * shown_.width / static_cast<std::size_t>(width_);
      const auto to = static_cast<std::size_t>(y) * width_ + x;
      std::copy_n(shown_.rgba->begin() + static_cast<std::ptrdiff_t>(4 * from), 4,
                  out.begin() + static_cast<std::ptrdiff_t>(4 * to));
    }
  return out;
}

} // namespace maille::live
