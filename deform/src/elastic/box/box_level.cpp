#include "elastic/box/box_level.hpp"

#include "elastic/box/box_multigrid.hpp"

#include "elastic/model/thin_cells.hpp"
#include "elastic/multigrid/chebyshev.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace maille::deform {

namespace {

std::size_t of(int i) {
  return static_cast<std::size_t>(i);
}

/// Diagonals of the operators along one axis at one node (see BoxCoefficients).
struct BoxDiagonal {
  double mass = 0, link = 0, change = 0;

  BoxDiagonal(const BoxAxis<double>& axis, int i)
      : mass(axis.mass[i - 1] + axis.mass[i]), link(axis.link[i - 1] + axis.link[i]),
        change((axis.mass[i - 1] > 0 ? 1 : 0) - (axis.mass[i] > 0 ? 1 : 0)) {}
  double share() const { return mass / 2; }
};

/// The diagonal of component c of a node.
double box_diagonal(const BoxCoefficients& k, int c, const BoxDiagonal& x, const BoxDiagonal& y,
                    const BoxDiagonal& z) {
  const auto& s = k.strain;
  const auto twice = [&](int a, int b) { return s[c][a][c][b] + s[c][b][c][a]; };
  double sum = s[c][0][c][0] * x.link * y.mass * z.mass + s[c][1][c][1] * x.mass * y.link * z.mass +
               s[c][2][c][2] * x.mass * y.mass * z.link;
  sum += twice(0, 1) * x.change * y.change * z.mass + twice(0, 2) * x.change * y.mass * z.change +
         twice(1, 2) * x.mass * y.change * z.change;
  const BoxDiagonal* const axes[3] = {&x, &y, &z};
  const BoxDiagonal &own = *axes[c], &second = *axes[(c + 1) % 3], &third = *axes[(c + 2) % 3];
  for (int across = 0; across < 3; ++across)
    if (k.bends[across] && across != c) {
      const auto& bending = k.bending[across][c];
      const int a = (across + 1) % 3, b = (across + 2) % 3;
      sum += axes[across]->link * (bending[a][c][a] * axes[a]->link * axes[b]->mass +
                                   bending[b][c][b] * axes[a]->mass * axes[b]->link +
                                   (bending[a][c][b] + bending[b][c][a]) * axes[a]->change * axes[b]->change);
    }
  return sum + k.edge[c] * own.link * second.share() * third.share() +
         k.twist_self[c] * own.mass * second.link * third.link;
}

Index3 cells_between(const std::array<std::vector<double>, 3>& place) {
  const auto along = [&](std::size_t a) { return static_cast<int>(place[a].size()) - 1; };
  return {along(0), along(1), along(2)};
}

/// Upper estimate of the largest eigenvalue of the operator over its diagonal, on a small box of regular
/// cells. A larger box is a sum of such boxes and has no larger eigenvalue.
double largest_eigenvalue_of_block(const BoxCoefficients& coefficients, const Index3& cells) {
  constexpr int steps = 60; // of the power method; it comes from below
  BoxOperator A;
  A.coefficients = coefficients;
  std::array<AlignedArray<double>, 3> axis;
  for (int a = 0; a < 3; ++a) {
    A.nodes[a] = cells[of(a)] + 1;
    axis[of(a)] = AlignedArray<double>(of(4 * line_of_floats));
    std::fill_n(axis[of(a)].data() + line_of_floats, cells[of(a)], 1.0);
    A.axis[a] = {axis[of(a)].data() + line_of_floats, axis[of(a)].data() + line_of_floats};
  }
  A.end_of_regular_lines = 0;
  AlignedArray<double> scratch(static_cast<std::size_t>(box_scratch_bytes(A)) / sizeof(double));
  const int in_plane = A.nodes[0] * A.nodes[1], n = in_plane * A.nodes[2];
  std::vector<double> u(of(3 * n)), next(u.size()), diagonal, plane(of(3 * in_plane));
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < n; ++i)
      diagonal.push_back(box_diagonal(coefficients, c, BoxDiagonal(A.axis[0], i % A.nodes[0]),
                                      BoxDiagonal(A.axis[1], i / A.nodes[0] % A.nodes[1]),
                                      BoxDiagonal(A.axis[2], i / in_plane)));
  std::mt19937 random(1);
  for (double& value : u)
    value = static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5;
  double largest = 0;
  for (int step = 0; step < steps; ++step) {
    double work = 0, size = 0;
    for (int z = 0; z < A.nodes[2]; ++z) {
      apply_box(A, z, u.data(), plane.data(), scratch.data());
      for (int i = 0; i < 3 * in_plane; ++i)
        next[of(i / in_plane * n + z * in_plane + i % in_plane)] = plane[of(i)];
    }
    for (std::size_t i = 0; i < u.size(); ++i) {
      work += u[i] * next[i];
      size += u[i] * diagonal[i] * u[i];
      u[i] = next[i] / diagonal[i];
    }
    largest = work / size; // Rayleigh's quotient
    const double scale = 1 / std::sqrt(size);
    for (double& value : u)
      value *= scale;
  }
  return safety_of_eigenvalue * largest;
}

} // namespace

