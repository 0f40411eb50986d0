#include "world/surface/smooth_surface.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace maille::deform {

namespace {

constexpr double width = 1; ///< of the Gaussian, and largest motion of a corner [cells]
constexpr int reach = 7;    ///< of the wider Gaussian: five times its width [cells]

/// A Gaussian mean of the volume fraction, and its gradient per cell.
struct Mean {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// Integrals of a Gaussian about a place over cells along one axis, and their derivatives by the place.
struct Parts {
  int first = 0;
  std::array<double, 2 * reach + 1> part{}, change{};
};

Parts parts_about(double place, double deviation) {
  Parts parts;
  parts.first = static_cast<int>(std::floor(place)) - reach;
  const auto below = [&](int edge) {
    return 0.5 * std::erfc(-(edge - place) / (deviation * std::numbers::sqrt2));
  };
  const auto density = [&](int edge) {
    const double z = (edge - place) / deviation;
    return std::exp(-0.5 * z * z) / (deviation * std::sqrt(2 * std::numbers::pi));
  };
  for (int i = 0; i <= 2 * reach; ++i) {
    const auto k = static_cast<std::size_t>(i);
    parts.part[k] = below(parts.first + i + 1) - below(parts.first + i);
    parts.change[k] = density(parts.first + i) - density(parts.first + i + 1);
  }
  return parts;
}

Mean gaussian_mean(const Specimen& body, const Eigen::Vector3d& place, double deviation) {
  const Grid& grid = body.grid;
  std::array<Parts, 3> along;
  Index3 first{0, 0, 0}, last{0, 0, 0};
  for (int a = 0; a < grid.dimension(); ++a) {
    along[a] = parts_about(place[static_cast<Eigen::Index>(a)], deviation);
    first[a] = std::max(0, along[a].first);
    last[a] = std::min(grid.cells()[a] - 1, along[a].first + 2 * reach);
  }
  if (grid.dimension() == 2)
    along[2].part[0] = 1; // one layer
  Mean mean;
  Index3 at;
  for (at[2] = first[2]; at[2] <= last[2]; ++at[2])
    for (at[1] = first[1]; at[1] <= last[1]; ++at[1])
      for (at[0] = first[0]; at[0] <= last[0]; ++at[0]) {
        if (!body.is_matter(grid.cell(at)))
          continue;
        const auto k = [&](std::size_t a) { return static_cast<std::size_t>(at[a] - along[a].first); };
        const double x = along[0].part[k(0)], y = along[1].part[k(1)], z = along[2].part[k(2)];
        mean.value += x * y * z;
        mean.gradient += Eigen::Vector3d(along[0].change[k(0)] * y * z, x * along[1].change[k(1)] * z,
                                         x * y * along[2].change[k(2)]);
      }
  return mean;
}

/// Level function of the smooth surface: 1/2 on the surface.
Mean mean_at(const Specimen& body, const Eigen::Vector3d& place) {
  const Mean narrow = gaussian_mean(body, place, width),
             wide = gaussian_mean(body, place, std::numbers::sqrt2 * width);
  return {2 * narrow.value - wide.value, 2 * narrow.gradient - wide.gradient};
}

/// Point on the smooth surface, along the gradient of the mean. @param corner in cells
std::optional<Eigen::Vector3d> on_surface(const Specimen& body, const Eigen::Vector3d& corner) {
  Eigen::Vector3d place = corner;
  for (int step = 0; step < iteration_cap; ++step) {
    const Mean mean = mean_at(body, place);
    const double missing = 0.5 - mean.value;
    if (std::abs(missing) < tolerance)
      return place;
    Eigen::Vector3d way = missing * mean.gradient / std::max(mean.gradient.squaredNorm(), 1e-12);
    way *= std::min(1.0, 0.5 * width / way.norm());
    place += way;
    if ((place - corner).norm() > width)
      break;
  }
  return std::nullopt;
}

} // namespace

void make_smooth(const Specimen& body, std::vector<Eigen::Vector3d>& corners) {
  const Grid& grid = body.grid;
  const int d = grid.dimension();
  const Eigen::Vector3d spacing = Eigen::Vector3d::Map(grid.spacing().data());
  // The box may have been cropped to the matter, symmetrically about the middle.
  const Vec3 cut = body.position({0, 0, 0});
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), axes = Eigen::Vector3d::Ones();
  for (int a = 0; a < d; ++a) {
    middle[a] = 0.5 * grid.cells()[a] * spacing[a];
    axes[a] = middle[a] + cut[a];
  }
  for (Eigen::Vector3d& corner : corners) {
    if (body.shape == "ellipsoid") {
      const Eigen::Vector3d from_middle = corner - middle;
      corner = middle + from_middle / from_middle.cwiseQuotient(axes).norm();
    } else if (const auto place = on_surface(body, corner.cwiseQuotient(spacing))) {
      corner = place->cwiseProduct(spacing);
    }
  }
}

} // namespace maille::deform
