#include "maille/studies/pareto.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace maille::studies {

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error))
      order.push_back(i);
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(points[i].cost, points[i].error); });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity(); // error of what costs no more
  for (const std::size_t i : order) {
    const bool is_alike = !front.empty() && points[front.back()].cost == points[i].cost &&
                          points[front.back()].error == points[i].error;
    if (points[i].error < best || is_alike)
      front.push_back(i);
    best = std::min(best, points[i].error);
  }
  return front;
}

} // namespace maille::studies
