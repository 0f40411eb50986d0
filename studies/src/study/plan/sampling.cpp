#include "study/plan/sampling.hpp"

#include <boost/random/sobol.hpp>

#include <numeric>
#include <random>

namespace maille::studies {

UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed) {
  std::mt19937_64 lot(seed);
  UnitPoints points(static_cast<std::size_t>(n), std::vector<double>(static_cast<std::size_t>(dimensions)));
  std::vector<std::size_t> slice(n);
  for (int d = 0; d < dimensions; ++d) {
    std::iota(slice.begin(), slice.end(), std::size_t{0});
    for (std::size_t i = slice.size(); i > 1; --i)
      std::swap(slice[i - 1], slice[lot() % i]);
    for (std::size_t i = 0; i < slice.size(); ++i) {
      // Never at an end of the slice, where rounding could move it into the next one.
      const double within = (static_cast<double>(lot() >> 34U) + 0.5) * 0x1p-30;
      points[i][d] = (static_cast<double>(slice[i]) + within) / n;
    }
  }
  return points;
}

UnitPoints sobol_points(int n, int dimensions) {
  UnitPoints points;
  if (dimensions == 0)
    return UnitPoints(static_cast<std::size_t>(n));
  boost::random::sobol sequence(static_cast<std::size_t>(dimensions)); // starts after the origin
  for (int i = 0; i < n; ++i) {
    std::vector<double>& point = points.emplace_back(static_cast<std::size_t>(dimensions), 0.0);
    if (i > 0)
      for (double& coordinate : point)
        coordinate = static_cast<double>(sequence() >> 11U) * 0x1p-53;
  }
  return points;
}

UnitPoints saltelli_points(int n, int dimensions) {
  UnitPoints points;
  for (const std::vector<double>& pair : sobol_points(n, 2 * dimensions)) {
    const std::vector<double> a(pair.begin(), pair.begin() + dimensions),
        b(pair.begin() + dimensions, pair.end());
    points.push_back(a);
    points.push_back(b);
    for (std::size_t d = 0; d < a.size(); ++d) {
      points.push_back(a);
      points.back()[d] = b[d];
    }
  }
  return points;
}

} // namespace maille::studies
