#include "maille/live/timeline.hpp"

#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace maille::live {

namespace {

/// Upper bound of the memory of all cached copies of the world [bytes].
constexpr std::int64_t most_copies = std::int64_t{256} << 20;
constexpr std::int64_t frames_between_copies = 40;

WorldScene with(const WorldScene& base, const std::vector<WorldSetting>& settings) {
  WorldScene scene = base;
  apply_settings(settings, scene);
  return scene;
}

} // namespace

Timeline::Timeline(WorldScene scene, std::vector<WorldSetting> settings,
                   const std::optional<std::filesystem::path>& record)
    : base_(std::move(scene)), settings_(std::move(settings)), record_(record),
      world_(std::make_unique<deform::World>(with(base_, settings_))),
      drives_(std::make_unique<deform::TrajectoryDrives>(*world_)) {
  rewrite();
  if (!record_fault_.empty())
    throw std::runtime_error(record_fault_);
}

Timeline::~Timeline() {
  if (file_ != nullptr)
    std::fclose(file_);
}

void Timeline::begin_gesture() {
  gesture_begins_ = true;
}

/// The rows are authoritative: spans are read back from them.
std::vector<DriveSpan> Timeline::as_read(std::vector<DriveSpan>& spans, std::string& rows) const {
  for (DriveSpan& span : spans) {
    span.first_frame = played_ + 1;
    span.n_frames = 1;
    rows += trajectory_row(span, scene());
  }
  if (spans.empty())
    rows = trajectory_row(played_ + 1);
  return spans.empty() ? std::vector<DriveSpan>{}
                       : parse_trajectory(trajectory_header() + rows, "frame.csv", scene()).spans;
}

deform::FrameResult Timeline::play(const std::vector<DriveSpan>& spans, const deform::FrameBudget& budget) {
  const std::vector<deform::Drive> asked = drives_->begin_frame(*world_, spans, played_ + 1);
  deform::FrameResult result = world_->advance(asked, budget);
  ++played_;
  return result;
}

deform::FrameResult Timeline::add_frame(std::vector<DriveSpan> spans, const deform::FrameBudget& budget) {
  if (can_redo()) {
    frames_.resize(played_);
    copies_.erase(copies_.upper_bound(played_), copies_.end());
  }
  Frame frame;
  frame.begins_gesture = std::exchange(gesture_begins_, false);
  frame.spans = as_read(spans, frame.rows);
  if (frame.begins_gesture || played_ % frames_between_copies == 0)
    keep_copy();
  append(frame.rows);
  frames_.push_back(std::move(frame));
  return play(frames_.back().spans, budget);
}

deform::FrameResult Timeline::settle(const deform::FrameBudget& budget) {
  return add_frame({}, budget);
}

void Timeline::keep_copy() {
  if (copies_.contains(played_))
    return;
  if (auto copy = world_->copy())
    copies_.emplace(played_, std::move(*copy));
  std::int64_t bytes = 0;
  for (const auto& [at, copy] : copies_)
    bytes += copy.bytes();
  while (bytes > most_copies && copies_.size() > 1) { // every other one: older copies are sparser
    auto copy = copies_.begin();
    if (copies_.size() > 2)
      ++copy;
    bytes -= copy->second.bytes();
    copies_.erase(copy);
  }
}

/// Restores the world at a frame not later than `at_most`.
void Timeline::restart(std::int64_t at_most) {
  const auto after = copies_.upper_bound(at_most);
  if (after != copies_.begin()) {
    if (auto copy = std::prev(after)->second.copy()) {
      world_ = std::make_unique<deform::World>(std::move(*copy));
      played_ = std::prev(after)->first;
      return;
    }
  }
  world_ = std::make_unique<deform::World>(with(base_, settings_));
  played_ = 0;
}

void Timeline::go_to(std::int64_t frame, const deform::FrameBudget& budget,
                     const std::function<void()>& at_each) {
  frame = std::clamp<std::int64_t>(frame, 0, n_frames());
  if (frame < played_)
    restart(frame);
  while (played_ < frame && !(budget.stop_requested && budget.stop_requested())) {
    play(frames_[played_].spans, budget);
    if (at_each)
      at_each();
  }
  gesture_begins_ = true;
  rewrite();
}

void Timeline::undo(const deform::FrameBudget& budget) {
  std::int64_t to = played_;
  while (to > 0 && !frames_[to - 1].begins_gesture)
    --to;
  go_to(std::max<std::int64_t>(0, to - 1), budget);
}

void Timeline::redo(const deform::FrameBudget& budget) {
  std::int64_t to = played_ + 1;
  while (to < n_frames() && !frames_[to].begins_gesture)
    ++to;
  go_to(to, budget);
}

void Timeline::change(const WorldSetting& setting, const deform::FrameBudget& budget,
                      const std::function<void()>& at_each) {
  std::vector<WorldSetting> settings = settings_;
  std::erase_if(settings, [&](const WorldSetting& old) {
    return old.name == setting.name && old.object == setting.object;
  });
  settings.push_back(setting);
  auto world = std::make_unique<deform::World>(with(base_, settings)); // throws before any change
  const std::int64_t frame = std::exchange(played_, 0);
  settings_ = std::move(settings);
  world_ = std::move(world);
  drives_ = std::make_unique<deform::TrajectoryDrives>(*world_);
  copies_.clear();
  go_to(frame, budget, at_each);
}

std::string Timeline::text() const {
  std::string text = trajectory_header();
  for (const WorldSetting& setting : settings_)
    text += trajectory_row(setting, scene());
  for (std::int64_t i = 0; i < played_; ++i)
    text += frames_[i].rows;
  return text;
}

void Timeline::append(const std::string& rows) {
  if (file_ == nullptr || rows.empty())
    return;
  if (std::fwrite(rows.data(), 1, rows.size(), file_) != rows.size() || std::fflush(file_) != 0)
    record_fault_ = fmt::format("{}: cannot be written: {}", record_->string(), std::strerror(errno));
}

/// Writes a complete new file and replaces the old one atomically.
void Timeline::rewrite() {
  if (!record_)
    return;
  if (file_ != nullptr)
    std::fclose(std::exchange(file_, nullptr));
  std::filesystem::path fresh;
  std::error_code error;
  std::FILE* file = nullptr;
  const auto there = std::filesystem::symlink_status(*record_, error);
  try {
    if ((std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) ||
        is_kept_input(*record_))
      throw std::filesystem::filesystem_error("", std::make_error_code(std::errc::file_exists));
    file = fdopen(create_beside(*record_, fresh), "wb");
    const std::string all = text();
    if (file == nullptr || std::fwrite(all.data(), 1, all.size(), file) != all.size() ||
        std::fflush(file) != 0)
      throw std::filesystem::filesystem_error("", std::error_code(errno, std::generic_category()));
    std::filesystem::rename(fresh, *record_); // `file` stays the same file
    file_ = file;
  } catch (const std::filesystem::filesystem_error& fault) {
    record_fault_ = fmt::format("{}: cannot be written: {}", record_->string(), fault.code().message());
    if (file != nullptr)
      std::fclose(file);
    if (!fresh.empty())
      std::filesystem::remove(fresh, error);
  }
}

} // namespace maille::live
