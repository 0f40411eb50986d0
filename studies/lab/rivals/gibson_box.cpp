#include "rivals/gibson_box.hpp"

namespace maille::lab {

GibsonElements::GibsonElements(const Scene& scene, const LinkLimits& limits)
    : elements_(static_cast<std::size_t>(scene.specimen.grid.n_nodes())) {
  const Grid& grid = scene.specimen.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    const LinkIntervals<double> link = limits.intervals({0, 0, 0}, static_cast<int>(a)).value();
    for (std::size_t b = 0; b < 3; ++b) {
      least_[2 * a + 1][b] = static_cast<float>(link.low[b]);
      greatest_[2 * a + 1][b] = static_cast<float>(link.high[b]);
      least_[2 * a][b] = -greatest_[2 * a + 1][b];
      greatest_[2 * a][b] = -least_[2 * a + 1][b];
    }
  }
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    auto& neighbour = elements_[static_cast<std::size_t>(node)].neighbour;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t stride = grid.stride(static_cast<int>(a));
      neighbour[2 * a] = at[a] > 0 ? static_cast<std::int32_t>(node - stride) : -1;
      neighbour[2 * a + 1] = at[a] + 1 < grid.nodes()[a] ? static_cast<std::int32_t>(node + stride) : -1;
    }
  }
}

void GibsonElements::offer(std::int32_t node, std::size_t direction) {
  if (const std::int32_t other = elements_[static_cast<std::size_t>(node)].neighbour[direction]; other >= 0)
    list_[direction].push_back({other, node});
}

bool GibsonElements::follow(const Candidate& candidate, std::size_t direction) {
  const Element& sponsor = elements_[static_cast<std::size_t>(candidate.sponsor)];
  Element& element = elements_[static_cast<std::size_t>(candidate.node)];
  bool has_moved = false;
  for (std::size_t b = 0; b < 3; ++b) {
    const float least = sponsor.u[b] + least_[direction][b],
                greatest = sponsor.u[b] + greatest_[direction][b];
    const float raised = element.u[b] < least ? least : element.u[b];
    const float followed = raised > greatest ? greatest : raised;
    has_moved |= followed != element.u[b];
    element.u[b] = followed;
  }
  return has_moved;
}

std::int64_t GibsonElements::move_to(std::int64_t node, const Vec3& displacement) {
  for (std::size_t b = 0; b < 3; ++b)
    elements_[static_cast<std::size_t>(node)].u[b] = static_cast<float>(displacement[b]);
  for (std::size_t direction = 0; direction < 6; ++direction)
    offer(static_cast<std::int32_t>(node), direction);
  std::array<std::size_t, 6> head{};
  std::int64_t visited = 0;
  for (bool any = true; any;) {
    any = false;
    for (std::size_t direction = 0; direction < 6; ++direction) {
      auto& list = list_[direction];
      for (std::size_t& next = head[direction]; next < list.size(); ++next) {
        any = true;
        const Candidate candidate = list[next]; // a copy: the list may grow
        if (!follow(candidate, direction))
          continue;
        offer(candidate.node, direction);
        for (std::size_t onward = 2 * (direction / 2 + 1); onward < 6; ++onward)
          offer(candidate.node, onward);
      }
      visited += static_cast<std::int64_t>(list.size());
      list.clear();
      head[direction] = 0;
    }
  }
  return visited;
}

GibsonBox::GibsonBox(const Scene& scene, const LinkLimits& limits)
    : n_(scene.specimen.grid.nodes()),
      state_(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), Node{}) {
  for (std::size_t a = 0; a < 3; ++a) {
    const LinkIntervals<double> link = limits.intervals({0, 0, 0}, static_cast<int>(a)).value();
    for (std::size_t b = 0; b < 3; ++b) {
      low_[a][b] = static_cast<float>(link.low[b]);
      high_[a][b] = static_cast<float>(link.high[b]);
    }
  }
}

std::size_t GibsonBox::number(Place place) const {
  constexpr Place mask = (1 << bits) - 1;
  const std::size_t x = place & mask, y = place >> bits & mask, z = place >> 2 * bits;
  return x + static_cast<std::size_t>(n_[0]) * (y + static_cast<std::size_t>(n_[1]) * z);
}

void GibsonBox::offer(Place place, int direction) {
  const int axis = direction / 2, shift = axis * bits;
  const int at = static_cast<int>(place >> shift & ((1 << bits) - 1));
  const bool is_ahead = direction % 2 == 1;
  if (is_ahead ? at + 1 < n_[static_cast<std::size_t>(axis)] : at > 0)
    list_[static_cast<std::size_t>(direction)].push_back(is_ahead ? place + (1U << shift)
                                                                  : place - (1U << shift));
}

bool GibsonBox::follow(const Node& sponsor, Node& node, int direction) const {
  const auto axis = static_cast<std::size_t>(direction / 2);
  const bool is_ahead = direction % 2 == 1;
  bool has_moved = false;
  for (std::size_t b = 0; b < 3; ++b) {
    const float least = sponsor[b] + (is_ahead ? low_[axis][b] : -high_[axis][b]);
    const float greatest = sponsor[b] + (is_ahead ? high_[axis][b] : -low_[axis][b]);
    const float raised = node[b] < least ? least : node[b];
    const float followed = raised > greatest ? greatest : raised;
    has_moved |= followed != node[b];
    node[b] = followed;
  }
  return has_moved;
}

std::int64_t GibsonBox::move_to(std::int64_t node, const Vec3& displacement) {
  Node& handle = state_[static_cast<std::size_t>(node)];
  for (std::size_t b = 0; b < 3; ++b)
    handle[b] = static_cast<float>(displacement[b]);
  const auto at = static_cast<std::size_t>(node);
  const auto nx = static_cast<std::size_t>(n_[0]), ny = static_cast<std::size_t>(n_[1]);
  const auto place = static_cast<Place>(at % nx | at / nx % ny << bits | at / nx / ny << 2 * bits);
  for (int direction = 0; direction < 6; ++direction)
    offer(place, direction);

  const std::array<std::ptrdiff_t, 3> stride{1, n_[0], std::ptrdiff_t{1} * n_[0] * n_[1]};
  std::array<std::size_t, 6> head{};
  std::int64_t visited = 0;
  for (bool any = true; any;) {
    any = false;
    for (int direction = 0; direction < 6; ++direction) {
      auto& list = list_[static_cast<std::size_t>(direction)];
      std::size_t& next = head[static_cast<std::size_t>(direction)];
      const int axis = direction / 2;
      const std::ptrdiff_t to_sponsor =
          stride[static_cast<std::size_t>(axis)] * (direction % 2 == 1 ? -1 : 1);
      for (; next < list.size(); ++next) {
        any = true;
        const Place candidate = list[next];
        Node& moved = state_[number(candidate)];
        if (!follow(*(&moved + to_sponsor), moved, direction))
          continue;
        offer(candidate, direction);
        for (int onward = 2 * (axis + 1); onward < 6; ++onward)
          offer(candidate, onward);
      }
      visited += static_cast<std::int64_t>(list.size());
      list.clear();
      next = 0;
    }
  }
  return visited;
}

} // namespace maille::lab
