// Pull and push fields for other programs, and volume ratios.

#include "maille/scene/warp/warp.hpp"
#include "mechanics/volume_ratio.hpp"
#include "warp/continuation.hpp"
#include "warp/deformed_cells.hpp"

#include <array>
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
  explicit VectorField(const ImageInfo& grid)
      : n_(static_cast<std::size_t>(grid.n_voxels())), row_(static_cast<std::size_t>(grid.size[0])) {
    image_.info = grid;
    image_.info.components = 3;
    const double x = grid.world == WorldAxes::lps ? 1 : -1;
    image_.info.vectors_to_world = {{{x, 0, 0}, {0, x, 0}, {0, 0, 1}}};
    image_.values.resize(3 * n_);
    to_world_ = millimetres * voxels_to_world(grid).linear;
    if (grid.world != WorldAxes::lps)
      to_world_ = Vector3d(-1, -1, 1).asDiagonal() * to_world_;
  }
  /// Stores a row of vectors [voxels along the image's axes] from voxel `first` on.
  void put(std::size_t first, const std::array<std::vector<float>, 3>& in_voxels) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto along = to_world_.row(static_cast<Eigen::Index>(a));
      const double of_x = along[0], of_y = along[1], of_z = along[2];
      const float *const x = in_voxels[0].data(), *const y = in_voxels[1].data(),
                         *const z = in_voxels[2].data();
      float* const to = image_.values.data() + a * n_ + first;
#pragma GCC ivdep
      for (std::size_t i = 0; i < row_; ++i)
        to[i] = static_cast<float>(of_x * double{x[i]} + of_y * double{y[i]} + of_z * double{z[i]});
    }
  }
  Image image() && {
    return std::move(image_);
  }

private:
  std::size_t n_, row_;
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

/// Extends a field from known voxels (see nearest_known) to the others by their nearest known value.
/// @param shift [voxels], n_voxels x 3 @param amended (position of an unknown voxel, shift) -> shift
template<class Amended>
Image continued(const ImageInfo& grid, const std::vector<float>& shift, std::vector<std::int32_t> known,
                Amended&& amended) {
  const std::size_t n = known.size(), row = static_cast<std::size_t>(grid.size[0]);
  const std::vector<std::int32_t> nearest = nearest_known(grid.size, std::move(known));
  VectorField field(grid);
  if (nearest.front() < 0) // none is known
    return std::move(field).image();
  std::array<std::vector<float>, 3> in_row;
  std::size_t first = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j, first += row) {
      for (std::size_t a = 0; a < 3; ++a)
        in_row[a].assign(shift.data() + a * n + first, shift.data() + a * n + first + row);
      for (std::size_t i = 0; i < row; ++i) {
        const auto from = static_cast<std::size_t>(nearest[first + i]);
        if (from == first + i)
          continue;
        const Vector3d of = amended(Vector3d(static_cast<double>(i), j, k),
                                    Vector3d(shift[from], shift[n + from], shift[2 * n + from]));
        for (std::size_t a = 0; a < 3; ++a)
          in_row[a][i] = static_cast<float>(of[static_cast<Eigen::Index>(a)]);
      }
      field.put(first, in_row);
    }
  return std::move(field).image();
}

/// Trilinear displacement at a place in a cell [m]. @param place in cells from node 0
Vector3d displacement_at(const DeformedBody& body, std::int64_t cell, const Vector3d& place) {
  const Grid& grid = body.specimen->grid;
  const Index3 at = grid.cell_at(cell);
  Vector3d u = Vector3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int a = 0; a < 3; ++a) {
      const double in_cell = place[a] - at[a];
      weight *= corner >> a & 1 ? in_cell : 1 - in_cell;
    }
    u += weight * eigen(body.displacement->at(grid.corner(at, corner)));
  }
  return u;
}

} // namespace

Image pull_field(const Pull& pull, std::span<const DeformedBody> bodies) {
  std::vector<std::int32_t> known(pull.source.size());
  for (std::size_t voxel = 0; voxel < known.size(); ++voxel)
    known[voxel] = pull.source[voxel] != Pull::nothing ? static_cast<std::int32_t>(voxel) : -1;
  const std::vector<RestCells> rest = rest_cells(pull.grid, bodies);
  const double out_of_image = -pull.grid.size[0] - 1;
  return continued(pull.grid, pull.shift, std::move(known), [&](const Vector3d& at, const Vector3d& shift) {
    // The field must not show matter a second time.
    for (const RestCells& cells : rest)
      if (cells.cell_at(at + shift) >= 0)
        return Vector3d(out_of_image - at[0], 0, 0);
    return shift;
  });
}

Image push_field(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  const std::vector<RestCells> rest = rest_cells(grid, bodies);
  std::vector<Eigen::Matrix3d> to_voxels;
  for (const DeformedBody& body : bodies)
    to_voxels.push_back(body_to_voxels(grid, body.specimen->placement).linear);
  const std::size_t n = grid.n_voxels();
  std::vector<std::int32_t> known(n, -1);
  std::vector<float> shift(3 * n, 0);
  for_each_voxel(grid, [&](std::size_t voxel, const Vector3d& at) {
    for (std::size_t b = 0; b < bodies.size() && known[voxel] < 0; ++b)
      if (const std::int64_t cell = rest[b].cell_at(at); cell >= 0) {
        known[voxel] = static_cast<std::int32_t>(voxel);
        const Vector3d u = to_voxels[b] * displacement_at(bodies[b], cell, rest[b].place(at));
        for (std::size_t a = 0; a < 3; ++a)
          shift[a * n + voxel] = static_cast<float>(u[static_cast<Eigen::Index>(a)]);
      }
  });
  return continued(grid, shift, std::move(known), [](const Vector3d&, const Vector3d& of) { return of; });
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
  image.values.assign(grid.n_voxels(), 0);
  for_each_voxel(grid, [&](std::size_t voxel, const Vector3d& at) {
    for (std::size_t b = 0; b < bodies.size(); ++b)
      if (const std::int64_t cell = rest[b].cell_at(at); cell >= 0) {
        float& ratio = of_cells[b][cell];
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
