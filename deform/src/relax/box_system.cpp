#include "relax/box_system.hpp"

#include "maille/deform/lattice/aligned_array.hpp"

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

} // namespace maille::deform
