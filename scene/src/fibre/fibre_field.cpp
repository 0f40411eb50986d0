#include "maille/scene/fibre/fibre_field.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille {

namespace {

using Eigen::Matrix3d;

std::array<float, 3> largest_eigenvector(const Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(matrix);
  const Eigen::Vector3d v = solver.eigenvectors().col(2);
  return {static_cast<float>(v(0)), static_cast<float>(v(1)), static_cast<float>(v(2))};
}

/// Angle between directions without sign, 0 to pi/2; not by arc cosine, which rounds float32 to 3e-4.
double angle_between(const std::array<float, 3>& one, const std::array<float, 3>& other) {
  const Eigen::Vector3d a = Eigen::Vector3f(one.data()).cast<double>(),
                        b = Eigen::Vector3f(other.data()).cast<double>();
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// Offsets of the cells whose centres are within `radius`, by layers, for a fixed order of sums.
std::vector<Index3> offsets_within(const Grid& grid, double radius) {
  Index3 reach{0, 0, 0};
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension());
       ++a) // limits the ball to the size of the grid
    reach[a] = static_cast<int>(std::min(radius / grid.spacing()[a] * (1 + 1e-12), 1.0 * grid.cells()[a]));
  std::vector<Index3> offsets;
  for (int k = -reach[2]; k <= reach[2]; ++k)
    for (int j = -reach[1]; j <= reach[1]; ++j)
      for (int i = -reach[0]; i <= reach[0]; ++i) {
        const double distance =
            std::hypot(i * grid.spacing()[0], j * grid.spacing()[1], k * grid.spacing()[2]);
        if (distance <= radius * (1 + 1e-12)) // 3 * 0.1 is within 0.3
          offsets.push_back({i, j, k});
      }
  return offsets;
}

/// Offsets of the neighbouring cells.
std::vector<Index3> offsets_around(const Grid& grid) {
  Index3 reach{0, 0, 0};
  std::fill_n(reach.begin(), grid.dimension(), 1);
  std::vector<Index3> offsets;
  for (int k = -reach[2]; k <= reach[2]; ++k)
    for (int j = -reach[1]; j <= reach[1]; ++j)
      for (int i = -reach[0]; i <= reach[0]; ++i)
        if (Index3{i, j, k} != Index3{0, 0, 0})
          offsets.push_back({i, j, k});
  return offsets;
}

} // namespace

std::optional<std::array<float, 3>> first_eigenvector(const Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(matrix);
  const Eigen::Vector3d values = solver.eigenvalues();
  if (!(values(2) > 0) || values(2) - values(1) <= 1e-9 * values(2))
    return std::nullopt;
  const Eigen::Vector3d v = solver.eigenvectors().col(2);
  return std::array<float, 3>{static_cast<float>(v(0)), static_cast<float>(v(1)), static_cast<float>(v(2))};
}

FibreField::FibreField(Specimen& body, std::vector<std::int32_t> region, std::vector<bool> is_known)
    : body_(body), region_(std::move(region)), is_known_(std::move(is_known)) {}

Matrix3d FibreField::dyad(std::size_t cell) const {
  const auto& f = body_.fibres[cell];
  const Eigen::Vector3d v(double{f[0]}, double{f[1]}, double{f[2]});
  return v * v.transpose();
}

bool FibreField::is_known_in(std::int64_t cell, std::int32_t region) const {
  return body_.is_matter(cell) && is_known_[cell] && region_[cell] == region;
}

Matrix3d FibreField::sum_around(std::int64_t cell, std::span<const Index3> offsets) const {
  const Grid& grid = body_.grid;
  const Index3 at = grid.cell_at(cell);
  Matrix3d sum = Matrix3d::Zero();
  for (const Index3& step : offsets) {
    const Index3 other{at[0] + step[0], at[1] + step[1], at[2] + step[2]};
    if (grid.has_cell(other) && is_known_in(grid.cell(other), region_[cell]))
      sum += dyad(static_cast<std::size_t>(grid.cell(other)));
  }
  return sum;
}

double FibreField::smooth(double radius) {
  const std::vector<Index3> offsets = offsets_within(body_.grid, radius);
  std::vector<std::array<float, 3>> smooth = body_.fibres;
  double turned = 0;
  std::int64_t count = 0;
  for (std::size_t cell = 0; cell < smooth.size(); ++cell) {
    const auto number = static_cast<std::int64_t>(cell);
    if (!body_.is_matter(number) || !is_known_[cell])
      continue;
    smooth[cell] = first_eigenvector(sum_around(number, offsets)).value_or(body_.fibres[cell]);
    turned += angle_between(smooth[cell], body_.fibres[cell]);
    ++count;
  }
  body_.fibres = std::move(smooth);
  return count > 0 ? turned / static_cast<double>(count) : 0;
}

std::int64_t FibreField::fill_layer(std::vector<std::int64_t>& unknown, std::span<const Index3> offsets) {
  std::vector<std::int64_t> filled;
  std::erase_if(unknown, [&](std::int64_t cell) {
    const auto direction = first_eigenvector(sum_around(cell, offsets));
    if (direction) {
      body_.fibres[cell] = *direction;
      filled.push_back(cell);
    }
    return direction.has_value();
  });
  for (const std::int64_t cell : filled) // only now: a layer must not use its own results
    is_known_[cell] = true;
  return static_cast<std::int64_t>(filled.size());
}

void FibreField::fill(FibreReport& report) {
  std::map<std::int32_t, Matrix3d> of_region;
  Matrix3d of_body = Matrix3d::Zero();
  std::vector<std::int64_t> unknown;
  for (std::int64_t cell = 0; cell < body_.grid.n_cells(); ++cell) {
    if (!body_.is_matter(cell))
      continue;
    const std::size_t i = cell;
    if (!is_known_[i]) {
      unknown.push_back(cell);
      continue;
    }
    of_region.try_emplace(region_[i], Matrix3d::Zero()).first->second += dyad(i);
    of_body += dyad(i);
  }
  const std::vector<Index3> offsets = offsets_around(body_.grid);
  while (const std::int64_t filled = fill_layer(unknown, offsets))
    report.from_neighbours += filled;
  for (const std::int64_t cell : unknown) {
    const std::size_t i = cell;
    const auto known = of_region.find(region_[i]);
    ++(known != of_region.end() ? report.from_label : report.from_body);
    body_.fibres[i] = largest_eigenvector(known != of_region.end() ? known->second : of_body);
    is_known_[i] = true;
  }
}

} // namespace maille
