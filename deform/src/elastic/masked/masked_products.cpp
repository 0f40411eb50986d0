#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace maille::deform {

namespace {

/// Layers of cells that are done in one go. Those of every second slab share no node, so the order of sums is
/// always the same.
constexpr int layers_per_slab = MaskedRows::planes_per_slab;

} // namespace

/// Calls work(first place in a field, how many) for the three components of a plane of nodes.
template<class Work>
void MaskedLevel::for_components(int plane, const Work& work) const {
  const std::int64_t first = rows_.first_slot(plane), n = rows_.first_slot(plane + 1) - first;
  for (std::int64_t c = 0; c < 3; ++c)
    work(c * component_stride() + first, n);
}

/// Calls finish(plane) once the forces of a plane of nodes are whole. The planes between two slabs are begun
/// by the one that comes first, and ended by the other; what loops over runs of cells add beyond their rows
/// is nothing, also to planes that are finished. A rank's slabs are those of one process, as far as its own
/// planes ask for their layers.
template<class Finish>
void MaskedLevel::apply_by_planes(const float* displacement, float* forces, ThreadTeam& team,
                                  const Finish& finish) const {
  const auto [begin, layers] = slabs_.layers_of_own(); // and their end
  const int first_slab = begin / layers_per_slab, slabs = (layers + layers_per_slab - 1) / layers_per_slab;
  const bool is_matter_alone = springs_.empty();
  const auto clear = [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) { std::fill_n(forces + at, n, 0.0F); });
  };
  const auto finish_whole = [&](int plane) {
    if (is_matter_alone && slabs_.is_own(plane))
      finish(plane);
  };
  run_slabs(team, first_slab, slabs, [&](int slab) {
    const int first = std::max(begin, slab * layers_per_slab),
              end = std::min((slab + 1) * layers_per_slab, layers);
    const bool is_first = slab % 2 == 0;
    if (is_first || slab == first_slab)
      clear(first);
    for (int z = first; z < end; ++z) {
      if (is_first || z + 1 < end || end == layers)
        clear(z + 1);
      add_matter_forces(operator_, rows_.runs_of_layer(z), displacement, forces);
      if (!is_first || z > first || z == begin)
        finish_whole(z);
    }
    if (!is_first || end == layers)
      finish_whole(end);
  });
  if (is_matter_alone)
    return;
  const std::int64_t stride = component_stride();
  for (const SlotSpring& spring : springs_)
    for (std::int64_t a = 0; a < 3; ++a) {
      float pull = 0;
      for (std::int64_t b = 0; b < 3; ++b)
        pull += spring.block[3 * b + a] * displacement[b * stride + spring.slot];
      forces[a * stride + spring.slot] += pull;
    }
  team.run(slabs_.own().end, [&](int plane, int) { finish(plane); }); // on one rank
}

void MaskedLevel::apply(const float* displacement, float* forces, ThreadTeam& team) const {
  apply_by_planes(displacement, forces, team, [](int) {});
}

double MaskedLevel::apply_and_dot(const float* p, float* Ap, ThreadTeam& team) {
  std::ranges::fill(sums_, 0);
  apply_by_planes(p, Ap, team, [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) {
      sums_[plane - slabs_.own().first] += mask_and_dot_entries(n, inverse_.data() + at, p + at, Ap + at);
    });
  });
  return sum_over_planes();
}

void MaskedLevel::set_noise(ThreadTeam& team) {
  const PlaneRange own = slabs_.own();
  const std::int32_t first = rows_.first_slot(own.first),
                     end = own.end > rows_.layers().end ? rows_.n_slots_of_rows() : rows_.first_slot(own.end);
  const std::vector<double> before = slabs_.first_of_ranks(end - first);
  const auto offset = static_cast<std::int64_t>(before[slabs_.rank()]) - first;
  const std::int64_t stride = stride_of(MaskedRows::n_slots_for(static_cast<std::int64_t>(before.back())));
  team.run(3, [&](int c, int) {
    const std::int64_t at = c * component_stride();
    noise_entries(component_stride(), c * stride + offset, inverse_.data() + at, f.data() + at);
  });
}

double MaskedLevel::dot(const float* a, const float* b, ThreadTeam& team) {
  const PlaneRange own = slabs_.own();
  team.run(own.end - own.first, [&](int item, int) {
    double& sum = sums_[item];
    sum = 0;
    for_components(own.first + item,
                   [&](std::int64_t at, std::int64_t n) { sum += dot_entries(n, a + at, b + at); });
  });
  return sum_over_planes();
}

void MaskedLevel::relax(float weight, ThreadTeam& team) {
  apply_by_planes(u.data(), r.data(), team, [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) {
      step_from_entries(n, weight, inverse_.data() + at, f.data() + at, u.data() + at, r.data() + at);
    });
  });
  std::swap(u, r);
}

double MaskedLevel::relax_and_dot(float weight, ThreadTeam& team) {
  std::ranges::fill(sums_, 0);
  apply_by_planes(u.data(), r.data(), team, [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) {
      sums_[plane - slabs_.own().first] +=
          step_and_dot_entries(n, weight, inverse_.data() + at, f.data() + at, u.data() + at, r.data() + at);
    });
  });
  std::swap(u, r);
  return sum_over_planes();
}

void MaskedLevel::find_residual(ThreadTeam& team) {
  apply_by_planes(u.data(), r.data(), team, [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) {
      subtract_entries(n, inverse_.data() + at, f.data() + at, r.data() + at);
    });
  });
}

} // namespace maille::deform