BoxLevel::BoxLevel(const Stiffness& C, std::array<std::vector<double>, 3> place, double unit, FixedMask fixed,
                   const BoxLevel* finer)
    : C_(C), place_(std::move(place)), unit_(unit), fixed_(std::move(fixed)),
      thin_(finer != nullptr ? finer->thin_ : thin_axes_of_box(cells_between(place_))) {
  lay_out_axes();
  operator_.coefficients = BoxCoefficients(
      C, {place_[0][1] - place_[0][0], place_[1][1] - place_[1][0], place_[2][1] - place_[2][0]}, unit,
      thin_);
  invert_diagonal();
  find_largest_eigenvalue(finer);
  u = PaddedArray(field_size());
  f = PaddedArray(field_size());
  r = PaddedArray(field_size());
}

void BoxLevel::lay_out_axes() {
  BoxOperator& A = operator_;
  for (int a = 0; a < 3; ++a) {
    const auto& place = place_[of(a)];
    A.nodes[a] = static_cast<int>(place.size());
    const auto size = of(static_cast<int>(padded_row(A.nodes[a])) + 2 * line_of_floats);
    auto &mass = axes_[of(2 * a)], &link = axes_[of(2 * a + 1)];
    mass = AlignedArray<double>(size);
    link = AlignedArray<double>(size);
    A.axis[a] = {mass.data() + line_of_floats, link.data() + line_of_floats};
    for (int i = 0; i + 1 < A.nodes[a]; ++i) {
      const double length = place[of(i + 1)] - place[of(i)], regular = place[1] - place[0];
      const bool is_regular = std::abs(length - regular) < 1e-6 * regular; // but for rounding
      mass[of(line_of_floats + i)] = is_regular ? 1 : length / regular;
      link[of(line_of_floats + i)] = is_regular ? 1 : regular / length;
    }
  }
  const auto x_size = of(static_cast<int>(padded_row(A.nodes[0])) + line_of_floats);
  for (auto& values : x_axis_)
    values = PaddedArray(x_size);
  for (int i = 0; i + 1 < A.nodes[0]; ++i) {
    x_axis_[0].data()[i] = static_cast<float>(A.axis[0].mass[i]);
    x_axis_[1].data()[i] = static_cast<float>(A.axis[0].link[i]);
  }
  A.x_axis = {x_axis_[0].data(), x_axis_[1].data()};
  const bool is_last_regular = A.axis[0].mass[A.nodes[0] - 2] == 1;
  A.end_of_regular_lines = (A.nodes[0] - (is_last_regular ? 1 : 2)) / line_of_floats;
  A.row_stride = padded_row(A.nodes[0]);
  A.slab_stride = A.row_stride * A.nodes[1];
  A.component_stride = A.slab_stride * A.nodes[2];
}

/// The eigenvalue of the finer level, if all axes were coarsened alike.
void BoxLevel::find_largest_eigenvalue(const BoxLevel* finer) {
  constexpr int largest_block = 4;
  bool is_alike = finer != nullptr;
  for (std::size_t a = 0; a < 3; ++a) {
    block_[a] = std::min(largest_block, operator_.nodes[a] - 1);
    is_alike = is_alike && block_[a] == finer->block_[a];
    const auto spacing = [a](const BoxLevel& level) { return level.place_[a][1] - level.place_[a][0]; };
    is_alike = is_alike && std::abs(spacing(*this) - 2 * spacing(*finer)) < 1e-6 * spacing(*this);
  }
  largest_eigenvalue_ =
      is_alike ? finer->largest_eigenvalue_ : largest_eigenvalue_of_block(operator_.coefficients, block_);
}

