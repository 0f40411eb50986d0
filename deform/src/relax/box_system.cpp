#include "relax/box_system.hpp"

#include "maille/deform/lattice/aligned_array.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

double* plane_buffer(std::size_t size) {
  thread_local AlignedArray<double> buffer;
  if (buffer.size() < size)
    buffer = AlignedArray<double>(size);
  return buffer.data();
}

} // namespace

std::size_t BoxSystem::in_plane() const {
  const BoxOperator& A = multigrid_.finest().A();
  return static_cast<std::size_t>(A.nodes[0]) * static_cast<std::size_t>(A.nodes[1]);
}

void BoxSystem::apply(const Displacement& u, Displacement& forces) {
  const double* const components[3] = {u.component[0].data(), u.component[1].data(), u.component[2].data()};
  const BoxLevel& level = multigrid_.finest();
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    const std::size_t n = in_plane(), first = n * static_cast<std::size_t>(z);
    double* const plane = plane_buffer(3 * n);
    apply_box(level.A(), z, components, plane, multigrid_.scratch());
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < n; ++i)
        forces.component[b][first + i] = unit_ * plane[b * n + i];
  });
}

void BoxSystem::stiffen(const std::vector<StiffenedLink>& links) {
  std::vector<StiffenedLink> in_units = links;
  for (StiffenedLink& link : in_units)
    link.stiffness /= unit_;
  multigrid_.stiffen(std::move(in_units));
}

double BoxSystem::precondition(const Displacement& residual, Displacement& correction) {
  BoxLevel& level = multigrid_.finest();
  const BoxOperator& A = level.A();
  const auto nx = static_cast<std::size_t>(A.nodes[0]);
  if (!(scale_ > 0)) {
    for (const auto& component : residual.component)
      for (const double value : component)
        scale_ = std::max(scale_, std::abs(value) / unit_);
    if (!(scale_ > 0))
      scale_ = 1;
  }
  const auto for_rows = [&](const auto& visit) {
    multigrid_.team_for(level).run(A.nodes[2], [&](int z, int) {
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < A.nodes[1]; ++y)
          visit(static_cast<std::size_t>(c), level.offset(c, 0, y, z),
                in_plane() * static_cast<std::size_t>(z) + nx * static_cast<std::size_t>(y));
    });
  };
  const double to_level = 1 / (scale_ * unit_);
  for_rows([&](std::size_t c, std::int64_t at, std::size_t node) {
    float* const row = level.f.data() + at;
    const double* const from = residual.component[c].data() + node;
    for (std::size_t x = 0; x < nx; ++x)
      row[x] = static_cast<float>(from[x] * to_level);
  });
  const double product = multigrid_.precondition();
  for_rows([&](std::size_t c, std::int64_t at, std::size_t node) {
    const float* const row = level.u.data() + at;
    double* const to = correction.component[c].data() + node;
    for (std::size_t x = 0; x < nx; ++x)
      to[x] = scale_ * double{row[x]};
  });
  return product * scale_ * scale_ * unit_;
}

} // namespace maille::deform
