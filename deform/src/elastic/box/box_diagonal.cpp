#include "elastic/box/box_diagonal.hpp"

#include "lattice/field_memory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace maille::deform {

namespace {

std::size_t of(int i) {
  return static_cast<std::size_t>(i);
}

} // namespace

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
  return sum + k.edge[c] * own.link * second.share() * third.share() +
         k.twist_self[c] * own.mass * second.link * third.link;
}

double largest_eigenvalue_of_block(const BoxCoefficients& coefficients, const Index3& cells) {
  constexpr int steps = 60;       // of the power method; it comes from below
  constexpr double margin = 1.05; // for what is left then
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
  return margin * largest;
}

} // namespace maille::deform
