#include "relax/box_level.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

std::size_t of(int i) {
  return static_cast<std::size_t>(i);
}

/// Sums over the cells of a node of what the operators along an axis have on their diagonals.
struct Diagonal {
  double mass = 0, link = 0, change = 0;
  double share() const { return mass / 2; }

  Diagonal(const BoxAxis<double>& axis, int i)
      : mass(axis.mass[i - 1] + axis.mass[i]), link(axis.link[i - 1] + axis.link[i]),
        change((axis.mass[i - 1] > 0 ? 1 : 0) - (axis.mass[i] > 0 ? 1 : 0)) {}
};

/// Of component c of a node.
double diagonal_of(const BoxCoefficients& k, int c, const Diagonal& x, const Diagonal& y, const Diagonal& z) {
  const auto& s = k.strain;
  const auto twice = [&](int a, int b) { return s[c][a][c][b] + s[c][b][c][a]; };
  double sum = s[c][0][c][0] * x.link * y.mass * z.mass + s[c][1][c][1] * x.mass * y.link * z.mass +
               s[c][2][c][2] * x.mass * y.mass * z.link;
  sum += twice(0, 1) * x.change * y.change * z.mass + twice(0, 2) * x.change * y.mass * z.change +
         twice(1, 2) * x.mass * y.change * z.change;
  const Diagonal* const axes[3] = {&x, &y, &z};
  const Diagonal &own = *axes[c], &second = *axes[(c + 1) % 3], &third = *axes[(c + 2) % 3];
  return sum + k.edge[c] * own.link * second.share() * third.share() +
         k.twist_self[c] * own.mass * second.link * third.link;
}

} // namespace

BoxLevel::BoxLevel(const Stiffness& C, std::array<std::vector<double>, 3> place, double unit,
                   FixedComponents fixed)
    : C_(C), place_(std::move(place)), unit_(unit), fixed_(std::move(fixed)) {
  lay_out_axes();
  operator_.coefficients = BoxCoefficients(
      C, {place_[0][1] - place_[0][0], place_[1][1] - place_[1][0], place_[2][1] - place_[2][0]}, unit);
  invert_diagonal();
  largest_eigenvalue_ = largest_eigenvalue_of_cell(operator_.coefficients);
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
  A.end_of_regular_lines = std::max(0, A.nodes[0] - 2) / line_of_floats;
  A.row_stride = padded_row(A.nodes[0]);
  A.slab_stride = A.row_stride * A.nodes[1];
  A.component_stride = A.slab_stride * A.nodes[2];
}

/// Rows differ by their place along y and z, of which there are few kinds, and by what is fixed in them: many share one.
const float* BoxLevel::inverse_row(int c, int y, int z) {
  const BoxOperator& A = operator_;
  const int nx = A.nodes[0];
  const Diagonal of_y(A.axis[1], y), of_z(A.axis[2], z);
  const double kind[] = {
      static_cast<double>(c), of_y.mass, of_y.link, of_y.change, of_z.mass, of_z.link, of_z.change};
  std::string key(reinterpret_cast<const char*>(kind), sizeof kind);
  const std::uint8_t* const fixed = fixed_.data() + nx * (y + std::int64_t{1} * A.nodes[1] * z);
  const std::uint8_t bit = static_cast<std::uint8_t>(1 << c);
  const bool has_fixed = std::any_of(fixed, fixed + nx, [&](std::uint8_t bits) { return (bits & bit) != 0; });
  for (int x = 0; has_fixed && x < nx; ++x)
    key.push_back((fixed[x] & bit) != 0 ? '1' : '0');
  const auto [place, is_new] = rows_.try_emplace(std::move(key));
  if (is_new) {
    place->second = PaddedArray(static_cast<std::size_t>(A.row_stride));
    for (int x = 0; x < nx; ++x)
      if ((fixed[x] & bit) == 0)
        place->second.data()[x] =
            static_cast<float>(1 / diagonal_of(A.coefficients, c, Diagonal(A.axis[0], x), of_y, of_z));
  }
  return place->second.data();
}

void BoxLevel::invert_diagonal() {
  for (int c = 0; c < 3; ++c) {
    for (int z = 0; z < operator_.nodes[2]; ++z)
      for (int y = 0; y < operator_.nodes[1]; ++y)
        inverse_rows_[of(c)].push_back(inverse_row(c, y, z));
    operator_.inverse[c] = inverse_rows_[of(c)].data();
    SeparableOperator& component = components_[of(c)];
    std::copy(operator_.nodes, operator_.nodes + 3, component.nodes);
    component.row_stride = operator_.row_stride;
    component.slab_stride = operator_.slab_stride;
    component.inverse_diagonal = operator_.inverse[c];
  }
}

