#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace maille::deform {

namespace {

/// Layers of cells per work item. Those of every second slab share no node, so the order of sums is always
/// the same.
constexpr int layers_per_slab = MaskedRows::planes_per_slab;

} // namespace

MaskedLevel::MaskedLevel(const Scene& scene, const LatticeElasticity& elasticity,
                         const std::vector<Prescribed>& prescribed, ThreadTeam& team, const Slabs& slabs)
    : matter_(scene, elasticity, slabs, team), inverse_(field()),
      sums_(static_cast<std::size_t>(slabs.own().end - slabs.own().first), 0) {
  matter_.invert_diagonal(inverse_, team);
  make_fields(true);
  set_fixed(prescribed);
}

void MaskedLevel::make_fields(bool does) {
  for (AlignedArray<float>* const each : {&u, &f, &r})
    *each = does ? field() : AlignedArray<float>();
}

void MaskedLevel::set_fixed(const std::vector<Prescribed>& prescribed) {
  for (const auto& [at, free] : fixed_)
    inverse_[at] = free;
  fixed_.clear();
  fixed_.reserve(prescribed.size());
  for (const Prescribed& p : prescribed) {
    const std::int32_t slot = matter_.slot_if_known(p.node);
    if (slot == no_index)
      continue;
    const auto at = static_cast<std::size_t>(p.component * component_stride() + slot);
    fixed_.emplace_back(at, inverse_[at]);
    inverse_[at] = 0;
  }
  set_springs(); // they do not act on fixed components
}

void MaskedLevel::renew_matter(ThreadTeam& team) {
  matter_.renew(team);
  matter_.invert_diagonal(inverse_, team);
  for (auto& [at, free] : fixed_)
    free = std::exchange(inverse_[at], 0.0F);
}

void MaskedLevel::set_springs() {
  springs_.clear();
  for (const NodalSpring& spring : matter_.elasticity().springs()) {
    SlotSpring of{rows().slot(matter_.scene().specimen.grid.node_at(spring.node)), {}};
    const auto may_move = [&](std::size_t c) {
      return inverse_[c * static_cast<std::size_t>(component_stride()) + static_cast<std::size_t>(of.slot)] >
             0;
    };
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t a = 0; a < 3; ++a)
        if (may_move(a) && may_move(b))
          of.block[3 * b + a] = static_cast<float>(
              spring.stiffness(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) /
              (matter_.unit() * matter_.scale()[a] * matter_.scale()[b]));
    springs_.push_back(of);
  }
  std::ranges::sort(springs_, {}, &SlotSpring::slot);
}

BlockMatrix MaskedLevel::springs_as_matrix() const {
  BlockMatrix matrix;
  if (springs_.empty())
    return matrix;
  matrix.first.assign(static_cast<std::size_t>(rows().n_slots()) + 1, 0);
  matrix.blocks = AlignedArray<float>(9 * springs_.size() + 16);
  for (const SlotSpring& spring : springs_) {
    std::ranges::copy(spring.block, matrix.blocks.data() + 9 * matrix.column.size());
    matrix.column.push_back(spring.slot);
    ++matrix.first[static_cast<std::size_t>(spring.slot) + 1];
  }
  std::partial_sum(matrix.first.begin(), matrix.first.end(), matrix.first.begin());
  return matrix;
}

/// Calls work(first place in a field, how many) for the three components of a plane of nodes.
template<class Work>
void MaskedLevel::for_components(int plane, const Work& work) const {
  const std::int64_t first = rows().first_slot(plane), n = rows().first_slot(plane + 1) - first;
  for (std::int64_t c = 0; c < 3; ++c)
    work(c * component_stride() + first, n);
}

/// Calls finish(plane) when the forces of a plane of nodes are complete. The plane between two slabs is
/// cleared by the first of the two to run and finished by the second. Loops over runs add zero beyond their
/// rows, so finished planes do not change. A rank uses the slabs of a single process, so its bits are the
/// same.
template<class Finish>
void MaskedLevel::apply_by_planes(const float* displacement, float* forces, ThreadTeam& team,
                                  const Finish& finish) const {
  const auto [begin, layers] = slabs().layers_of_own(); // and their end
  const int first_slab = begin / layers_per_slab, end_slab = (layers + layers_per_slab - 1) / layers_per_slab;
  const bool is_matter_alone = springs_.empty();
  const auto clear = [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) { std::fill_n(forces + at, n, 0.0F); });
  };
  const auto finish_whole = [&](int plane) {
    if (is_matter_alone && slabs().is_own(plane))
      finish(plane);
  };
  run_slabs(team, first_slab, end_slab, [&](int slab) {
    const int first = std::max(begin, slab * layers_per_slab),
              end = std::min((slab + 1) * layers_per_slab, layers);
    const bool is_first = slab % 2 == 0;
    if (is_first || slab == first_slab)
      clear(first);
    for (int z = first; z < end; ++z) {
      if (is_first || z + 1 < end || end == layers)
        clear(z + 1);
      add_matter_forces(matter_.cells(), rows().runs_of_layer(z), displacement, forces);
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
  team.run(slabs().own().end, [&](int plane, int) { finish(plane); }); // on one rank
}

void MaskedLevel::apply(const float* displacement, float* forces, ThreadTeam& team) const {
  apply_by_planes(displacement, forces, team, [](int) {});
}

double MaskedLevel::apply_and_dot(const float* p, float* Ap, ThreadTeam& team) {
  std::ranges::fill(sums_, 0);
  apply_by_planes(p, Ap, team, [&](int plane) {
    for_components(plane, [&](std::int64_t at, std::int64_t n) {
      sums_[plane - slabs().own().first] += mask_and_dot_entries(n, inverse_.data() + at, p + at, Ap + at);
    });
  });
  return sum_over_planes();
}

void MaskedLevel::set_noise(ThreadTeam& team) {
  const PlaneRange own = slabs().own();
  const std::int32_t first = rows().first_slot(own.first), end = own.end > rows().layers().end
                                                                     ? rows().n_slots_of_rows()
                                                                     : rows().first_slot(own.end);
  const std::vector<double> before = slabs().first_of_ranks(end - first);
  const auto offset = static_cast<std::int64_t>(before[slabs().rank()]) - first;
  const std::int64_t stride =
      MaskedMatter::stride_of(MaskedRows::n_slots_for(static_cast<std::int64_t>(before.back())));
  team.run(3, [&](int c, int) {
    const std::int64_t at = c * component_stride();
    noise_entries(component_stride(), c * stride + offset, inverse_.data() + at, f.data() + at);
  });
}

double MaskedLevel::dot(const float* a, const float* b, ThreadTeam& team) {
  const PlaneRange own = slabs().own();
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
      sums_[plane - slabs().own().first] +=
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