/// Kinds of positions along an axis; positions of one kind have the same diagonals.
std::vector<int> BoxLevel::kinds_along(int axis) const {
  std::vector<BoxDiagonal> kinds;
  std::vector<int> kind_of;
  for (int i = 0; i < operator_.nodes[axis]; ++i) {
    const BoxDiagonal here(operator_.axis[axis], i);
    const auto is_same = [&](const BoxDiagonal& k) {
      return k.mass == here.mass && k.link == here.link && k.change == here.change;
    };
    const auto known = std::ranges::find_if(kinds, is_same);
    kind_of.push_back(static_cast<int>(known - kinds.begin()));
    if (known == kinds.end())
      kinds.push_back(here);
  }
  return kind_of;
}

const float* BoxLevel::inverse_row(int c, int y, int z, const std::string& key, bool has_fixed) {
  const auto [place, is_new] = rows_.try_emplace(key);
  if (!is_new)
    return place->second.data();
  const BoxOperator& A = operator_;
  const BoxDiagonal of_y(A.axis[1], y), of_z(A.axis[2], z);
  const std::int64_t first = A.nodes[0] * (y + std::int64_t{1} * A.nodes[1] * z);
  place->second = PaddedArray(static_cast<std::size_t>(A.row_stride));
  for (int x = 0; x < A.nodes[0]; ++x)
    if (!has_fixed || !fixed_(c, first + x))
      place->second.data()[x] =
          static_cast<float>(1 / box_diagonal(A.coefficients, c, BoxDiagonal(A.axis[0], x), of_y, of_z));
  return place->second.data();
}

/// Rows differ by their kinds along y and z, and by their fixed nodes; many rows share memory.
void BoxLevel::invert_diagonal() {
  const BoxOperator& A = operator_;
  const std::vector<int> along_y = kinds_along(1), along_z = kinds_along(2);
  const auto n_y = of(1 + *std::ranges::max_element(along_y)),
             n_z = of(1 + *std::ranges::max_element(along_z));
  const FixedMask in_rows = fixed_.of_rows(of(A.nodes[0]));
  std::vector<const float*> of_kinds(3 * n_y * n_z, nullptr); // of rows with nothing fixed
  std::string key;
  for (int c = 0; c < 3; ++c) {
    List<const float*>& inverse = inverse_rows_[of(c)];
    inverse.reserve(in_rows.n_nodes());
    for (int z = 0; z < A.nodes[2]; ++z)
      for (int y = 0; y < A.nodes[1]; ++y) {
        const int kinds[] = {c, along_y[of(y)], along_z[of(z)]};
        const auto row = of(y) + of(A.nodes[1]) * of(z);
        const bool has_fixed = in_rows(c, row);
        const float*& plain = of_kinds[(of(c) * n_y + of(kinds[1])) * n_z + of(kinds[2])];
        if (!has_fixed && plain != nullptr) {
          inverse.push_back(plain);
          continue;
        }
        key.assign(reinterpret_cast<const char*>(kinds), sizeof kinds);
        for (int x = 0; has_fixed && x < A.nodes[0]; ++x)
          key.push_back(fixed_(c, of(A.nodes[0]) * row + of(x)) ? '1' : '0');
        inverse.push_back(inverse_row(c, y, z, key, has_fixed));
        if (!has_fixed)
          plain = inverse.back();
      }
    operator_.inverse[c] = inverse.data();
    ComponentwiseOperator& component = components_[of(c)];
    std::copy(A.nodes, A.nodes + 3, component.nodes);
    component.row_stride = A.row_stride;
    component.slab_stride = A.slab_stride;
    component.inverse_diagonal = A.inverse[c];
  }
}

std::array<bool, 3> axes_to_coarsen(const Index3& nodes, const BoxCoefficients& coefficients) {
  double strength[3] = {0, 0, 0}, strongest = 0;
  for (int a = 0; a < 3; ++a)
    if (nodes[of(a)] > 2) {
      for (int i = 0; i < 3; ++i)
        strength[a] += coefficients.strain[i][a][i][a];
      strongest = std::max(strongest, strength[a]);
    }
  return {strength[0] > 0 && strength[0] >= share_of_strongest * strongest,
          strength[1] > 0 && strength[1] >= share_of_strongest * strongest,
          strength[2] > 0 && strength[2] >= share_of_strongest * strongest};
}

