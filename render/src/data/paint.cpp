// Colours on the voxels of an object that replace those of its look.

#include "maille/render/volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace maille::render {

namespace {

constexpr std::size_t padding = 8; // vectors read four bytes for one

std::uint32_t packed(const Rgb& colour) {
  std::uint32_t bits = 0;
  for (std::size_t a = 0; a < 3; ++a)
    bits |= static_cast<std::uint32_t>(std::lround(std::clamp(colour[a], 0.0f, 1.0f) * 255)) << (8 * a);
  return bits;
}

/// Interpolates in a list of colours that are equally spaced from 0 to 1.
Rgb colour_along(std::span<const Rgb> colours, double at) {
  const double place = std::clamp(at, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(place), colours.size() - 1);
  const auto next = std::min(first + 1, colours.size() - 1);
  const auto part = static_cast<float>(place - static_cast<double>(first));
  Rgb colour{};
  for (std::size_t a = 0; a < 3; ++a)
    colour[a] = colours[first][a] + part * (colours[next][a] - colours[first][a]);
  return colour;
}

} // namespace

std::shared_ptr<const Paint> Paint::labels(const VoxelGrid& grid, std::vector<std::uint8_t> numbers,
                                           const std::array<Rgb, 256>& colours, bool keeps_own) {
  std::shared_ptr<Paint> paint(new Paint(grid, Kind::labels));
  paint->keeps_own_ = keeps_own;
  paint->numbers_ = std::move(numbers);
  paint->numbers_.resize(paint->numbers_.size() + padding);
  for (const Rgb& colour : colours)
    paint->palette_.push_back(packed(colour));
  return paint;
}

std::shared_ptr<const Paint> Paint::field(const VoxelGrid& grid, std::span<const float> values, double low,
                                          double high, std::span<const Rgb> colours) {
  std::shared_ptr<Paint> paint(new Paint(grid, Kind::field));
  const double scale = high > low ? 255 / (high - low) : 0;
  for (const float value : values) {
    const double number = (value - low) * scale + 0.5;
    paint->numbers_.push_back(static_cast<std::uint8_t>(number > 0 ? std::min(number, 255.0) : 0));
  }
  paint->numbers_.resize(paint->numbers_.size() + padding);
  for (int i = 0; i < 256; ++i)
    paint->palette_.push_back(packed(colour_along(colours, i / 255.0)));
  return paint;
}

std::shared_ptr<const Paint> Paint::picture(const VoxelGrid& grid, std::span<const std::uint8_t> rgb) {
  std::shared_ptr<Paint> paint(new Paint(grid, Kind::picture));
  paint->pixels_.reserve(rgb.size() / 3);
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3)
    paint->pixels_.push_back(rgb[i] | static_cast<std::uint32_t>(rgb[i + 1]) << 8 |
                             static_cast<std::uint32_t>(rgb[i + 2]) << 16);
  return paint;
}

std::int64_t Paint::bytes() const {
  return static_cast<std::int64_t>(numbers_.size() + 4 * (pixels_.size() + palette_.size()));
}

std::vector<Rgb> field_colours() {
  // From dark blue over red to yellow, lightness rising evenly; chosen for this project.
  return {{0.06f, 0.03f, 0.29f}, {0.24f, 0.05f, 0.51f}, {0.44f, 0.09f, 0.54f},
          {0.63f, 0.16f, 0.48f}, {0.80f, 0.27f, 0.37f}, {0.92f, 0.41f, 0.25f},
          {0.97f, 0.58f, 0.16f}, {0.97f, 0.77f, 0.22f}, {0.98f, 0.94f, 0.47f}};
}

} // namespace maille::render
