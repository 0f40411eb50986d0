#include "maille/live/picture.hpp"
#include "maille/live/window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

namespace maille::live {

namespace {

/// Time limit of a picture during motion [s].
constexpr double fluent = 0.010;
/// Time without changes before a full-resolution picture [s].
constexpr double still = 0.12;
constexpr double coarsest = 0.25;

} // namespace

struct PainterLoop::Asked {
  std::uint64_t number;
  std::shared_ptr<const WorldScene> scene;
  std::shared_ptr<const WorldState> state;
  Looking looking;
};

PainterLoop::PainterLoop(std::unique_ptr<Painter> painter, std::function<void()> has_painted)
    : painter_(std::move(painter)), has_painted_(std::move(has_painted)), thread_([this] { run(); }) {}

PainterLoop::~PainterLoop() {
  is_stopping_ = true;
  ++bell_;
  bell_.notify_all();
  thread_.join();
}

void PainterLoop::look(std::shared_ptr<const WorldScene> scene, std::shared_ptr<const WorldState> state,
                       const Looking& looking) {
  const std::uint64_t number = asked_number_ + 1;
  asked_.store(std::make_shared<const Asked>(Asked{number, std::move(scene), std::move(state), looking}));
  asked_number_ = number;
  ++bell_;
  bell_.notify_one();
}

std::shared_ptr<const Painted> PainterLoop::newest() const {
  return newest_.load();
}

bool PainterLoop::is_idle() const {
  return done_number_ == asked_number_;
}

std::shared_ptr<const Painted> PainterLoop::paint(const Asked& asked, double scale) {
  const double began = seconds_now();
  Looking looking = asked.looking;
  looking.view.width = std::max(1, static_cast<int>(std::lround(scale * asked.looking.view.width)));
  looking.view.height = std::max(1, static_cast<int>(std::lround(scale * asked.looking.view.height)));
  looking.is_rough = scale < 1;
  auto painted = std::make_shared<Painted>();
  try {
    *painted = painter_->paint(*asked.scene, *asked.state, looking);
  } catch (const std::exception&) { // an invalid view: keep the last picture
    return newest_.load();
  }
  painted->looking = looking;
  painted->scene = asked.scene;
  painted->state = asked.state;
  painted->number = ++number_;
  painted->seconds = seconds_now() - began;
  painted->is_whole = scale == 1;
  return painted;
}

void PainterLoop::run() {
  double last_news = 0;
  std::uint64_t coarse = 0; // request number of the last reduced picture
  while (!is_stopping_) {
    const std::uint32_t bell = bell_;
    const std::shared_ptr<const Asked> asked = asked_.load();
    if (!asked || asked->number == done_number_) {
      bell_.wait(bell);
      continue;
    }
    const bool is_new = asked->number != coarse;
    // Time is proportional to the pixels, except a constant part.
    const double scale = whole_only_ || seconds_whole_ <= fluent
                             ? 1
                             : std::max(coarsest, std::floor(8 * std::sqrt(fluent / seconds_whole_)) / 8);
    if (is_new) {
      last_news = seconds_now();
      if (auto painted = paint(*asked, scale)) {
        const double share = scale * scale;
        const double whole = painted->seconds / std::max(0.1, share);
        seconds_whole_ = seconds_whole_ > 0 ? 0.7 * seconds_whole_ + 0.3 * whole : whole;
        newest_.store(std::move(painted));
      }
      if (scale == 1)
        done_number_ = asked->number;
      const bool is_first = std::exchange(has_coarse_, true) == false;
      coarse = asked->number;
      has_painted_();
      if (is_first && scale == 1 && !whole_only_ && seconds_whole_ > fluent)
        paint(*asked, coarsest); // not displayed: prepares data for pictures during motion
      continue;
    }
    if (seconds_now() - last_news < still) { // more may come
      std::this_thread::sleep_for(std::chrono::milliseconds(4));
      continue;
    }
    if (auto painted = paint(*asked, 1))
      newest_.store(std::move(painted));
    done_number_ = asked->number;
    has_painted_();
  }
}

} // namespace maille::live
