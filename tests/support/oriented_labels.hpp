#pragma once
/// One segmented body, at the same world position, stored in arrays of every orientation and memory order.

#include "maille/scene/scene_builder.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille::test {

/// Orientation of an array relative to another: its axis a is axis[a] of the other, reversed if flipped.
struct Orientation {
  std::array<std::size_t, 3> axis{0, 1, 2};
  std::array<bool, 3> flipped{};
};

/// All 48 orientations.
inline std::vector<Orientation> all_orientations() {
  std::vector<Orientation> all;
  std::array<std::size_t, 3> axis{0, 1, 2};
  do
    for (unsigned flips = 0; flips < 8; ++flips)
      all.push_back({axis, {(flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0}});
  while (std::next_permutation(axis.begin(), axis.end()));
  return all;
}

/// Labels of voxels, x fastest, and voxel positions [m]. All numbers of the affine are exact in float32.
struct LabelArray {
  Index3 size{};
  std::vector<int> values;
  Affine affine{};

  int at(const Index3& i) const {
    return values[std::size_t(i[0] + std::int64_t{size[0]} * (i[1] + std::int64_t{size[1]} * i[2]))];
  }
};

/// A bent body of labels 17 and 5 in 5 x 4 x 3 voxels of 2, 3 and 5 mm, which touches only one border,
/// oblique in the world.
inline LabelArray bent_body() {
  LabelArray body{{5, 4, 3}, std::vector<int>(60, 0), {}};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i)
        if ((i >= 1 && i <= 3 && j <= 1) || (i == 3 && k == 1 && j == 2))
          body.values[std::size_t(i + 5 * (j + 4 * k))] = j == 0 ? 17 : 5;
  const double c = std::cos(0.5), s = std::sin(0.5), d = std::cos(0.3), e = std::sin(0.3);
  const std::array<Vec3, 3> turn{{{c, -s * d, s * e}, {s, c * d, -c * e}, {0, e, d}}};
  body.affine = affine_of({2e-3, 3e-3, 5e-3}, {0.01, -0.02, 0.03}, turn);
  for (auto& row : body.affine)
    for (double& number : row)
      number = double(float(number));
  return body;
}

/// The same voxels at the same positions, in an array of another orientation; positions are rounded to
/// float32.
inline LabelArray turned(const LabelArray& body, const Orientation& to) {
  LabelArray array;
  Vec3 origin{body.affine[0][3], body.affine[1][3], body.affine[2][3]};
  for (std::size_t a = 0; a < 3; ++a) {
    array.size[a] = body.size[to.axis[a]];
    for (std::size_t r = 0; r < 3; ++r) {
      const double step = body.affine[r][to.axis[a]];
      array.affine[r][a] = to.flipped[a] ? -step : step;
      origin[r] += to.flipped[a] ? step * (array.size[a] - 1) : 0;
    }
  }
  for (std::size_t r = 0; r < 3; ++r)
    array.affine[r][3] = double(float(origin[r]));
  array.affine[3] = {0, 0, 0, 1};
  for (int k = 0; k < array.size[2]; ++k)
    for (int j = 0; j < array.size[1]; ++j)
      for (int i = 0; i < array.size[0]; ++i) {
        const Index3 at{i, j, k};
        Index3 in_body{};
        for (std::size_t a = 0; a < 3; ++a)
          in_body[to.axis[a]] = to.flipped[a] ? array.size[a] - 1 - at[a] : at[a];
        array.values.push_back(body.at(in_body));
      }
  return array;
}

/// An array in memory with permuted and partly reversed axes, and gaps filled with 99.
template<class Label>
struct Stored {
  std::vector<Label> elements;
  ArrayLayout layout;
};

template<class Label>
Stored<Label> stored(const LabelArray& array, const Orientation& order) {
  Stored<Label> memory;
  memory.layout.size = array.size;
  std::int64_t step = 2; // every second element is a gap
  for (std::size_t place = 0; place < 3; ++place) {
    const std::size_t a = order.axis[place];
    memory.layout.stride[a] = order.flipped[place] ? -step : step;
    memory.layout.first += order.flipped[place] ? step * (array.size[a] - 1) : 0;
    step *= array.size[a];
  }
  memory.elements.assign(std::size_t(step), Label{99});
  for (int k = 0; k < array.size[2]; ++k)
    for (int j = 0; j < array.size[1]; ++j)
      for (int i = 0; i < array.size[0]; ++i)
        memory.elements[std::size_t(memory.layout.element({i, j, k}))] =
            static_cast<Label>(array.at({i, j, k}));
  return memory;
}

} // namespace maille::test
