#pragma once
/// Prescribed components at the nodes of a cell.

#include "discretization/element.hpp"

#include "maille/scene/scene.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace maille::fem_ref {

/// A node is prescribed if all of its parent corners are. For degree 2 this includes mid-points of edges,
/// faces and cells, inside the body too, with the mean of the corner values.
template<int dim>
class PrescribedInCell {
public:
  explicit PrescribedInCell(const Scene& scene)
      : grid_(scene.specimen.grid), n_nodes_(static_cast<std::size_t>(grid_.n_nodes())),
        entry_(dim * n_nodes_, none), scene_(scene) {
    for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
      if (const Prescribed& p = scene.prescribed[i]; p.component < dim)
        entry_[static_cast<std::size_t>(p.component) * n_nodes_ + static_cast<std::size_t>(p.node)] =
            static_cast<std::int32_t>(i);
  }

  /// Index of a corner's component in Scene::prescribed; `none` if the component is free.
  std::int32_t entry(const Index3& cell, int corner, unsigned component) const {
    return entry_[component * n_nodes_ + static_cast<std::size_t>(grid_.corner(cell, corner))];
  }

  /// Calls visit(node of the element, component, value) for every prescribed component of a cell.
  template<class Visit>
  void for_each(const Element<dim>& element, const Index3& cell, const Visit& visit) const {
    for (unsigned c = 0; c < dim; ++c) {
      std::array<double, 1 << dim> values{};
      bool any = false;
      for (int corner = 0; corner < (1 << dim); ++corner) {
        const std::int32_t at = entry(cell, corner, c);
        values[corner] = at == none ? std::numeric_limits<double>::quiet_NaN() : scene_.prescribed[at].value;
        any = any || at != none;
      }
      for (int i = 0; any && i < element.n_nodes(); ++i) {
        double mean = 0;
        for (const int corner : element.parents(i))
          mean += values[corner] / static_cast<double>(element.parents(i).size());
        if (!std::isnan(mean))
          visit(i, c, mean);
      }
    }
  }

  static constexpr std::int32_t none = -1;

private:
  const Grid& grid_;
  std::size_t n_nodes_;
  std::vector<std::int32_t> entry_;
  const Scene& scene_;
};

} // namespace maille::fem_ref
