// The fields that other programs carry images and points with, and how much larger matter has become.

#include "maille/scene/warp/warp.hpp"
#include "mechanics/volume_ratio.hpp"
#include "warp/continuation.hpp"
#include "warp/deformed_cells.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace maille {

namespace {

using namespace warping;
using Eigen::Vector3d;

constexpr double millimetres = 1e3;

/// An image of vectors [mm] along left, posterior, superior.
class VectorField {
public:
  explicit VectorField(const ImageInfo& grid) : n_(static_cast<std::size_t>(grid.n_voxels())) {
    image_.info = grid;
    image_.info.components = 3;
    image_.values.assign(3 * n_, 0);
    to_world_ = millimetres * voxels_to_world(grid).linear;
    if (grid.world != WorldAxes::lps)
      to_world_ = Vector3d(-1, -1, 1).asDiagonal() * to_world_;
  }
  void put(std::size_t voxel, const Vector3d& in_voxels) {
    const Vector3d v = to_world_ * in_voxels;
    for (std::size_t a = 0; a < 3; ++a)
      image_.values[a * n_ + voxel] = static_cast<float>(v[static_cast<Eigen::Index>(a)]);
  }
  Image image() && { return std::move(image_); }

private:
  std::size_t n_;
  Image image_;
  Eigen::Matrix3d to_world_;
};

std::vector<RestCells> rest_cells(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  std::vector<RestCells> cells;
  for (const DeformedBody& body : bodies) {
    check(body);
    cells.emplace_back(grid, *body.specimen);
  }
  return cells;
}

/// The displacement of a place in a cell, trilinear in its corners' [m]. @param place in cells, from node 0
/// on
Vector3d displacement_at(const DeformedBody& body, std::int64_t cell, const Vector3d& place) {
  const Grid& grid = body.specimen->grid;
  const Index3 at = grid.cell_at(cell);
  Vector3d u = Vector3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const double in_cell = place[a] - at[static_cast<std::size_t>(a)];
      weight *= corner >> a & 1 ? in_cell : 1 - in_cell;
    }
    u += weight * eigen(body.displacement->at(grid.corner(at, corner)));
  }
  return u;
}

} // namespace

Image pull_field(const Pull& pull, std::span<const DeformedBody> bodies) {
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  std::vector<bool> is_known(n);
  for (std::size_t voxel = 0; voxel < n; ++voxel)
    is_known[voxel] = pull.source[voxel] != Pull::nothing;
  const std::vector<std::int32_t> nearest = nearest_known(pull.grid.size, is_known);
  const std::vector<RestCells> rest = rest_cells(pull.grid, bodies);
  VectorField field(pull.grid);
  for_each_voxel(pull.grid, [&](std::size_t voxel, const Vector3d& at) {
    if (nearest[voxel] < 0)
      return;
    const auto from = static_cast<std::size_t>(nearest[voxel]);
    Vector3d shift(pull.shift[from], pull.shift[n + from], pull.shift[2 * n + from]);
    if (!is_known[voxel]) // what is seen there must not be matter a second time
      for (const RestCells& cells : rest)
        if (cells.cell_at(at + shift) >= 0) {
          shift = {-at[0] - pull.grid.size[0] - 1, 0, 0};
          break;
        }
    field.put(voxel, shift);
  });
  return std::move(field).image();
}

Image push_field(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  const std::vector<RestCells> rest = rest_cells(grid, bodies);
  std::vector<Eigen::Matrix3d> to_voxels;
  for (const DeformedBody& body : bodies)
    to_voxels.push_back(body_to_voxels(grid, body.specimen->placement).linear);
  const auto n = static_cast<std::size_t>(grid.n_voxels());
  std::vector<bool> is_known(n, false);
  std::vector<float> shift(3 * n, 0);
  for_each_voxel(grid, [&](std::size_t voxel, const Vector3d& at) {
    for (std::size_t b = 0; b < bodies.size() && !is_known[voxel]; ++b)
      if (const std::int64_t cell = rest[b].cell_at(at); cell >= 0) {
        is_known[voxel] = true;
        const Vector3d u = to_voxels[b] * displacement_at(bodies[b], cell, rest[b].place(at));
        for (std::size_t a = 0; a < 3; ++a)
          shift[a * n + voxel] = static_cast<float>(u[static_cast<Eigen::Index>(a)]);
      }
  });
  const std::vector<std::int32_t> nearest = nearest_known(grid.size, is_known);
  VectorField field(grid);
  for (std::size_t voxel = 0; voxel < n; ++voxel)
    if (nearest[voxel] >= 0) {
      const auto from = static_cast<std::size_t>(nearest[voxel]);
      field.put(voxel, {shift[from], shift[n + from], shift[2 * n + from]});
    }
  return std::move(field).image();
}

Image volume_ratio(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  const std::vector<RestCells> rest = rest_cells(grid, bodies);
  std::vector<std::vector<float>> of_cells; // 0: not found yet
  std::vector<VolumeRatio> ratios;
  for (const DeformedBody& body : bodies) {
    of_cells.emplace_back(static_cast<std::size_t>(body.specimen->grid.n_cells()), 0.0F);
    ratios.emplace_back(body.specimen->grid);
  }
  Image image;
  image.info = grid;
  image.info.components = 1;
  image.values.assign(static_cast<std::size_t>(grid.n_voxels()), 0);
  for_each_voxel(grid, [&](std::size_t voxel, const Vector3d& at) {
    for (std::size_t b = 0; b < bodies.size(); ++b)
      if (const std::int64_t cell = rest[b].cell_at(at); cell >= 0) {
        float& ratio = of_cells[b][static_cast<std::size_t>(cell)];
        if (ratio == 0)
          ratio = static_cast<float>(ratios[b](
              [&](std::int64_t node, std::int64_t) { return bodies[b].displacement->at(node); }, cell));
        image.values[voxel] = ratio;
        break;
      }
  });
  return image;
}

} // namespace maille
