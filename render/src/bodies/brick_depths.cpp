#include "bodies/brick_depths.hpp"
#include "maille/base/vectors.hpp"

#include "data/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace maille::render {

namespace {

constexpr float beyond = 1e30f;
constexpr double slack = 1e-5;          ///< of depths, because rays are in single precision
constexpr double box_slack = 0.02;      ///< [voxels], for the same reason
constexpr std::size_t few_boxes = 2048; ///< too few for a second thread to pay off
constexpr int edge_cells = Volume::brick_edge, edge_nodes = edge_cells + 1;

/// Range of codes of each cell of a brick.
class CellRanges {
public:
  CellRanges(const Volume& volume, const Index3& brick) {
    const Index3& size = volume.grid().size;
    const auto node = [&](std::size_t a, int i) {
      return std::int64_t{1} * std::min(edge_cells * brick[a] + i, size[a] - 1);
    };
    std::size_t out = 0;
    for (int k = 0; k < edge_nodes; ++k)
      for (int j = 0; j < edge_nodes; ++j)
        for (int i = 0; i < edge_nodes; ++i, ++out) {
          const std::int64_t voxel = node(0, i) + size[0] * (node(1, j) + size[1] * node(2, k));
          const auto code = static_cast<std::uint16_t>(
              volume.depth() == Volume::Depth::bits8 ? volume.codes8()[voxel] : volume.codes16()[voxel]);
          of_[out] = {code, code};
        }
    // Along each axis in turn, combines every number with the next one.
    for (const std::size_t stride :
         {std::size_t{1}, std::size_t{edge_nodes}, std::size_t{edge_nodes * edge_nodes}})
      for (std::size_t at = 0; at + stride < of_.size(); ++at)
        of_[at] = {std::min(of_[at].least, of_[at + stride].least),
                   std::max(of_[at].largest, of_[at + stride].largest)};
  }
  const Volume::Range& at(int i, int j, int k) const { return of_[i + edge_nodes * (j + edge_nodes * k)]; }

private:
  std::array<Volume::Range, static_cast<std::size_t>(edge_nodes* edge_nodes* edge_nodes)> of_;
};

} // namespace

std::vector<SeenBox> seen_boxes(const Volume& volume, const TransferTable& table, const Look& look,
                                const std::vector<std::uint8_t>& distances, int threads) {
  const Index3 n = volume.bricks(), size = volume.grid().size;
  const Index3 stride{1, n[0], n[0] * n[1]};
  std::vector<std::uint8_t> is_full(distances.size(), 0);
  for (std::size_t brick = 0; brick < distances.size(); ++brick)
    is_full[brick] =
        distances[brick] == 0 && is_all_visible(volume.brick_ranges()[brick], table, look, volume) ? 1 : 0;
  const auto is_at_end = [&](const Index3& at, std::size_t brick) {
    for (std::size_t a = 0; a < 3; ++a)
      if (at[a] == 0 || at[a] == n[a] - 1 || is_full[brick - static_cast<std::size_t>(stride[a])] == 0 ||
          is_full[brick + static_cast<std::size_t>(stride[a])] == 0)
        return true;
    return false;
  };
  const auto box_of = [&](const Index3& low, const Index3& high) { // cells; high is exclusive
    SeenBox box{};
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = std::min(low[a], size[a] - 1);
      box.high[a] = std::min(high[a], size[a] - 1);
    }
    return box;
  };
  std::vector<std::vector<SeenBox>> in_plane(n[2]);
  for_each_item(threads, n[2], [&](int plane, int) {
    Index3 at{0, 0, plane};
    std::size_t brick = static_cast<std::size_t>(stride[2]) * plane;
    for (at[1] = 0; at[1] < n[1]; ++at[1])
      for (at[0] = 0; at[0] < n[0]; ++at[0], ++brick) {
        if (distances[brick] != 0 || (is_full[brick] != 0 && !is_at_end(at, brick)))
          continue;
        const Index3 first{edge_cells * at[0], edge_cells * at[1], edge_cells * at[2]},
            end{first[0] + edge_cells, first[1] + edge_cells, first[2] + edge_cells};
        // Isosurfaces between samples are searched from the samples around them.
        if (is_full[brick] != 0 || look.mode == LookMode::isosurface) {
          in_plane[plane].push_back(box_of(first, end));
          continue;
        }
        const CellRanges ranges(volume, at);
        Index3 low = end, high = first;
        for (int k = 0; k < edge_cells; ++k)
          for (int j = 0; j < edge_cells; ++j)
            for (int i = 0; i < edge_cells; ++i)
              if (is_visible(ranges.at(i, j, k), table, look, volume)) {
                const Index3 cell{first[0] + i, first[1] + j, first[2] + k};
                for (std::size_t a = 0; a < 3; ++a) {
                  low[a] = std::min(low[a], cell[a]);
                  high[a] = std::max(high[a], cell[a] + 1);
                }
              }
        if (low[0] < high[0])
          in_plane[plane].push_back(box_of(low, high));
      }
  });
  std::vector<SeenBox> boxes;
  for (const auto& of_plane : in_plane)
    boxes.insert(boxes.end(), of_plane.begin(), of_plane.end());
  return boxes;
}