std::array<bool, 3> BoxLevel::axes_to_coarsen() const {
  constexpr double enough = 0.35; // of the strongest: semicoarsening below
  double strength[3] = {0, 0, 0}, strongest = 0;
  for (int a = 0; a < 3; ++a)
    if (operator_.nodes[a] > 2) {
      for (int i = 0; i < 3; ++i)
        strength[a] += operator_.coefficients.strain[i][a][i][a];
      strongest = std::max(strongest, strength[a]);
    }
  return {strength[0] > 0 && strength[0] >= enough * strongest,
          strength[1] > 0 && strength[1] >= enough * strongest,
          strength[2] > 0 && strength[2] >= enough * strongest};
}

FixedComponents BoxLevel::coarse_fixed() const {
  const auto& t = *transfer_;
  const BoxOperator& A = operator_;
  const std::int64_t nx = t[0].n_coarse(), ny = t[1].n_coarse(), nz = t[2].n_coarse();
  FixedComponents coarse(static_cast<std::size_t>(nx * ny * nz), 0);
  std::size_t target = 0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x, ++target) {
        double weight[3] = {0, 0, 0}, all = 0;
        for (int k = 0; k < t[2].count(z); ++k)
          for (int j = 0; j < t[1].count(y); ++j)
            for (int i = 0; i < t[0].count(x); ++i) {
              const double w = t[0].hat(x, i) * t[1].hat(y, j) * t[2].hat(z, k);
              const std::int64_t node =
                  t[0].first(x) + i +
                  A.nodes[0] * (t[1].first(y) + j + std::int64_t{1} * A.nodes[1] * (t[2].first(z) + k));
              all += w;
              for (int c = 0; c < 3; ++c)
                weight[c] += fixed_[static_cast<std::size_t>(node)] & (1 << c) ? w : 0;
            }
        const std::int64_t same =
            t[0].fine_place(x) +
            A.nodes[0] * (t[1].fine_place(y) + std::int64_t{1} * A.nodes[1] * t[2].fine_place(z));
        coarse[target] = fixed_[static_cast<std::size_t>(same)];
        for (int c = 0; c < 3; ++c)
          if (weight[c] > 0 && 2 * weight[c] >= all)
            coarse[target] = static_cast<std::uint8_t>(coarse[target] | 1 << c);
      }
  return coarse;
}

std::unique_ptr<BoxLevel> BoxLevel::coarser() {
  const auto coarsens = axes_to_coarsen();
  if (std::ranges::find(coarsens, true) == coarsens.end())
    return nullptr;
  transfer_ = std::make_unique<std::array<AxisCoarsening, 3>>(
      std::array{AxisCoarsening(place_[0], coarsens[0]), AxisCoarsening(place_[1], coarsens[1]),
                 AxisCoarsening(place_[2], coarsens[2])});
  const auto& t = *transfer_;
  auto next = std::make_unique<BoxLevel>(
      C_, std::array{t[0].coarse_place(), t[1].coarse_place(), t[2].coarse_place()}, unit_, coarse_fixed());
  fixed_ = {};
  return next;
}

double largest_eigenvalue_of_cell(const BoxCoefficients& coefficients) {
  BoxOperator A;
  A.coefficients = coefficients;
  AlignedArray<double> ones(of(4 * line_of_floats));
  ones[of(line_of_floats)] = 1;
  for (int a = 0; a < 3; ++a) {
    A.nodes[a] = 2;
    A.axis[a] = {ones.data() + line_of_floats, ones.data() + line_of_floats};
  }
  A.end_of_regular_lines = 0;
  AlignedArray<double> scratch(static_cast<std::size_t>(box_scratch_bytes(A)) / sizeof(double));
  Eigen::Matrix<double, 24, 24> K;
  for (int column = 0; column < 24; ++column) {
    Eigen::Matrix<double, 24, 1> unit = Eigen::Matrix<double, 24, 1>::Zero();
    unit[column] = 1;
    const double* const components[3] = {unit.data(), unit.data() + 8, unit.data() + 16};
    for (int z = 0; z < 2; ++z) {
      double forces[12];
      apply_box(A, z, components, forces, scratch.data());
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 4; ++i)
          K(8 * c + 4 * z + i, column) = forces[4 * c + i];
    }
  }
  const Eigen::Matrix<double, 24, 1> scale = K.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, 24, 24> scaled = scale.asDiagonal() * K * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 24, 24>>(scaled, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

std::int64_t BoxLevel::bytes() const {
  std::size_t sum = u.bytes() + f.bytes() + r.bytes() + fixed_.capacity();
  for (const auto& axis : axes_)
    sum += axis.bytes();
  for (const auto& [key, row] : rows_)
    sum += key.size() + row.bytes();
  for (const auto& rows : inverse_rows_)
    sum += rows.size() * sizeof(const float*);
  return static_cast<std::int64_t>(sum);
}

} // namespace maille::deform