std::uint8_t BoxLevel::coarse_fixed_at(int x, int y, int z) const {
  const auto& t = *transfer_;
  const auto fixed_at = [&](int i, int j, int k) {
    return fixed_.at(of(i) + of(operator_.nodes[0]) * (of(j) + of(operator_.nodes[1]) * of(k)));
  };
  double weight[3] = {0, 0, 0}, all = 0;
  for (int k = 0; k < t[2].count(z); ++k)
    for (int j = 0; j < t[1].count(y); ++j)
      for (int i = 0; i < t[0].count(x); ++i) {
        const double w = t[0].hat(x, i) * t[1].hat(y, j) * t[2].hat(z, k);
        const std::uint8_t bits = fixed_at(t[0].first(x) + i, t[1].first(y) + j, t[2].first(z) + k);
        all += w;
        for (int c = 0; c < 3; ++c)
          weight[c] += bits & (1 << c) ? w : 0;
      }
  int bits = fixed_at(t[0].fine_place(x), t[1].fine_place(y), t[2].fine_place(z));
  for (int c = 0; c < 3; ++c)
    if (2 * weight[c] >= all)
      bits |= 1 << c;
  return static_cast<std::uint8_t>(bits);
}

FixedMask BoxLevel::coarse_fixed() const {
  const auto& t = *transfer_;
  const int nx = t[0].n_coarse(), ny = t[1].n_coarse(), nz = t[2].n_coarse();
  FixedMask coarse(of(nx) * of(ny) * of(nz));
  const FixedMask in_rows = fixed_.of_rows(of(operator_.nodes[0])); // most have none
  const auto is_near_fixed = [&](int y, int z) {
    for (int k = 0; k < t[2].count(z); ++k)
      for (int j = 0; j < t[1].count(y); ++j)
        if (in_rows.at(of(t[1].first(y) + j) + of(operator_.nodes[1]) * of(t[2].first(z) + k)) != 0)
          return true;
    return false;
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      if (is_near_fixed(y, z))
        for (int x = 0; x < nx; ++x)
          coarse.fix(of(x) + of(nx) * (of(y) + of(ny) * of(z)), coarse_fixed_at(x, y, z));
  return coarse;
}

std::unique_ptr<BoxLevel> BoxLevel::coarser() {
  const auto coarsens =
      axes_to_coarsen({operator_.nodes[0], operator_.nodes[1], operator_.nodes[2]}, operator_.coefficients);
  if (std::ranges::find(coarsens, true) == coarsens.end())
    return nullptr;
  transfer_ = std::make_unique<std::array<AxisCoarsening, 3>>(
      std::array{AxisCoarsening(place_[0], coarsens[0]), AxisCoarsening(place_[1], coarsens[1]),
                 AxisCoarsening(place_[2], coarsens[2])});
  const auto& t = *transfer_;
  auto next = std::make_unique<BoxLevel>(
      C_, std::array{t[0].coarse_place(), t[1].coarse_place(), t[2].coarse_place()}, unit_, coarse_fixed(),
      this);
  fixed_ = {};
  next->set_relaxation(static_cast<int>(relaxation_.size()));
  return next;
}

void BoxLevel::set_relaxation(int steps) {
  relaxation_ = chebyshev_weights(largest_eigenvalue_, steps);
}

void* BoxLevel::scratch() const {
  const auto bytes = static_cast<std::size_t>(box_scratch_bytes(operator_));
  return scratch_of_thread<double, BoxLevel>(bytes / sizeof(double) + 1);
}

void BoxLevel::restrict_to(const BoxLevel& coarser, int z, const float* from, float* to) const {
  const auto transfer = views(*transfer_);
  for (int c = 0; c < 3; ++c)
    restrict_plane(coarser.component(c), component(c), transfer.data(), z,
                   from + c * operator_.component_stride, to + c * coarser.operator_.component_stride,
                   static_cast<float*>(scratch()));
}

void BoxLevel::prolong_from(const BoxLevel& coarser, int z, const float* from, bool replaces,
                            float* to) const {
  const auto transfer = views(*transfer_);
  for (int c = 0; c < 3; ++c)
    prolong_plane(coarser.component(c), component(c), transfer.data(), z,
                  from + c * coarser.operator_.component_stride, replaces,
                  to + c * operator_.component_stride, static_cast<float*>(scratch()));
}

const double* BoxMultigrid::forces_of_plane(const Displacement& u, int z) const {
  double* const forces = scratch_of_thread<double, BoxMultigrid>(3 * in_plane());
  apply_box(finest().A(), z, u.values().data(), forces, finest().scratch());
  return forces;
}

} // namespace maille::deform
