#include "bodies/brick_depths.hpp"

#include "data/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace maille::render {

namespace {

constexpr float beyond = 1e30f;
constexpr double slack = 1e-5; ///< of depths: rays are reckoned in single precision

} // namespace

std::vector<Brick> border_bricks(const Volume& volume, const std::vector<std::uint8_t>& distances) {
  const Index3 n = volume.bricks();
  const Index3 stride{1, n[0], n[0] * n[1]};
  std::vector<Brick> border;
  Index3 at{};
  const std::uint8_t* distance = distances.data();
  for (at[2] = 0; at[2] < n[2]; ++at[2])
    for (at[1] = 0; at[1] < n[1]; ++at[1])
      for (at[0] = 0; at[0] < n[0]; ++at[0], ++distance) {
        bool is_border = false;
        for (std::size_t a = 0; a < 3; ++a)
          is_border = is_border || at[a] == 0 || at[a] == n[a] - 1 || distance[-stride[a]] != 0 ||
                      distance[stride[a]] != 0;
        if (*distance == 0 && is_border)
          border.push_back({static_cast<std::uint16_t>(at[0]), static_cast<std::uint16_t>(at[1]),
                            static_cast<std::uint16_t>(at[2])});
      }
  return border;
}

BrickDepths::BrickDepths(const VoxelGrid& grid, const std::vector<Brick>& bricks, const Pose& pose,
                         const View& view)
    : squares_x_((view.width + edge - 1) / edge), squares_y_((view.height + edge - 1) / edge),
      parallel_(view.camera.parallel), middle_x_(0.5 * view.width - 0.5), middle_y_(0.5 * view.height - 0.5) {
  const Camera& camera = view.camera;
  const double half = 0.5 * view.height;
  scale_ = parallel_ ? half / camera.parallel_scale
                     : half / std::tan(0.5 * camera.view_angle * std::numbers::pi / 180);
  const auto axes = camera.axes();
  const auto seen = [&](const Vec3& index) {
    return times(axes, minus(pose.to_world(grid.point_of(index)), camera.position));
  };
  const Vec3 first = seen({0, 0, 0});
  const std::array<Vec3, 3> along{minus(seen({1, 0, 0}), first), minus(seen({0, 1, 0}), first),
                                  minus(seen({0, 0, 1}), first)};
  constexpr double half_edge = 0.5 * Volume::brick_edge;
  Vec3 extent{};
  for (std::size_t a = 0; a < 3; ++a)
    extent[a] = 1.01 * half_edge * (std::abs(along[0][a]) + std::abs(along[1][a]) + std::abs(along[2][a]));
  const auto n_squares = static_cast<std::size_t>(squares_x_) * static_cast<std::size_t>(squares_y_);
  squares_.assign(n_squares, {beyond, -beyond});
  for (const Brick& brick : bricks) {
    Vec3 middle = first;
    for (std::size_t a = 0; a < 3; ++a)
      middle = plus(middle, times(Volume::brick_edge * brick[a] + half_edge, along[a]));
    if (middle[2] - extent[2] <= extent[2]) { // near the eye, which may be within
      squares_.assign(n_squares, {0, beyond});
      return;
    }
    add(middle, extent);
  }
}

/// @param middle, half  of a box in the camera's axes
void BrickDepths::add(const Vec3& middle, const Vec3& half) {
  const double nearest = middle[2] - half[2], farthest = middle[2] + half[2];
  const double low_x = middle[0] - half[0], high_x = middle[0] + half[0], low_y = middle[1] - half[1],
               high_y = middle[1] + half[1];
  // Of a coordinate that is positive the largest is seen at the nearest depth, else at the farthest.
  const double by_near = parallel_ ? scale_ : scale_ / nearest,
               by_far = parallel_ ? scale_ : scale_ / farthest;
  const double left = middle_x_ + low_x * (low_x < 0 ? by_near : by_far),
               right = middle_x_ + high_x * (high_x > 0 ? by_near : by_far),
               top = middle_y_ - high_y * (high_y > 0 ? by_near : by_far),
               bottom = middle_y_ - low_y * (low_y < 0 ? by_near : by_far);
  const auto square = [](double pixel) { return std::floor(pixel * (1.0 / edge)); };
  const int x0 = static_cast<int>(std::max(square(left), 0.0)),
            x1 = static_cast<int>(std::min(square(right), squares_x_ - 1.0)),
            y0 = static_cast<int>(std::max(square(top), 0.0)),
            y1 = static_cast<int>(std::min(square(bottom), squares_y_ - 1.0));
  const auto from = static_cast<float>(nearest * (1 - slack)),
             to = static_cast<float>(farthest * (1 + slack));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      Range& range = squares_[static_cast<std::size_t>(x + squares_x_ * y)];
      range.nearest = std::min(range.nearest, from);
      range.farthest = std::max(range.farthest, to);
    }
}

} // namespace maille::render