BrickDepths::BrickDepths(const VoxelGrid& grid, const std::vector<SeenBox>& boxes, const Pose& pose,
                         const View& view, int threads)
    : squares_x_((view.width + edge - 1) / edge), squares_y_((view.height + edge - 1) / edge),
      parallel_(view.camera.parallel), middle_x_(0.5 * view.width - 0.5), middle_y_(0.5 * view.height - 0.5) {
  const Camera& camera = view.camera;
  scale_ = 0.5 * view.height / camera.half_height();
  const auto axes = camera.axes();
  const auto seen = [&](const Vec3& index) {
    return times(axes, minus(pose.to_world(grid.point_of(index)), camera.position));
  };
  const Vec3 first = seen({0, 0, 0});
  const std::array<Vec3, 3> along{minus(seen({1, 0, 0}), first), minus(seen({0, 1, 0}), first),
                                  minus(seen({0, 0, 1}), first)};
  const auto n_squares = static_cast<std::size_t>(squares_x_) * squares_y_;
  const int n_parts = boxes.size() < few_boxes ? 1 : threads;
  std::vector<std::vector<Range>> parts(n_parts);
  std::atomic<bool> is_near = false; // the eye may be inside
  for_each_item(n_parts, n_parts, [&](int part, int) {
    const auto p = static_cast<std::size_t>(part), n = static_cast<std::size_t>(n_parts);
    parts[p].assign(n_squares, {beyond, -beyond});
    for (std::size_t b = boxes.size() * p / n; b < boxes.size() * (p + 1) / n && !is_near; ++b) {
      const SeenBox& box = boxes[b];
      Vec3 middle = first, half_box{};
      for (std::size_t a = 0; a < 3; ++a) {
        const double half_edge = 0.5 * (box.high[a] - box.low[a]);
        middle = plus(middle, times(box.low[a] + half_edge, along[a]));
        for (std::size_t c = 0; c < 3; ++c)
          half_box[c] += (half_edge + box_slack) * std::abs(along[a][c]);
      }
      if (middle[2] <= 2 * half_box[2])
        is_near = true;
      else
        add(middle, half_box, parts[p]);
    }
  });
  squares_ = std::move(parts[0]);
  if (is_near)
    squares_.assign(n_squares, {0, beyond});
  for (std::size_t p = 1; p < parts.size() && !is_near; ++p)
    for (std::size_t s = 0; s < n_squares; ++s) {
      squares_[s].nearest = std::min(squares_[s].nearest, parts[p][s].nearest);
      squares_[s].farthest = std::max(squares_[s].farthest, parts[p][s].farthest);
    }
}

/// @param middle, half  centre and half size of a box, in the camera's axes
void BrickDepths::add(const Vec3& middle, const Vec3& half, std::vector<Range>& squares) const {
  const double nearest = middle[2] - half[2], farthest = middle[2] + half[2];
  const double low_x = middle[0] - half[0], high_x = middle[0] + half[0], low_y = middle[1] - half[1],
               high_y = middle[1] + half[1];
  // The projection of a positive coordinate is largest at the nearest depth, a negative one at the farthest.
  const double by_near = parallel_ ? scale_ : scale_ / nearest,
               by_far = parallel_ ? scale_ : scale_ / farthest;
  const double left = middle_x_ + low_x * (low_x < 0 ? by_near : by_far),
               right = middle_x_ + high_x * (high_x > 0 ? by_near : by_far),
               top = middle_y_ - high_y * (high_y > 0 ? by_near : by_far),
               bottom = middle_y_ - low_y * (low_y < 0 ? by_near : by_far);
  const auto square = [](double pixel, int n) {
    return static_cast<int>(std::clamp(std::floor(pixel * (1.0 / edge)), -1.0, 1.0 * n));
  };
  const int x0 = std::max(square(left, squares_x_), 0),
            x1 = std::min(square(right, squares_x_), squares_x_ - 1),
            y0 = std::max(square(top, squares_y_), 0),
            y1 = std::min(square(bottom, squares_y_), squares_y_ - 1);
  const auto from = static_cast<float>(nearest * (1 - slack)),
             to = static_cast<float>(farthest * (1 + slack));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      Range& range = squares[x + squares_x_ * y];
      range.nearest = std::min(range.nearest, from);
      range.farthest = std::max(range.farthest, to);
    }
}

} // namespace maille::render
