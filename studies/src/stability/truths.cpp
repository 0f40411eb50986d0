#include "stability/truths.hpp"

#include <numeric>

namespace maille::studies {

namespace {

bool is_elastic(std::string_view method) {
  return method == "coupled" || method.starts_with("fem");
}

/// Every component of every node of the body from where it rests.
template<class At>
Displacement displacement_of(const Scene& scene, const At& at) {
  Displacement u(scene.specimen.grid);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 place = grid.node_at(node);
    if (!scene.specimen.is_node(place))
      continue;
    const Vec3 value = at(place);
    for (int b = 0; b < grid.dimension(); ++b)
      u(b, node) = value[static_cast<std::size_t>(b)];
  }
  return u;
}

} // namespace

Truth uniform_strain(const Vec3& strain, int axis) {
  return [=](const Scene& scene, std::string_view method) {
    return displacement_of(scene, [&](const Index3& node) {
      const Vec3 x = scene.specimen.position(node);
      Vec3 u{};
      for (std::size_t b = 0; b < 3; ++b)
        u[b] = is_elastic(method) || static_cast<int>(b) == axis ? strain[b] * x[b] : 0;
      return u;
    });
  };
}

Truth in_series(const std::vector<double>& stiffness, double by) {
  return [=](const Scene& scene, std::string_view) {
    std::vector<double> sum{0};
    for (const double k : stiffness)
      sum.push_back(sum.back() + 1 / k);
    return displacement_of(scene, [&](const Index3& node) {
      return Vec3{by * sum[static_cast<std::size_t>(node[0])] / sum.back(), 0, 0};
    });
  };
}

Truth shift(const Vec3& by, bool has_slack) {
  return [=](const Scene& scene, std::string_view method) -> std::optional<Displacement> {
    if (has_slack && !is_elastic(method) && method != "relaxed")
      return std::nullopt;
    return displacement_of(scene, [&](const Index3&) { return by; });
  };
}

Truth rigid_turn() {
  return [](const Scene& scene, std::string_view) {
    return displacement_of(scene, [&](const Index3& node) {
      return scene.turns[0].displacement(scene.specimen.position(node));
    });
  };
}

} // namespace maille::studies
